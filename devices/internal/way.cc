#include "devices/internal/way.h"

#include <fmt/format.h>

#include "planner/number_text.h"

namespace palpate {

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
