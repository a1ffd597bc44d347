// Ŝ as a mesh: the facets whose dual edge is known to meet S (DESIGN section 1).
#pragma once

#include <vector>

#include "planner/internal/maintained_delaunay.h"

namespace palpate {

struct RestrictedSurface {
    TriangleMesh mesh;                     // points are the samples that a facet uses, in order of insertion
    std::vector<std::uint32_t> sample_of;  // by point of the mesh
    // By triangle: the directed edge whose crossing has the smallest ball, which orients the facet (free side outside) ...
    std::vector<DirectedEdge> dual_edges;
    std::vector<double> ball_radii;  // ... and that ball's radius: only the smallest matters (DESIGN section 4)
};

[[nodiscard]] RestrictedSurface extract_surface(const MaintainedDelaunay& state);

}  // namespace palpate
