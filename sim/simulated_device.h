// A touch probe that moves in a world with one obstacle, at once, and without error unless it is told which.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "devices/motion_model.h"
#include "devices/probe_device.h"
#include "sim/motion_audit.h"
#include "sim/objects/obstacle.h"
#include "sim/probe/probe_errors.h"

namespace palpate {

struct SimulatedDeviceOptions {
    bool audit = true;  // check every move independently; off for benchmarks of speed
    // Told of every move: the way that was gone, and whether a contact ended it. Errors may bend a way (backlash): then of each straight
    // part.
    std::function<void(const Segment&, bool)> on_move{};
    // With errors the device reports the place where the probe triggered, and rests where the ball first touched, or before that: what runs
    // on into the solid is the stylus giving way, and taken back.
    ProbeErrors errors{};
    MotionModel motion{};  // of errors: feeds, and what passes for time
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

    [[nodiscard]] Point position() const override { return position_ - shift_; }
    // Where it really is: elsewhere than position() with errors.
    [[nodiscard]] const Point& true_position() const { return position_; }
    // Throws DeviceError if `target` is not finite. A move of no length reaches its target.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    // Does nothing: moves take no time, so there is never one to end.
    void stop() override {}

    // What really happened, by an account of its own (MotionAudit).
    [[nodiscard]] std::uint64_t moves() const { return audit_.moves(); }
    [[nodiscard]] double distance() const { return audit_.distance(); }  // mm
    [[nodiscard]] std::uint64_t unsafe_moves() const { return audit_.unsafe_moves(); }

private:
    struct RealWay;

    // Where a straight part of a way is ended; `resting`: on S at its source.
    [[nodiscard]] std::optional<Point> contact(const Segment& part, bool resting) const;
    [[nodiscard]] MoveResult move_with_errors(const Point& target, Pace pace);
    [[nodiscard]] RealWay real_way(const Point& target, Seconds duration) const;
    // Along the real way: the first contact, if there is one. `share`: of the way.
    struct Contact {
        double share = 0.0;
        Point place = Point::Zero();
    };
    [[nodiscard]] std::optional<Contact> first_contact(const RealWay& way) const;
    void go(const RealWay& way, double share, const Point& end, bool touched);
    void go_straight(const Point& target, bool touched);

    const Obstacle& obstacle_;
    MotionAudit audit_;
    std::function<void(const Segment&, bool)> on_move_;
    std::optional<ProbeErrorDraws> errors_;  // if there are any
    MotionModel motion_;
    Point position_;
    bool resting_ = false;           // on S, after a contact
    Vector shift_ = Vector::Zero();  // mm: where it is, less what it says: play and drift
    Vector play_ = Vector::Zero();   // of the axes
    Seconds time_{0.0};              // since it began
    std::uint64_t touches_ = 0;
};

}  // namespace palpate
