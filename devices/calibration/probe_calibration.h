// What a qualification leaves: the calibration file's text, a contract between whoever qualifies a probe and whoever uses it.
//
//   A JSON object, all of whose keys are there:
//   {"palpate":"calibration","schema":1,"date":"2026-01-31T12:00:00Z",
//    "tool":{"ball_diameter_mm":2,"stylus":{"diameter_mm":1,"length_mm":20}|null,"holder":…|null,"axis":[0,0,1]},
//    "feed_mm_per_s":5,"sphere_diameter_mm":25,"touches":50,"effective_radius_mm":0.95,
//    "lobing_mm":[12 numbers, as LobingMap::coefficients_mm],
//    "rms_mm":0.0007,"repeatability_mm":0.0006,"form_error_mm":0.0025,"raw_form_error_mm":0.04}
// Numbers have as many digits as read back to the same bits. "schema" rises when a key is removed, added, or means something else.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "devices/calibration/qualification.h"
#include "planner/tool_shape.h"

namespace palpate {

inline constexpr int kCalibrationSchema = 1;

// A calibration that cannot be used. The message begins with the file's name where there is one.
class CalibrationError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

struct ProbeCalibration {
    std::string date;            // ISO 8601: "2026-01-31", or with the time of day; the caller's clock
    ToolShape tool;              // that it belongs to
    double feed_mm_per_s = 0.0;  // > 0: of the touches that count, as later ones have to have
    double sphere_diameter_mm = 0.0;
    std::size_t touches = 0;  // that the map rests on
    double effective_radius_mm = 0.0;
    LobingMap lobing;     // its axis is the tool's
    double rms_mm = 0.0;  // these as in Qualification
    double repeatability_mm = 0.0;
    double form_error_mm = 0.0;
    double raw_form_error_mm = 0.0;
};

[[nodiscard]] ProbeCalibration calibration_of(const Qualification& qualification, const ReferenceSphere& sphere, const ToolShape& tool,
                                              double feed_mm_per_s, const std::string& date);

// Ends with a line feed. Throws CalibrationError if a number or the date makes no sense: what is written can be read.
[[nodiscard]] std::string to_json(const ProbeCalibration& calibration);

// `name`: of the file, for messages. Throws CalibrationError on a damaged text, another schema, keys that are missing or unknown, and
// numbers that make no sense.
[[nodiscard]] ProbeCalibration parse_calibration(const std::string& text, const std::string& name);

// Throws CalibrationError if it was made with another ball, stylus or axis, or at another feed: lobes depend on all of them.
void require_fits(const ProbeCalibration& calibration, const ToolShape& tool, double feed_mm_per_s, const std::string& name);

// Both.
[[nodiscard]] ProbeCalibration parse_calibration(const std::string& text, const std::string& name, const ToolShape& tool,
                                                 double feed_mm_per_s);

}  // namespace palpate
