// Meshes of parts as people make them. All are closed and oriented outwards.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

using Polygon = std::vector<std::array<double, 2>>;

inline constexpr double kTwoPi = 2 * std::numbers::pi;

[[nodiscard]] Polygon regular(int corners, double radius, double turned = 0, double x = 0, double y = 0);
// Corners at even angles, at the distances from the origin that radius(k) says.
template <typename Radius>
Polygon around(int corners, const Radius& radius) {
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
        const double angle = kTwoPi * k / corners;
        polygon.push_back({radius(k) * std::cos(angle), radius(k) * std::sin(angle)});
    }
    return polygon;
}

// The first polygon is the outline, counter-clockwise; the others are holes. Half of the height is below z = 0.
[[nodiscard]] TriangleMesh extruded(const std::vector<Polygon>& polygons, double height);
// Its tip up, half of the height below z = 0.
[[nodiscard]] TriangleMesh cone(int corners, double radius, double height);
// Its centre is the origin.
[[nodiscard]] TriangleMesh box(const Vector& size);
// The boundary of a set of cells of a grid with those planes; x, y, z.
[[nodiscard]] TriangleMesh of_cells(const std::array<std::vector<double>, 3>& planes, const std::set<std::array<int, 3>>& cells);
// A cube with a corner at the origin, without the eighth that is farthest from it.
[[nodiscard]] TriangleMesh cut_cube(double side);
// A tube around a curve through those points, which returns to its first or is closed by flat ends.
[[nodiscard]] TriangleMesh tube_along(const std::vector<Point>& centres, double radius, int corners, bool is_closed);
void append(TriangleMesh& mesh, const TriangleMesh& other, const Vector& by);

}  // namespace palpate
