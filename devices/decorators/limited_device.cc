#include "devices/decorators/limited_device.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// "z = -3 mm is below the lower limit -2 mm", of the first axis that is outside.
std::string violation(const Point& p, const Box& limits) {
    for (int axis = 0; axis < 3; ++axis) {
        const bool is_low = p[axis] < limits.min[axis];
        if (!is_low && p[axis] <= limits.max[axis]) continue;
        return fmt::format("{} = {} mm is {} limit {} mm", "xyz"[axis], number_text(p[axis]),
                           is_low ? "below the lower" : "above the upper", number_text((is_low ? limits.min : limits.max)[axis]));
    }
    return "";
}

}  // namespace

LimitedDevice::LimitedDevice(ProbeDevice& device, const Box& limits, double resolution_mm)
    : device_(device), limits_(limits), resolution_mm_(resolution_mm) {
    if (!limits.is_valid()) {
        throw std::invalid_argument(fmt::format("limits {} to {}: finite numbers are needed, and max greater than min in x, y and z",
                                                point_text(limits.min), point_text(limits.max)));
    }
    if (!(resolution_mm >= 0)) throw std::invalid_argument("limits: the resolution is negative; give 0 mm or more");
}

MoveResult LimitedDevice::guarded_move(const Point& target, Pace pace) {
    check_target(target);
    check_start();
    return device_.guarded_move(target, pace);
}

void LimitedDevice::check_start() const {
    const Point start = device_.position();
    if (limits_.contains(start, resolution_mm_)) return;
    const std::string at = point_text(start);
    if (!start.allFinite()) {
        throw OutOfLimits(fmt::format("the tool is at {}, which is no place; nothing was sent: home the machine", at));
    }
    throw OutOfLimits(
        fmt::format("the tool is at {}, outside the limits: {}; nothing was sent: jog it inside, or correct machine.limits or "
                    "machine.origin",
                    at, violation(start, limits_)));
}

void LimitedDevice::check_target(const Point& target) const {
    if (limits_.contains(target)) return;
    const std::string goal = point_text(target);
    if (!target.allFinite()) {
        throw OutOfLimits(fmt::format("a move to {} is not finite; nothing was sent: give three numbers in mm", goal));
    }
    throw OutOfLimits(
        fmt::format("a move to {} leaves the limits: {}; nothing was sent: if the machine can go there, widen machine.limits, else make "
                    "the workspace smaller",
                    goal, violation(target, limits_)));
}

}  // namespace palpate
