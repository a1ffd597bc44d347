// Level sections of a mesh, and the drawing of them that CAD and CAM read.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct Polyline {
    std::vector<std::array<double, 2>> points;  // x, y in mm; the inside is to the left
    bool is_closed = false;                     // the first point follows the last
};

// Where the surface passes the height z. A corner exactly there counts as below. Closed where the mesh is.
[[nodiscard]] std::vector<Polyline> section(const TriangleMesh& mesh, double z);

// DXF R12, flat polylines at their heights, a layer for each: what the oldest and the smallest readers take, too.
[[nodiscard]] std::string to_dxf(const TriangleMesh& mesh, std::span<const double> heights);

}  // namespace palpate
