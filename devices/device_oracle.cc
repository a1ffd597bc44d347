#include "devices/device_oracle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>

#include "devices/errors.h"

namespace palpate {
namespace {

using Outcome = MoveResult::Outcome;

// Ways beside a touch that are tried, in so many directions around the way, ...
constexpr int kDirections = 6;
// ... first by this part of what is allowed, then by all of it.
constexpr double kFirstOffset = 0.4;

}  // namespace

void DeviceOracle::travel(std::span<const Point> path, Ground ground) {
    for (const Point& target : path) {
        travel_to(target, ground == Ground::proven ? Pace::travel : Pace::probe);
        position_ = target;
    }
}

MoveResult DeviceOracle::move(const Point& target, Pace pace) {
    ++moves_;
    range_ = std::max(range_, (target - first_).norm());
    return device_.guarded_move(target, pace);
}

void DeviceOracle::travel_to(const Point& target, Pace pace) {
    moves_ = 1;  // of those that count: false triggers before it aside
    const MoveResult result = move_past_sparks(device_, target, pace);
    if (result.outcome == Outcome::reached) return;
    const Point& touched = result.position;
    const bool is_there = (touched - target).norm() <= graze();
    if (is_there ? stop_short(touched, target, pace) : pass_beside(touched, target, pace)) {
        ++grazes_;
        return;
    }
    position_ = device_.position();
    throw UnexpectedContact(touched, "travel", moves_);
}

double DeviceOracle::graze() const { return kGraze * std::max(error_, kRounding * range_); }

bool DeviceOracle::stop_short(const Point& touched, const Point& target, Pace pace) {
    const Vector back = device_.position() - target;
    const Point before = touched + graze() * back.normalized();
    if (back.norm() <= (before - target).norm()) return true;  // the device rests nearer already
    return move(before, pace).outcome == Outcome::reached;
}

bool DeviceOracle::pass_beside(const Point& touched, const Point& target, Pace pace) {
    const Vector way = (target - touched).normalized();
    const Vector x = way.unitOrthogonal();
    const Vector y = way.cross(x);
    for (const double share : {kFirstOffset, 1.0}) {
        for (int k = 0; k < kDirections; ++k) {
            const double angle = 2 * std::numbers::pi * k / kDirections;
            const Vector aside = share * graze() * (std::cos(angle) * x + std::sin(angle) * y);
            if (move(touched + aside, Pace::probe).outcome != Outcome::reached) continue;
            if (move(target, pace).outcome == Outcome::reached) return true;
            // S may graze all of the way, as a planar face does: then there is one beside it, as near to the target.
            if (move(touched + aside, Pace::probe).outcome != Outcome::reached) continue;
            if (move(target + aside, pace).outcome == Outcome::reached) return true;
        }
    }
    return false;
}

ProbeAnswer DeviceOracle::probe(const Point& target) {
    const MoveResult result = move(target, Pace::probe);
    if (result.outcome == Outcome::reached) {
        position_ = target;
        return {ProbeAnswer::Outcome::clear, target};
    }
    if (result.outcome == Outcome::failed || result.outcome == Outcome::vanished) {
        // Back on the way that the tool came. What vanished may have been S, and the probe be dead: slowly then.
        const bool has_failed = result.outcome == Outcome::failed;
        const std::array<Point, 1> start{position_};
        travel(start, has_failed ? Ground::proven : Ground::unconfirmed);
        return {has_failed ? ProbeAnswer::Outcome::failed : ProbeAnswer::Outcome::vanished, position_};
    }
    position_ = error_ == 0 ? result.position : nearest_on({position_, target}, result.position);
    return {ProbeAnswer::Outcome::contact, position_};
}

}  // namespace palpate
