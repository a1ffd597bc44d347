// The machine that a session probes with: how it is reached, where it may go, how it moves and touches.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "devices/grbl_device.h"
#include "devices/kinematics.h"
#include "devices/modbus_link.h"
#include "devices/multi_touch_device.h"
#include "devices/serial_port.h"
#include "planner/workspace.h"

namespace palpate {

struct GrblSpec {
    SerialPortOptions port;
};

struct ModbusSpec {
    ModbusLinkOptions link;
    std::filesystem::path profile;  // empty: ours
};

// What shows that the probe works, before anything relies on it.
enum class ProbeProof {
    automatic,    // by hand if somebody was asked whether the machine may move, else the first touch
    hand,         // it is pressed by hand, and seen to close and to open
    first_touch,  // until the first contact every move is as slow as a probe
};

struct MachineConfig {
    std::variant<GrblSpec, ModbusSpec> connection;
    Homing homing = Homing::require;
    Point origin = Point::Zero();  // mm, machine coordinates: where the session's coordinates have their origin
    Box limits;                    // mm, the session's coordinates: where the tool may be
    Kinematics kinematics;
    double noise_mm = 0.0;  // touches may be off by that besides the resolution
    MultiTouchOptions touch;
    std::optional<double> datum_tolerance_mm;  // a known place may be off by that when a session is resumed
    ProbeProof probe_proof = ProbeProof::automatic;

    // mm: Options::touch_error. Positions are rounded both ways.
    [[nodiscard]] double touch_error() const { return 2 * kinematics.resolution_mm + noise_mm; }
    // mm: both touches of a known place may be off.
    [[nodiscard]] double datum_tolerance() const { return datum_tolerance_mm.value_or(2 * touch_error()); }
};

}  // namespace palpate
