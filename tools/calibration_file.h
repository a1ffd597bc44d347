// The calibration that a configuration names: read, and judged before it is used.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "config/session_config.h"

namespace palpate {

using CalendarTime = std::chrono::system_clock::time_point;

// "2026-01-31T12:00:00Z"
[[nodiscard]] std::string date_text(CalendarTime time);

// mm/s: the feed of the touches that count: of the first one, or of the slow ones whose median counts.
[[nodiscard]] double counting_feed(const MachineSettings& machine);

// The configuration with what its calibration says, if it names one. Throws CalibrationError, which names the file, if that cannot be read,
// is damaged, or belongs to another tool.
[[nodiscard]] SessionConfig with_calibration(SessionConfig config);

// What there is to be said against a calibration that was read, each in a sentence that names its file: its age, another feed, a touch
// error that does not cover what touches are off by before they are corrected.
[[nodiscard]] std::vector<std::string> calibration_warnings(const SessionConfig& config, CalendarTime now);

// mm: touches are off by that, beside the effective radius, as long as nothing corrects them.
[[nodiscard]] inline double uncorrected_error(const ProbeCalibration& calibration) { return calibration.raw_form_error_mm / 2; }

// mm: what lies between the direction that triggers earliest and the one that triggers latest.
[[nodiscard]] double lobing_range(const LobingMap& map);

// "effective radius 0.95 mm, touches exact to 0.001 mm (RMS) once corrected, of 2026-01-31"
[[nodiscard]] std::string describe(const ProbeCalibration& calibration);

// mm: what a touched centre of the ball lies off a surface that it touches: the effective radius where that is known. REQUIRES: a tool.
[[nodiscard]] double touching_radius(const SessionConfig& config);

}  // namespace palpate
