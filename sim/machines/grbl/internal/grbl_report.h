// What a virtual GRBL controller says, as text. Lines have no CR LF unless there are several.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "sim/machines/grbl/internal/grbl_block.h"
#include "sim/machines/grbl/internal/grbl_planner.h"
#include "sim/machines/grbl/internal/grbl_settings.h"
#include "sim/machines/grbl/virtual_grbl.h"

namespace palpate {

struct GrblStatus {
    std::string state = "Idle";
    bool moving = false;             // decides how often offsets are told
    Point position = Point::Zero();  // mm, machine coordinates
    Point work_offset = Point::Zero();
    double speed_mm_per_s = 0.0;
    bool probe_closed = false;
    bool probe_cut = false;
    bool homed = false;
    GrblOverrides overrides{};
    GrblModal modal{};  // of which spindle and coolant are told
    std::size_t planner_free = 0;
    std::size_t buffer_free = 0;
};

// The answers to `?`. Offsets and overrides come only in some of them, as the firmware counts.
class GrblStatusReport {
public:
    explicit GrblStatusReport(GrblDialect dialect) : dialect_(dialect) {}

    [[nodiscard]] std::string next(const GrblStatus& status, const GrblSettings& settings);
    // The next report tells the offset.
    void offset_changed() { until_offset_ = 0; }
    // the overrides, and what runs.
    void overrides_changed() { until_overrides_ = 0; }
    void restart();

private:
    GrblDialect dialect_;
    int until_offset_ = 0;
    int until_overrides_ = 0;
};

struct GrblProbeRecord {
    Point position = Point::Zero();  // mm, machine coordinates
    bool succeeded = false;
};

[[nodiscard]] std::string probe_report(const GrblProbeRecord& record, bool inches);
[[nodiscard]] std::string banner(GrblDialect dialect);
// `$#`, `$G`, `$I`: with CR LF after every line, without the `ok`. No record: there is none yet, and the firmware says nothing of it.
[[nodiscard]] std::string parameters_report(const GrblFrame& frame, const std::optional<GrblProbeRecord>& record, bool inches);
[[nodiscard]] std::string modal_report(const GrblModal& modal);
[[nodiscard]] std::string version_report(GrblDialect dialect);

}  // namespace palpate
