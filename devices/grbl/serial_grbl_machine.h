// A machine with a GRBL-family controller on a serial port.
#pragma once

#include "devices/clock.h"
#include "devices/grbl/grbl_device.h"
#include "devices/machine.h"
#include "devices/posix/serial_port.h"
#include "devices/stop_request.h"

namespace palpate {

class SerialGrblMachine final : public Machine {
public:
    // Throws as SerialPort and GrblDevice do.
    SerialGrblMachine(const SerialPortOptions& port, const GrblOptions& options, StopToken stop = {});

    [[nodiscard]] ProbeDevice& device() override { return device_; }
    [[nodiscard]] MachineReport report() override;
    void make_ready() override { device_.make_ready(); }
    void retreat(const Point& target) override { device_.retreat(target); }
    [[nodiscard]] bool is_probe_closed() override { return device_.is_probe_closed(); }
    [[nodiscard]] bool is_position_trusted() override;

private:
    SteadyClock clock_;
    SerialPort port_;
    GrblDevice device_;
};

}  // namespace palpate
