// Balls and boxes of many sizes at many places.
#pragma once

#include <vector>

#include "tests/planner/support.h"

namespace palpate {

inline constexpr double kRegionTolerance = 1e-12;  // of the region's radius and distance from the origin

inline std::vector<Region> some_regions() {
    return {Region(Ball{{0, 0, 0}, 1}),           Region(Ball{{300, -20, 7}, 0.01}),    Region(Ball{{1, 2, 3}, 500}),
            Region(Box{{-1, -1, -1}, {1, 1, 1}}), Region(Box{{0, 0, 0}, {1, 20, 300}}), Region(Box{{40, 50, 60}, {40.1, 50.01, 60.2}})};
}

inline double tolerance_of(const Region& workspace) { return kRegionTolerance * (workspace.radius() + workspace.center().norm()); }

}  // namespace palpate
