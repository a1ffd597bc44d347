// The part's frame beside the machine's (drift_log.h).
#pragma once

#include "devices/probe_device.h"
#include "planner/geometry.h"

namespace palpate {

struct PartFrame {
    Vector shift = Vector::Zero();  // mm: the part is that far from where it was at the first visit to the datum
    Box limits{};                   // mm, the machine's: a place within them is looked for within them, shifted or not

    [[nodiscard]] Point to_machine(const Point& p) const {
        if (shift.isZero(0)) return p;
        return limits.contains(p) ? Point((p + shift).cwiseMax(limits.min).cwiseMin(limits.max)) : Point(p + shift);
    }
    [[nodiscard]] Point to_part(const Point& p) const { return p - shift; }
    // Of a move to `target`.
    [[nodiscard]] MoveResult to_part(MoveResult result, const Point& target) const {
        result.position = result.outcome == MoveResult::Outcome::reached ? target : to_part(result.position);
        for (DeviceEvent& event : result.events) event.position = to_part(event.position);
        return result;
    }
};

// A device as the part's frame has it. The frame may change between moves.
class ShiftedDevice final : public ProbeDevice {
public:
    // Both must outlive this.
    ShiftedDevice(ProbeDevice& device, const PartFrame& frame) : device_(device), frame_(frame) {}

    [[nodiscard]] Point position() const override { return frame_.to_part(device_.position()); }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        return frame_.to_part(device_.guarded_move(frame_.to_machine(target), pace), target);
    }
    void stop() override { device_.stop(); }

private:
    ProbeDevice& device_;
    const PartFrame& frame_;
};

}  // namespace palpate
