// Everything that one session is told: what to probe, where, how. The reader fills it, the writer spells it out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <variant>

#include "config/machine_config.h"
#include "devices/calibration/probe_calibration.h"
#include "planner/fixtures.h"
#include "planner/options.h"
#include "planner/region.h"
#include "planner/tool_shape.h"
#include "sim/objects/object_spec.h"

namespace palpate {

// ω is derived from the hidden object. Only a simulation can do that.
struct AutoWorkspace {};

using WorkspaceSpec = std::variant<AutoWorkspace, Ball, Box>;

// Where a qualification of the tool stands.
struct CalibrationSpec {
    std::filesystem::path file;  // empty: none
    double max_age_days = 7.0;   // > 0: older ones are warned of
};

// What is made of what was touched.
struct ResultSpec {
    // With shadows and what lies on fixtures as they are known, or cut off where the part was not measured.
    enum class Part { closed, open };
    Part part = Part::closed;

    friend bool operator==(const ResultSpec&, const ResultSpec&) = default;
};

struct SessionConfig {
    std::optional<ObjectSpec> object;      // the hidden object of a simulation or of a virtual machine
    std::optional<MachineConfig> machine;  // to probe with; a simulation needs none
    std::optional<ToolShape> tool;         // none: a point
    CalibrationSpec calibration;           // of the tool
    // What that file says; the reader looks at no file but its own (tools/calibration_file).
    std::optional<ProbeCalibration> probe_calibration;
    WorkspaceSpec workspace;
    Fixtures fixtures;  // with a box as workspace only
    Options probing;
    ResultSpec results;  // with a tool only

    // Of the machine; an exact oracle's without one.
    [[nodiscard]] OracleTraits traits() const { return machine ? machine->traits() : OracleTraits{}; }
};

}  // namespace palpate
