// Ŝ as a mesh: the facets whose dual edge is known to cross S once (planner/DESIGN.md, "Terms").
//
// Where S was met from both ends of a dual edge, at two places, both ends are free and the facet lies between free cells: a wall passes
// between its samples. Left out, what remains is the boundary of a union of cells, as far as all is explored: every edge has an even number
// of facets, however thin or sharp O is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/delaunay/maintained_delaunay.h"

namespace palpate {

struct RestrictedSurface {
    TriangleMesh mesh;                     // points are the samples that a facet uses, in order of insertion
    std::vector<std::uint32_t> sample_of;  // by point of the mesh
    // By triangle: the directed edge whose crossing has the smallest ball, which orients the facet (free side outside) ...
    std::vector<DirectedEdge> dual_edges;
    std::vector<double> ball_radii;  // ... and that ball's radius: only the smallest matters (planner/DESIGN.md, "Guarantees")

    // Of the mesh; nothing if no facet uses the sample.
    [[nodiscard]] std::optional<std::uint32_t> point_of(std::uint32_t sample) const;
    // Those that no facet uses, of so many.
    [[nodiscard]] std::vector<std::uint32_t> unused_samples(std::size_t sample_count) const;
};

[[nodiscard]] RestrictedSurface extract_surface(const MaintainedDelaunay& state);

}  // namespace palpate
