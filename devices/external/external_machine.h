// A machine that a program of its own drives.
#pragma once

#include <memory>

#include "devices/clock.h"
#include "devices/external/external_device.h"
#include "devices/machine.h"
#include "devices/stop_request.h"

namespace palpate {

class ExternalMachine final : public Machine {
public:
    // Throws as ExternalDevice does.
    ExternalMachine(std::unique_ptr<ByteStream> stream, const ExternalOptions& options, StopToken stop = {});

    [[nodiscard]] ProbeDevice& device() override { return device_; }
    [[nodiscard]] MachineReport report() override;
    // Homes where the options say so, and the program can.
    void make_ready() override { device_.make_ready(); }
    void retreat(const Point& target) override { device_.retreat(target); }
    [[nodiscard]] bool is_probe_closed() override { return device_.state().is_probe_closed; }
    [[nodiscard]] bool is_position_trusted() override;

private:
    SteadyClock clock_;
    const std::unique_ptr<ByteStream> stream_;
    ExternalDevice device_;
};

}  // namespace palpate
