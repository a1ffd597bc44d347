// Soft limits of our own before every move, whatever the machine has.
#pragma once

#include "devices/probe_device.h"
#include "planner/region.h"

namespace palpate {

class LimitedDevice final : public ProbeDevice {
public:
    // `device` must outlive this. The tool may be anywhere in `limits`, faces included; as a box is convex, no way between two places of
    // it leaves it. `resolution_mm`: the device rounds positions to it, so that a tool at rest may be outside by that. Throws
    // std::invalid_argument if the box is not finite or has no inside, or the resolution is negative.
    LimitedDevice(ProbeDevice& device, const Box& limits, double resolution_mm = 0.0);

    [[nodiscard]] Point position() const override { return device_.position(); }
    // Throws OutOfLimits, before anything is sent, if the target is not finite or outside, or the tool is outside where it starts.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override { device_.stop(); }

private:
    void check_start() const;
    void check_target(const Point& target) const;

    ProbeDevice& device_;
    const Box limits_;
    const double resolution_mm_;
};

}  // namespace palpate
