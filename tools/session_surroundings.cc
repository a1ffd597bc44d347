#include "tools/session_surroundings.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "devices/errors.h"
#include "planner/grown_fixtures.h"
#include "planner/number_text.h"

namespace palpate {

Surroundings surroundings_of(const SessionConfig& config, const Region& workspace) {
    if (config.fixtures.solids.empty() && !config.area) return workspace;
    // As a configuration with fixtures or an area is read, its workspace is a box. A tool that just stands at a fixture is not to touch it.
    constexpr double kLeastClearance = 1e-3;  // mm
    const double clearance = config.fixtures.clearance.value_or(std::max(2 * config.traits().touch_error, kLeastClearance));
    try {
        return surroundings_with(std::get<Box>(workspace.shape()), config.fixtures, config.tool.value_or(ToolShape{}), clearance,
                                 config.probing.epsilon, config.area);
    } catch (const std::invalid_argument& error) {
        throw SetupError(fmt::format("{}: {}", config.area ? "probing.area" : "workspace", error.what()));
    }
}

std::string describe(const Surroundings& surroundings) {
    const Region& region = surroundings.region();
    if (surroundings.known().empty()) return fmt::format("around {}, radius {:.6g} mm", point_text(region.center()), region.radius());
    const Box box = surroundings.bounds();
    return fmt::format("from {} to {} for the ball's centre, {}", point_text(box.min), point_text(box.max),
                       surroundings.area() ? "within the area" : "between fixtures");
}

}  // namespace palpate
