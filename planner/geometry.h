// Value types that every module shares. Lengths are millimetres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace palpate {

using Point = Eigen::Vector3d;
using Vector = Eigen::Vector3d;

struct Segment {
    Point source = Point::Zero();
    Point target = Point::Zero();
};

// An indexed triangle mesh; triangles are counter-clockwise seen from outside the solid.
struct TriangleMesh {
    std::vector<Point> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace palpate
