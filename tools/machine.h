// The machine that a configuration names, connected: whichever driver that takes.
#pragma once

#include <memory>
#include <stop_token>
#include <variant>

#include "config/machine_config.h"
#include "devices/clock.h"
#include "devices/machine_report.h"

namespace palpate {

class Machine {
public:
    // Connects and moves nothing. Throws DeviceError.
    Machine(const MachineConfig& config, const std::stop_token& stop);

    [[nodiscard]] ProbeDevice& device();
    // Homes, unlocks or refuses, as `homing` says.
    void make_ready();
    // From a surface that an earlier session left the probe on, straight to `target`, which it came from.
    void retreat(const Point& target);
    [[nodiscard]] bool is_probe_closed();
    // Whether the machine knows where it is: not locked since it connected.
    [[nodiscard]] bool is_position_trusted();
    [[nodiscard]] MachineReport report();

private:
    SteadyClock clock_;
    std::unique_ptr<SerialPort> port_;
    std::unique_ptr<GrblDevice> grbl_;
};

}  // namespace palpate
