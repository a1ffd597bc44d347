// A mesh as other programs read it. All texts have numbers with the fewest digits that read back to the same bits, but where a format has
// single precision (STL, 3MF).
#pragma once

#include <string>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Unit, outwards: the mean of the triangles around each point by their area; zero where none are.
[[nodiscard]] std::vector<Vector> vertex_normals(const TriangleMesh& mesh);

[[nodiscard]] std::string to_stl(const TriangleMesh& mesh);  // binary
[[nodiscard]] std::string to_obj(const TriangleMesh& mesh);  // with normals
[[nodiscard]] std::string to_off(const TriangleMesh& mesh);
[[nodiscard]] std::string to_vtp(const TriangleMesh& mesh);  // VTK's PolyData in XML, as text, with normals
[[nodiscard]] std::string to_xyz(const TriangleMesh& mesh);  // "x y z nx ny nz", a point a line
// In millimetres. Throws std::runtime_error with what the library says.
[[nodiscard]] std::string to_3mf(const TriangleMesh& mesh);

}  // namespace palpate
