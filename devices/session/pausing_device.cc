#include "devices/session/pausing_device.h"

#include <fmt/format.h>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// mm: what a machine that nobody moved may say of the same place, in reports of few digits.
constexpr double kSamePlace = 0.05;

}  // namespace

MoveResult PausingDevice::guarded_move(const Point& target, Pace pace) {
    while (true) {
        if (wait_ && stop_.pause_requested() && !stop_.stop_requested()) pause();
        try {
            return machine_.device().guarded_move(target, pace);
        } catch (const Stopped&) {
            // The tool is back where the move began.
            if (!wait_ || stop_.stop_requested()) throw;
        }
    }
}

// Meanwhile anybody may have used the machine, and a controller that heard nothing may have given up.
void PausingDevice::pause() {
    const Point before = position();
    wait_();
    if (stop_.stop_requested()) return;
    if (!machine_.is_position_trusted()) {
        throw PositionLost("the machine lost its position during the pause: see to it that it knows where it is, then resume");
    }
    machine_.make_ready();
    if ((position() - before).norm() <= kSamePlace) return;
    throw PositionLost(fmt::format("the tool was at {} before the pause and is at {} after it: something else moved it; resume",
                                   point_text(before), point_text(position())));
}

}  // namespace palpate
