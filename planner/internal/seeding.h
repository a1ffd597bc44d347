// First touches, and a persistent facet per component, so that no component can vanish from Ŝ (DESIGN section 4).
#pragma once

#include <array>
#include <vector>

#include "planner/errors.h"
#include "planner/internal/maintained_delaunay.h"
#include "planner/internal/tool.h"
#include "planner/options.h"

namespace palpate {

// Three touches within ε/3 of each other, as indices of samples, and the way that the tool came.
struct SeedFacet {
    std::array<std::uint32_t, 3> samples{};
    Vector approach = Vector::Zero();  // unit
};

// Touches seeds and initialises `state` with them; then touches the dual edge of every seed facet, from outside ω along
// the edge's line. Returns the seed facets whose crossing was found: no later sample removes them, because a sample is
// farther than ε from all others and the facet's ball is smaller than ε/2 (thesis 4.2.1). Throws SeedError.
std::vector<SeedFacet> touch_seeds(const Workspace& workspace, const Options& options, MaintainedDelaunay& state, Tool& tool);

// The k-th of an endless sequence of unit vectors whose every beginning is well spread over the sphere.
[[nodiscard]] Vector spread_direction(int k);

}  // namespace palpate
