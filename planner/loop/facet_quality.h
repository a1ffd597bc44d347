// The facets of a closed Ŝ that do not fulfil the criteria of sizing and angles (thesis 5.3, 5.4).
#pragma once

#include <cstdint>
#include <vector>

#include "planner/criteria.h"
#include "planner/delaunay/restricted_surface.h"

namespace palpate {

struct BadFacet {
    std::uint32_t facet = 0;  // of the surface's mesh
    double spacing = 0.0;     // mm: what the centre of its ball, as a sample, keeps
};

// `is_seed`, by sample: facets at a persistent facet may have any angles, as its samples are nearer than ε. The radius of
// curvature is estimated by how much the normal turns from a facet to its neighbours. Linear time.
[[nodiscard]] std::vector<BadFacet> find_bad_facets(const MaintainedDelaunay& state, const RestrictedSurface& surface,
                                                    const Criteria& criteria, const std::vector<bool>& is_seed);

}  // namespace palpate
