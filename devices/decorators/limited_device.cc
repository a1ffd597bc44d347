#include "devices/decorators/limited_device.h"

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
        return std::string(1, "xyz"[axis]) + " = " + number_text(p[axis], " mm is ") +
               (is_low ? "below the lower limit " + number_text(limits.min[axis], " mm")
                       : "above the upper limit " + number_text(limits.max[axis], " mm"));
    }
    return "";
}

}  // namespace

LimitedDevice::LimitedDevice(ProbeDevice& device, const Box& limits, double resolution_mm)
    : device_(device), limits_(limits), resolution_mm_(resolution_mm) {
    if (!limits.is_valid()) {
        throw std::invalid_argument("limits " + point_text(limits.min) + " to " + point_text(limits.max) +
                                    ": finite numbers are needed, and max greater than min in x, y and z");
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
    const std::string tool = "the tool is at " + point_text(start);
    if (!start.allFinite()) throw OutOfLimits(tool + ", which is no place; nothing was sent: home the machine");
    throw OutOfLimits(tool + ", outside the limits: " + violation(start, limits_) +
                      "; nothing was sent: jog it inside, or correct machine.limits or machine.origin");
}

void LimitedDevice::check_target(const Point& target) const {
    if (limits_.contains(target)) return;
    const std::string move = "a move to " + point_text(target);
    if (!target.allFinite()) throw OutOfLimits(move + " is not finite; nothing was sent: give three numbers in mm");
    throw OutOfLimits(move + " leaves the limits: " + violation(target, limits_) +
                      "; nothing was sent: if the machine can go there, widen machine.limits, else make the workspace smaller");
}

}  // namespace palpate
