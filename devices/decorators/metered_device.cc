#include "devices/decorators/metered_device.h"

#include <algorithm>

namespace palpate {
namespace {

Seconds touch_duration(const MotionModel& motion, double way_mm, double back_mm, double feed_mm_per_s) {
    const double probe_feed = motion.feeds.probe_mm_per_s;
    const double run_on = stopping_distance(motion, feed_mm_per_s);
    const Seconds there = move_duration(motion, way_mm + run_on, feed_mm_per_s);
    if (back_mm > 0) return there + move_duration(motion, run_on + back_mm, probe_feed);
    const double retract = std::min(motion.retract_mm, way_mm);
    return there + move_duration(motion, run_on + retract, probe_feed) + move_duration(motion, retract, probe_feed);
}

}  // namespace

Seconds time_of_move(const MotionModel& motion, const Point& start, const MoveResult& result, const Point& rest, Pace pace) {
    const double feed = motion.feeds.of(pace);
    if (result.outcome == MoveResult::Outcome::reached) return move_duration(motion, (rest - start).norm(), feed);
    return touch_duration(motion, (result.position - start).norm(), (rest - result.position).norm(), feed);
}

std::uint64_t& MoveCount::of(MoveResult::Outcome outcome) {
    switch (outcome) {
        case MoveResult::Outcome::reached:
            return reached;
        case MoveResult::Outcome::contact:
            return contact;
        case MoveResult::Outcome::failed:
            return failed;
        case MoveResult::Outcome::vanished:
            break;
    }
    return vanished;
}

MoveResult MeteredDevice::guarded_move(const Point& target, Pace pace) {
    const Point start = device_.position();
    MoveResult result;
    try {
        result = device_.guarded_move(target, pace);
    } catch (...) {
        ++meter_.faults;
        throw;
    }
    add(start, result, device_.position(), pace);
    return result;
}

void MeteredDevice::add(const Point& start, const MoveResult& result, const Point& rest, Pace pace) {
    const bool is_touch = result.outcome != MoveResult::Outcome::reached;
    ++meter_.of(pace).of(result.outcome);
    for (const DeviceEvent& event : result.events) ++meter_.events.at(static_cast<std::size_t>(event.kind));

    const Point& farthest = is_touch ? result.position : rest;
    meter_.displacement_mm += (farthest - start).norm() + (rest - farthest).norm();
    meter_.machine_time += time_of_move(motion_, start, result, rest, pace);
}

}  // namespace palpate
