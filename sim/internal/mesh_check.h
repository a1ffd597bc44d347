// Is a triangle mesh the surface of a solid?
#pragma once

#include <string>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Everything that keeps the mesh from being the boundary of a solid, one phrase with a count and advice for each problem: degenerate
// triangles, boundary edges, non-manifold edges and vertices, inconsistent orientation, self-intersections. Empty if it is one, up to
// being inside out. Self-intersections are looked for only where the rest allows it.
[[nodiscard]] std::vector<std::string> mesh_problems(const TriangleMesh& mesh);

// Turns components of a mesh without problems so that they bound a solid: outermost components outwards, what is nested in them
// alternately inwards and outwards. Returns a warning for every kind of change and for cavities, which no touch can find.
[[nodiscard]] std::vector<std::string> orient_outward(TriangleMesh& mesh);

}  // namespace palpate
