#include "sim/simulated_device.h"

#include <fmt/format.h>

#include <utility>

#include "devices/errors.h"

namespace palpate {
SimulatedDevice::SimulatedDevice(const Obstacle& obstacle, const Point& start, SimulatedDeviceOptions options)
    : obstacle_(obstacle), audit_(obstacle, options.audit), on_move_(std::move(options.on_move)), position_(start) {
    if (!start.allFinite()) throw DeviceError("simulated probe: the start position is not finite; give three numbers in mm");
    if (obstacle.contains(start)) {
        throw DeviceError(
            fmt::format("simulated probe: the start position ({:.6g}, {:.6g}, {:.6g}) mm is inside the hidden object; start outside its "
                        "bounds",
                        start.x(), start.y(), start.z()));
    }
}

MoveResult SimulatedDevice::cast(const Point& target) const {
    const Vector way = target - position_;
    const double length = way.norm();
    if (length == 0.0) return {MoveResult::Outcome::reached, target};
    const double release = kReleaseDistance * obstacle_.scale();
    auto hit = obstacle_.first_hit({position_, target});
    // The second case: a move that touched nothing may have ended on S by chance.
    if (resting_ || (hit && (*hit - position_).norm() <= release)) {
        const Point released = length > release ? Point(position_ + (release / length) * way) : target;
        if (obstacle_.contains(released)) return {MoveResult::Outcome::contact, position_};
        hit = length > release ? obstacle_.first_hit({released, target}) : std::nullopt;
    }
    return hit ? MoveResult{MoveResult::Outcome::contact, *hit} : MoveResult{MoveResult::Outcome::reached, target};
}

MoveResult SimulatedDevice::guarded_move(const Point& target, Pace /*pace*/) {
    if (!target.allFinite()) throw DeviceError("simulated probe: the target of a move is not finite; give three numbers in mm");
    MoveResult result = cast(target);
    audit_.record({position_, result.position});
    if (on_move_) on_move_({position_, result.position}, result.outcome == MoveResult::Outcome::contact);
    position_ = result.position;
    resting_ = result.outcome == MoveResult::Outcome::contact;
    return result;
}

}  // namespace palpate
