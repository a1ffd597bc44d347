// From the faces that programs write to the triangles that they mean.
#pragma once

#include <string>
#include <vector>

#include "sim/objects/mesh/internal/polygon_soup.h"

namespace palpate {

// A kind of defect that was mended, for messages: "3 faces without area" "were dropped".
struct Repair {
    std::string defect;
    std::string remedy;
};

struct RepairedMesh {
    TriangleMesh mesh;  // in the file's unit, all points used
    std::vector<Repair> repairs;
};

// Equal points are joined and polygons cut into triangles, which STL and faces of more corners need; that is no repair. Besides:
//   1. Corners at open edges that almost coincide are joined (internal/mesh_weld.h).
//   2. Faces without area are dropped (internal/flat_triangles.h), and faces that are there already.
//   3. Triangles that face the other way than those around them are turned (internal/orientation.h).
// No hole is filled but one too narrow to be told from a crack. What cannot be mended so is left for the checks (internal/mesh_check.h).
// Lengths in messages are in mm, `scale` to a unit of the file. Deterministic.
[[nodiscard]] RepairedMesh repaired(PolygonSoup soup, double scale);

}  // namespace palpate
