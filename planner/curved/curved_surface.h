// A curved surface through the touches, on the facets of a mesh (planner/DESIGN.md, "A curved surface").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct TouchedMesh {
    TriangleMesh mesh;                  // its points are touches
    std::vector<double> error;          // per point, mm, >= 0: how far it may be from the surface; infinite: unknown. Empty: 0
    std::vector<std::uint8_t> is_flat;  // per triangle: 1 stays a plane, nothing is known of its surface. Empty: none does
};

struct CurvedOptions {
    double epsilon = 0.0;                    // mm, > 0: no point is farther from its facet
    int segments = 6;                        // in [1, 64]: of every edge; a facet becomes its square
    std::size_t largest_facets = 1'000'000;  // fewer segments if there were more, one at least
};

// Where a point of the surface lies.
enum class CurvedTag : std::uint8_t {
    smooth,
    crease,  // on an edge that stays sharp, or on the boundary
    corner,  // creases end or meet there
    flat,    // on a facet, or the edge of one, that stayed a plane
};

struct CurvedSurface {
    TriangleMesh mesh;                             // first the points of the mesh that it is made of, with their numbers
    std::vector<Vector> normals;                   // per point: unit, outwards; at creases the mean of the sides'
    std::vector<std::array<double, 2>> curvature;  // per point, 1/mm: principal, the larger first; positive where it is convex
    // Per point, mm: the surface is nearer than that in 95 of 100 places; infinite where an error is.
    std::vector<double> uncertainty;
    std::vector<CurvedTag> tags;          // per point
    std::vector<std::uint32_t> facet_of;  // per triangle: the facet that it is a part of
    std::vector<std::uint32_t> crossing;  // facets that stayed planes as they passed through others otherwise, in order
};

// Watertight wherever `touched.mesh` is. Linear in its points but for a search for facets that pass through each other. Throws
// std::invalid_argument if a triangle names a point that there is not, if a point is not finite, if lists are not as long as the mesh's, or
// if `options` are out of their ranges.
[[nodiscard]] CurvedSurface curve(const TouchedMesh& touched, const CurvedOptions& options);

}  // namespace palpate
