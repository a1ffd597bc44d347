// What of O stays thinner than the samples show, and whether Ŝ is right without it.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/delaunay/restricted_surface.h"

namespace palpate {

// The facets of dual edges that S crosses twice, each from one side only.
[[nodiscard]] std::vector<DirectedEdge> doubly_crossed(const MaintainedDelaunay& state);

// Facets that S crosses twice hang together through edges and vertices that Ŝ does not have: such a patch stands for a wall, or for the
// rest of a sharp edge, without thickness. Samples that nothing uses are places of their own.
struct ThinPlace {
    Point position = Point::Zero();  // of its thinnest facet, or of the sample
    double thickness = 0.0;          // mm: of the thinnest; 0 for a sample
    std::uint32_t unused = 0;        // samples here that Ŝ does not use
    // Ŝ with the patch has the topology of Ŝ, as far as Euler characteristics tell: patch and what it shares with Ŝ are connected and
    // have characteristic 1 (a flap along a sharp edge; not a wall that closes a hole, a bridge, or something apart). And every unused
    // sample is within epsilon of a used one.
    bool is_minor = false;
};

// In the order of their first facets. Linear time but for sorting.
[[nodiscard]] std::vector<ThinPlace> find_thin_places(const MaintainedDelaunay& state, const RestrictedSurface& surface, double epsilon);

}  // namespace palpate
