// Triangles of a mesh file as they are: nothing is mended, and they need not bound a solid (MeshObject's do).
#pragma once

#include <filesystem>

#include "planner/geometry.h"

namespace palpate {

// Reads OFF, PLY, OBJ or STL, by extension. Throws ObjectError, naming the file, if it cannot be read (with the line or byte) or holds
// other faces than triangles.
[[nodiscard]] TriangleMesh read_triangles(const std::filesystem::path& file);

}  // namespace palpate
