// What is to be known of a machine, whatever drives it: where it may go, how it moves and touches.
#pragma once

#include <optional>

#include "devices/decorators/multi_touch_device.h"
#include "devices/homing.h"
#include "devices/machine_report.h"
#include "devices/motion_model.h"
#include "devices/session/drift_datum.h"
#include "planner/region.h"
#include "planner/surface_oracle.h"

namespace palpate {

// What shows that the probe works, before anything relies on it.
enum class ProbeProof {
    automatic,    // by hand if there is somebody to press it, else the first touch
    hand,         // it is pressed by hand, and seen to close and to open
    first_touch,  // until the first contact every move is as slow as a probe
};

struct MachineSettings {
    Homing homing = Homing::require;
    Point origin = Point::Zero();  // mm, machine coordinates: where the session's coordinates have their origin
    Box limits;                    // mm, the session's coordinates: where the tool may be
    MotionModel motion;
    double noise_mm = 0.0;  // touches may be off by that besides the resolution
    MultiTouchOptions touch;
    std::optional<double> datum_tolerance_mm;  // a known place may be off by that when a session is resumed
    ProbeProof probe_proof = ProbeProof::automatic;
    std::optional<DriftDatum> datum{};  // touched now and then, so that drift is seen; none: there is taken to be none

    // mm: of touches. Positions are rounded both ways.
    [[nodiscard]] double touch_error() const { return 2 * motion.resolution_mm + noise_mm; }
    // What the planner is told of it. `overtravel` is left to who moves it: a simulation's probe does not die.
    [[nodiscard]] OracleTraits traits() const { return {touch_error(), motion.retract_mm, {}, machine_rates(motion)}; }
    // mm: both touches of a known place may be off.
    [[nodiscard]] double datum_tolerance() const { return datum_tolerance_mm.value_or(2 * touch_error()); }
    // Whether Machine::make_ready() will home what says that of itself.
    [[nodiscard]] bool homes_first(const MachineReport& report) const { return homing == Homing::run && report.needs_homing; }
};

}  // namespace palpate
