// The machine that a configuration names, connected: whichever driver that takes.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <variant>

#include "config/machine_config.h"
#include "devices/clock.h"
#include "devices/limited_device.h"
#include "devices/machine_report.h"
#include "devices/modbus_device.h"
#include "devices/multi_touch_device.h"

namespace palpate {

class Machine {
public:
    // Connects and moves nothing. Throws DeviceError, and ConfigError on a bad Modbus profile.
    Machine(const MachineConfig& config, const std::stop_token& stop);

    [[nodiscard]] ProbeDevice& device();
    // Makes it fit to move: homes, unlocks or refuses, as `homing` says. Throws DeviceError, ProbeClosed if the probe is closed.
    void make_ready();
    // Off a surface that an earlier session left the probe on, straight towards `target`, which it came from.
    void retreat(const Point& target);
    [[nodiscard]] bool is_probe_closed();
    // Whether the machine says that it knows where it is.
    [[nodiscard]] bool is_position_trusted();
    [[nodiscard]] MachineReport report();

private:
    SteadyClock clock_;
    Point origin_;
    std::unique_ptr<SerialPort> port_;      // of GRBL
    std::unique_ptr<GrblDevice> grbl_;      // one of the two
    std::unique_ptr<ModbusDevice> modbus_;  // is there
};

// The machine as a session moves it: limits before every command, touches looked at again. What is above may be a journal.
class GuardedMachine {
public:
    // Throws as Machine does.
    GuardedMachine(const MachineConfig& config, const std::stop_token& stop)
        : machine_(config, stop),
          limited_(machine_.device(), config.limits, config.kinematics.resolution_mm),
          touching_(limited_, config.touch, config.kinematics.retract_mm) {}

    [[nodiscard]] Machine& machine() { return machine_; }
    [[nodiscard]] ProbeDevice& device() { return touching_; }

private:
    Machine machine_;
    LimitedDevice limited_;
    MultiTouchDevice touching_;
};

// What the operator is asked to agree to: the machine, where its tool is, `what` it will do, and homing if that comes first.
[[nodiscard]] std::string describe_plan(const MachineConfig& config, const MachineReport& report, const std::string& what);

}  // namespace palpate
