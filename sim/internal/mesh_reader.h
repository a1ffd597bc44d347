// Mesh files to triangles, without judging whether they bound a solid.
#pragma once

#include "planner/geometry.h"
#include "sim/object_spec.h"

namespace palpate {

// Scaled, equal points joined, points of no face dropped, polygons triangulated. Degenerate triangles stay. Throws ObjectError, naming
// the file, if it is missing, empty, of an unknown format or cannot be parsed, or has coordinates that are not finite numbers.
[[nodiscard]] TriangleMesh read_mesh(const MeshSpec& spec);

}  // namespace palpate
