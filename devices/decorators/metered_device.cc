#include "devices/decorators/metered_device.h"

#include <algorithm>

namespace palpate {

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
    using Outcome = MoveResult::Outcome;
    const bool is_touch = result.outcome != Outcome::reached;
    ++meter_.of(pace).of(result.outcome);
    for (const DeviceEvent& event : result.events) ++meter_.events.at(static_cast<std::size_t>(event.kind));

    const double feed = motion_.feeds.of(pace);
    const Point& farthest = is_touch ? result.position : rest;
    const double way = (farthest - start).norm();
    const double back = (rest - farthest).norm();
    meter_.displacement_mm += way + back;
    meter_.machine_time += is_touch ? touch_duration(way, back, feed) : move_duration(motion_, way, feed);
}

Seconds MeteredDevice::touch_duration(double way_mm, double back_mm, double feed_mm_per_s) const {
    const double probe_feed = motion_.feeds.probe_mm_per_s;
    const double run_on = stopping_distance(motion_, feed_mm_per_s);
    const Seconds there = move_duration(motion_, way_mm + run_on, feed_mm_per_s);
    if (back_mm > 0) return there + move_duration(motion_, run_on + back_mm, probe_feed);
    const double retract = std::min(motion_.retract_mm, way_mm);
    return there + move_duration(motion_, run_on + retract, probe_feed) + move_duration(motion_, retract, probe_feed);
}

}  // namespace palpate
