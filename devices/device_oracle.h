// The planner's SurfaceOracle on any ProbeDevice: every motion, travel too, is a guarded move.
#pragma once

#include "devices/probe_device.h"
#include "planner/surface_oracle.h"

namespace palpate {

class DeviceOracle final : public SurfaceOracle {
public:
    // `device` must outlive the oracle.
    explicit DeviceOracle(ProbeDevice& device) : device_(device) {}

    [[nodiscard]] Point position() const override { return device_.position(); }
    // Throws UnexpectedContact if the probe touches anything on the way, and DeviceError on a fault.
    void travel(std::span<const Point> path) override;
    // Throws DeviceError on a fault.
    [[nodiscard]] ProbeAnswer probe(const Point& target) override;

private:
    ProbeDevice& device_;
};

}  // namespace palpate
