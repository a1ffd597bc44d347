// A machine with a GRBL-family controller at the other end of a serial port or of a network.
#pragma once

#include <memory>

#include "devices/clock.h"
#include "devices/grbl/grbl_device.h"
#include "devices/machine.h"
#include "devices/stop_request.h"

namespace palpate {

class StreamGrblMachine final : public Machine {
public:
    // Throws as GrblDevice does.
    StreamGrblMachine(std::unique_ptr<ByteStream> stream, const GrblOptions& options, StopToken stop = {});

    [[nodiscard]] ProbeDevice& device() override { return device_; }
    [[nodiscard]] MachineReport report() override;
    void make_ready() override { device_.make_ready(); }
    void retreat(const Point& target) override { device_.retreat(target); }
    [[nodiscard]] bool is_probe_closed() override { return device_.is_probe_closed(); }
    [[nodiscard]] bool is_position_trusted() override;

private:
    SteadyClock clock_;
    const std::unique_ptr<ByteStream> stream_;
    GrblDevice device_;
};

}  // namespace palpate
