// Everything that one session is told: what to probe, where, how. The reader fills it, the writer spells it out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <variant>

#include "config/machine_config.h"
#include "devices/calibration/probe_calibration.h"
#include "planner/area.h"
#include "planner/fixtures.h"
#include "planner/options.h"
#include "planner/region.h"
#include "planner/tool_shape.h"
#include "sim/objects/object_spec.h"
#include "sim/probe/probe_errors.h"

namespace palpate {

// ω is derived from the hidden object. Only a simulation can do that.
struct AutoWorkspace {};

using WorkspaceSpec = std::variant<AutoWorkspace, Ball, Box>;

// Where a qualification of the tool stands.
struct CalibrationSpec {
    std::filesystem::path file;  // empty: none
    double max_age_days = 7.0;   // > 0: older ones are warned of
};

// Where the touches of an earlier run stand, which this one goes on from.
struct EarlierSpec {
    std::filesystem::path file;  // empty: there was none
};

// What is made of what was touched.
struct ResultSpec {
    // With shadows and what lies on fixtures as they are known, or cut off where the part was not measured.
    enum class Part { closed, open };
    Part part = Part::closed;
    bool surface = true;  // whether surface.ply is made

    friend bool operator==(const ResultSpec&, const ResultSpec&) = default;
};

struct SessionConfig {
    std::optional<ObjectSpec> object;      // the hidden object of a simulation or of a virtual machine
    std::optional<MachineConfig> machine;  // to probe with; a simulation needs none
    std::optional<ToolShape> tool;         // none: a point
    CalibrationSpec calibration;           // of the tool
    // What that file says; the reader looks at no file but its own (tools/calibration_file).
    std::optional<ProbeCalibration> probe_calibration;
    // Of a simulation's probe or of a virtual machine's; the real one has its own. Axis and seed are those of the tool and of the run.
    std::optional<ProbeErrors> errors;
    WorkspaceSpec workspace;
    Fixtures fixtures;  // with a box as workspace only
    // `probing.earlier` is what that file says; the reader looks at no file but its own (tools/earlier_session).
    EarlierSpec earlier;
    Options probing;
    std::optional<Area> area;  // that alone is probed; with a box as workspace only
    ResultSpec results;        // `part` with a tool only

    // Of the machine; without one, of a simulated probe.
    [[nodiscard]] OracleTraits traits() const {
        if (machine) return machine->traits();
        OracleTraits traits;
        if (errors) traits.touch_error = errors->touch_error(Feeds{}.probe_mm_per_s);
        return traits;
    }
    // With the tool's axis and the run's seed; none where none are given.
    [[nodiscard]] ProbeErrors probe_errors() const {
        ProbeErrors all = errors.value_or(ProbeErrors{});
        if (tool) all.axis = tool->axis;
        all.seed = probing.random_seed;
        return all;
    }
};

}  // namespace palpate
