// A touch probe that moves in a world with one obstacle, at once and without error.
#pragma once

#include <cstdint>
#include <functional>

#include "devices/probe_device.h"
#include "sim/motion_audit.h"
#include "sim/objects/obstacle.h"

namespace palpate {

struct SimulatedDeviceOptions {
    bool audit = true;  // check every move independently; off for benchmarks of speed
    // Told of every move: the way that was gone, and whether a contact ended it.
    std::function<void(const Segment&, bool)> on_move{};
};

class SimulatedDevice final : public ProbeDevice {
public:
    // `obstacle` must outlive the device. Throws DeviceError if `start` is not finite or inside it.
    SimulatedDevice(const Obstacle& obstacle, const Point& start, SimulatedDeviceOptions options = {});

    // Share of the obstacle's scale. After a contact the tool rests on S, within rounding (1e-15 of scale) before or behind it, and as a
    // real probe does it lets go of S while it starts to move: S is not looked for in the first kReleaseDistance of a move from a contact.
    // If the tool is inside the object then, the move goes into it, and is a contact where it started. 1e-9 is far above rounding, also of
    // moves at a slant of 1e-5, and far below what any run resolves; a sliver of the solid thinner than this is overlooked from there.
    static constexpr double kReleaseDistance = 1e-9;

    [[nodiscard]] Point position() const override { return position_; }
    // Throws DeviceError if `target` is not finite. A move of no length reaches its target.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    // Does nothing: moves take no time, so there is never one to end.
    void stop() override {}

    // What really happened, by an account of its own (MotionAudit).
    [[nodiscard]] std::uint64_t moves() const { return audit_.moves(); }
    [[nodiscard]] double distance() const { return audit_.distance(); }  // mm
    [[nodiscard]] std::uint64_t unsafe_moves() const { return audit_.unsafe_moves(); }

private:
    [[nodiscard]] MoveResult cast(const Point& target) const;

    const Obstacle& obstacle_;
    MotionAudit audit_;
    std::function<void(const Segment&, bool)> on_move_;
    Point position_;
    bool resting_ = false;  // on S, after a contact
};

}  // namespace palpate
