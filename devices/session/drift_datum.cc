#include "devices/session/drift_datum.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string>

#include "devices/errors.h"
#include "devices/session/machine_settings.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// What is wrong with a touch; empty: nothing.
std::string problem_of(const DatumTouch& touch, const MachineSettings& settings, const Surroundings& surroundings) {
    const auto at = [](const char* which, const Point& p) { return fmt::format("`{}`, {}, ", which, point_text(p)); };
    const double length = (touch.to - touch.from).norm();
    if (!(length > settings.motion.retract_mm)) {
        return fmt::format("`from` and `to` are {:g} mm apart: the tool needs more than machine.retract, {:g} mm, before a touch", length,
                           settings.motion.retract_mm);
    }
    for (const auto& [name, p] : {std::pair("from", touch.from), std::pair("to", touch.to)}) {
        if (!settings.limits.contains(p)) {
            return at(name, p) +
                   fmt::format("is outside machine.limits, {} to {}", point_text(settings.limits.min), point_text(settings.limits.max));
        }
        if (surroundings.known().is_buried(p)) return at(name, p) + "is below a table or behind a half-space of workspace.fixtures";
    }
    const auto inside = surroundings.unknown_part(touch.from, touch.inwards());
    if (!surroundings.is_free(touch.from) || !surroundings.is_free(touch.to) || (inside && inside->low < length && inside->high > 0)) {
        return fmt::format("from {} to {} it leads through the workspace, where the part is: the datum has to stand beside it",
                           point_text(touch.from), point_text(touch.to));
    }
    if (surroundings.known().contains(touch.from)) return at("from", touch.from) + "is within one of workspace.fixtures";
    try {
        const Point entry = surroundings.nearest_entry(touch.from);
        if (const auto hit = surroundings.first_known({entry, touch.from})) {
            return at("from", touch.from) + fmt::format(
                                                "cannot be reached: the straight way from the workspace's boundary, {}, meets one "
                                                "of workspace.fixtures at {}",
                                                point_text(entry), point_text(hit->at));
        }
    } catch (const std::invalid_argument&) {
        return at("from", touch.from) + "is beside a closed face of the workspace, which no straight way leads to";
    }
    return "";
}

}  // namespace

void check_datum(const MachineSettings& settings, const Surroundings& surroundings) {
    if (!settings.datum) return;
    const DriftDatum& datum = *settings.datum;
    if (datum.touches.empty()) throw SetupError("machine.datum.at: holds no touch; allowed: at least one");
    for (std::size_t k = 0; k < datum.touches.size(); ++k) {
        const std::string problem = problem_of(datum.touches[k], settings, surroundings);
        if (problem.empty()) continue;
        throw SetupError(fmt::format(
            "machine.datum.at[{}]: {}; allowed: a touch outside the workspace and inside the limits, whose `from` is reached straight from "
            "the workspace's boundary",
            k, problem));
    }
}

std::vector<Point> way_around(const Surroundings& surroundings, const Point& from, const Point& to) {
    const Point out = surroundings.nearest_entry(from);
    std::vector<Point> way{out};
    const std::vector<Point> around = surroundings.path(out, surroundings.nearest_entry(to));
    way.insert(way.end(), around.begin(), around.end());
    way.push_back(to);
    return way;
}

}  // namespace palpate
