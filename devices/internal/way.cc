#include "devices/internal/way.h"

#include <fmt/format.h>

#include <algorithm>

#include "planner/number_text.h"

namespace palpate {

double longest_overrun(const MotionModel& motion, double feed_mm_per_s, double tolerance) {
    constexpr double kPatience = 2.0;  // other accelerations than were told
    return kPatience * std::max(motion.overtravel_mm, stopping_distance(motion, feed_mm_per_s)) + tolerance;
}

Point rounded(const MotionModel& motion, const Point& p) { return (p / motion.resolution_mm).array().round() * motion.resolution_mm; }

Point retracted(const MotionModel& motion, const Point& place, const Point& start) {
    const Vector back = start - place;
    const double length = back.norm();
    const double share = length > 0 ? std::min(motion.retract_mm, length) / length : 0.0;
    return rounded(motion, place + share * back);
}

std::string problem_of(const WayEnd& end, const Way& way, double tolerance) {
    const Point& rest = end.rest;
    if (!end.touched) {
        if ((rest - way.target).norm() <= tolerance) return {};
        return fmt::format("reports no contact, but rests at {}, which is not the target", point_text(rest));
    }
    const std::string contact = point_text(*end.touched);
    if (way.distance_to(*end.touched) > tolerance) return fmt::format("reports a contact at {}, which is not on its way", contact);
    if (way.distance_to(rest) > tolerance) {
        return fmt::format("reports a contact at {}, but rests at {}, which is not on its way", contact, point_text(rest));
    }
    if (way.place_of(rest) < way.place_of(*end.touched) - tolerance) {
        return fmt::format("reports a contact at {}, but rests before it, at {}", contact, point_text(rest));
    }
    return {};
}

}  // namespace palpate
