#include "devices/limited_device.h"

#include <optional>
#include <stdexcept>
#include <string>

#include "devices/errors.h"
#include "devices/internal/number_text.h"

namespace palpate {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};

// "z = -3 mm is below the lower limit -2 mm", of the first axis that is outside; nothing if none is.
std::optional<std::string> violation(const Point& p, const Box& limits, double slack_mm) {
    for (int axis = 0; axis < 3; ++axis) {
        const bool is_low = p[axis] < limits.min[axis] - slack_mm;
        if (!is_low && p[axis] <= limits.max[axis] + slack_mm) continue;
        return std::string(kAxisNames[axis]) + " = " + number_text(p[axis], " mm is ") +
               (is_low ? "below the lower limit " + number_text(limits.min[axis], " mm")
                       : "above the upper limit " + number_text(limits.max[axis], " mm"));
    }
    return std::nullopt;
}

}  // namespace

LimitedDevice::LimitedDevice(ProbeDevice& device, const Box& limits, double resolution_mm)
    : device_(device), limits_(limits), resolution_mm_(resolution_mm) {
    if (!limits.min.allFinite() || !limits.max.allFinite() || !(limits.min.array() < limits.max.array()).all()) {
        throw std::invalid_argument("limits " + place_text(limits.min) + " to " + place_text(limits.max) +
                                    " mm: finite numbers are needed, and max greater than min in x, y and z");
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
    const std::string tool = "the tool is at " + place_text(start) + " mm";
    if (!start.allFinite()) throw OutOfLimits(tool + ", which is no place; nothing was sent: home the machine");
    if (const auto outside = violation(start, limits_, resolution_mm_)) {
        throw OutOfLimits(tool + ", outside the limits: " + *outside +
                          "; nothing was sent: jog it inside, or correct machine.limits or machine.origin");
    }
}

void LimitedDevice::check_target(const Point& target) const {
    const std::string move = "a move to " + place_text(target) + " mm";
    if (!target.allFinite()) throw OutOfLimits(move + " is not finite; nothing was sent: give three numbers in mm");
    if (const auto outside = violation(target, limits_, 0.0)) {
        throw OutOfLimits(move + " leaves the limits: " + *outside +
                          "; nothing was sent: if the machine can go there, widen machine.limits, else make the workspace smaller");
    }
}

}  // namespace palpate
