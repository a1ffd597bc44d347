// Is a triangle mesh the surface of a solid?
#pragma once

#include <string>
#include <vector>

#include "planner/geometry.h"
#include "sim/objects/pose.h"

namespace palpate {

// What keeps the mesh from being the boundary of a solid, one phrase with counts and advice for each problem; empty if it is one, up to
// being inside out.

// How triangles hang together: holes with the length and a place of the largest, in mm, `scale` to a unit of the mesh and placed by
// `pose`; edges and vertices that are not manifold; one-sidedness.
[[nodiscard]] std::vector<std::string> topology_problems(const TriangleMesh& mesh, double scale, const Pose& pose);

// Where they are: degenerate triangles and self-intersections. Only for a mesh without the problems above.
[[nodiscard]] std::vector<std::string> geometry_problems(const TriangleMesh& mesh);

}  // namespace palpate
