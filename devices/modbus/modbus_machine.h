// A machine whose controller speaks Modbus.
#pragma once

#include "devices/clock.h"
#include "devices/machine.h"
#include "devices/modbus/modbus_device.h"
#include "devices/stop_request.h"

namespace palpate {

class ModbusMachine final : public Machine {
public:
    // Throws as ModbusDevice does.
    explicit ModbusMachine(const ModbusDeviceOptions& options, StopToken stop = {});

    [[nodiscard]] ProbeDevice& device() override { return device_; }
    [[nodiscard]] MachineReport report() override;
    // It has no command for homing: a machine that is not homed is refused.
    void make_ready() override;
    void retreat(const Point& target) override { device_.retreat(target); }
    [[nodiscard]] bool is_probe_closed() override { return device_.report().is_probe_closed; }
    [[nodiscard]] bool is_position_trusted() override;

private:
    const Point origin_;  // mm, machine coordinates
    SteadyClock clock_;
    ModbusDevice device_;
};

}  // namespace palpate
