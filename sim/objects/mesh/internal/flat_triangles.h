// Triangles whose corners are on one line.
#pragma once

#include <cstddef>

#include "planner/geometry.h"

namespace palpate {

// By exact arithmetic.
[[nodiscard]] std::size_t count_flat_triangles(const TriangleMesh& mesh);

// Drops them, and returns how many there were. Where one lies between an edge and two parts of it, the other triangle of the edge is cut
// in two at the corner between them: what was closed stays closed, and no point of the surface moves. Likewise where rounding has put that
// corner beyond the edge, by at most 1e-6 of the mesh's size, so that the triangle lies folded back on the other one;
// and where it is lower than 1e-12 of its length, coplanar with the other or not.
std::size_t drop_flat_triangles(TriangleMesh& mesh);

}  // namespace palpate
