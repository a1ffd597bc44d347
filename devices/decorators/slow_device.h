// Travel as slow as a probe, for a machine whose probe has missed a touch: what was found free may not be.
#pragma once

#include "devices/probe_device.h"

namespace palpate {

class SlowDevice final : public ProbeDevice {
public:
    // `device` must outlive this.
    explicit SlowDevice(ProbeDevice& device) : device_(device) {}

    [[nodiscard]] Point position() const override { return device_.position(); }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        return device_.guarded_move(target, pace == Pace::travel ? Pace::probe : pace);
    }
    void stop() override { device_.stop(); }

private:
    ProbeDevice& device_;
};

}  // namespace palpate
