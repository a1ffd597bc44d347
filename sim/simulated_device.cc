#include "sim/simulated_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "devices/errors.h"
#include "sim/probe/axis_play.h"

namespace palpate {
SimulatedDevice::SimulatedDevice(const Obstacle& obstacle, const Point& start, SimulatedDeviceOptions options)
    : obstacle_(obstacle),
      audit_(obstacle, options.audit),
      on_move_(std::move(options.on_move)),
      motion_(options.motion),
      position_(start) {
    if (options.errors.is_any()) errors_.emplace(options.errors);
    if (!start.allFinite()) throw DeviceError("simulated probe: the start position is not finite; give three numbers in mm");
    if (obstacle.contains(start)) {
        throw DeviceError(
            fmt::format("simulated probe: the start position ({:.6g}, {:.6g}, {:.6g}) mm is inside the hidden object; start outside its "
                        "bounds",
                        start.x(), start.y(), start.z()));
    }
}

std::optional<Point> SimulatedDevice::contact(const Segment& part, bool resting) const {
    const Vector way = part.target - part.source;
    const double length = way.norm();
    if (length == 0.0) return std::nullopt;
    const double release = kReleaseDistance * obstacle_.scale();
    const auto hit = obstacle_.first_hit(part);
    // The second case: a move that touched nothing may have ended on S by chance.
    if (!resting && !(hit && (*hit - part.source).norm() <= release)) return hit;
    const Point released = length > release ? Point(part.source + (release / length) * way) : part.target;
    if (obstacle_.contains(released)) return part.source;
    return length > release ? obstacle_.first_hit({released, part.target}) : std::nullopt;
}

void SimulatedDevice::go_straight(const Point& target, bool touched) {
    audit_.record({position_, target});
    if (on_move_) on_move_({position_, target}, touched);
    position_ = target;
}

MoveResult SimulatedDevice::guarded_move(const Point& target, Pace pace) {
    if (!target.allFinite()) throw DeviceError("simulated probe: the target of a move is not finite; give three numbers in mm");
    if (errors_) return move_with_errors(target, pace);
    const auto hit = contact({position_, target}, resting_);
    go_straight(hit.value_or(target), hit.has_value());
    resting_ = hit.has_value();
    return {hit ? MoveResult::Outcome::contact : MoveResult::Outcome::reached, position_};
}

// Where it really is while it says that it goes straight.
struct SimulatedDevice::RealWay {
    Point said = Point::Zero();  // where it begins, as it says
    Vector way = Vector::Zero();
    std::vector<PlayAt> plays;
    Vector drift = Vector::Zero();       // where it begins
    Vector last_drift = Vector::Zero();  // where it ends

    [[nodiscard]] Vector play(double share) const { return play_at(plays, share); }
    [[nodiscard]] Vector shift(double share) const { return play(share) + drift + share * (last_drift - drift); }
    [[nodiscard]] Point at(double share) const { return said + share * way + shift(share); }
};

SimulatedDevice::RealWay SimulatedDevice::real_way(const Point& target, Seconds duration) const {
    const ProbeErrors& errors = errors_->errors();
    const Vector way = target - position();
    std::vector<PlayAt> plays = play_along(way, play_, errors.backlash_mm);
    // Axes that turn would drag a ball that rests on S along it, one before the other, which is no new touch: play is taken up on all of
    // the way then.
    if (resting_) plays = {plays.front(), plays.back()};
    // Drift goes on while it moves: a tool that rests on S is not drawn into it.
    return {position(), way, std::move(plays), shift_ - play_, errors.drift_at(time_ + duration, touches_)};
}

std::optional<SimulatedDevice::Contact> SimulatedDevice::first_contact(const RealWay& way) const {
    Point from = position_;
    for (std::size_t k = 1; k < way.plays.size(); ++k) {
        const double begin = way.plays[k - 1].share;
        const double end = way.plays[k].share;
        const Segment part{from, way.at(end)};
        if (const auto hit = contact(part, k == 1 && resting_)) {
            const double part_of = (*hit - part.source).norm() / (part.target - part.source).norm();
            return Contact{begin + part_of * (end - begin), *hit};
        }
        from = part.target;
    }
    return std::nullopt;
}

void SimulatedDevice::go(const RealWay& way, double share, const Point& end, bool touched) {
    for (const PlayAt& at : way.plays) {
        if (at.share > 0.0 && at.share < share) go_straight(way.at(at.share), false);
    }
    go_straight(end, touched);
    play_ = way.play(share);
    shift_ = way.shift(share);
}

MoveResult SimulatedDevice::move_with_errors(const Point& target, Pace pace) {
    const Point start = position();
    const Vector along = target - start;
    const double length = along.norm();
    const double feed = motion_.feeds.of(pace);
    const Seconds duration = length > 0.0 ? move_duration(motion_, length, feed) : Seconds(0.0);
    const RealWay way = real_way(target, duration);
    const std::optional<double> spark = errors_->false_trigger();
    const auto touched = first_contact(way);
    // Both are in shares of the way, at least 0 and at most 1: the probe triggers at the target at the latest.
    double trigger = 1.0;
    if (touched) {
        const Vector direction = along / length;
        const double late =
            errors_->lateness(direction, obstacle_.normal(touched->place, direction)) + errors_->errors().latency.count() * feed;
        trigger = std::clamp(touched->share + late / length, 0.0, 1.0);
    }
    const bool noticed = touched && !errors_->misses();
    MoveResult result;
    if (spark && (!touched || *spark < std::min(touched->share, trigger))) {
        result = {MoveResult::Outcome::contact, start + *spark * along, {}, false};
        go(way, *spark, way.at(*spark), true);
        resting_ = false;
    } else if (noticed) {
        result = {MoveResult::Outcome::contact, start + trigger * along};
        resting_ = trigger >= touched->share;
        go(way, std::min(trigger, touched->share), resting_ ? touched->place : way.at(trigger), true);
    } else {
        result = {MoveResult::Outcome::reached, target};
        go(way, 1.0, way.at(1.0), false);
        resting_ = false;
    }
    if (result.outcome == MoveResult::Outcome::contact) ++touches_;
    const double gone = length > 0.0 ? (position() - start).norm() / length : 0.0;
    time_ += gone * duration;
    return result;
}

}  // namespace palpate
