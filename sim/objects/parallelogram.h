// What the axis of a tool sweeps on a straight move, and how far that is from triangles.
#pragma once

#include <array>

#include "planner/geometry.h"

namespace palpate {

// All points corner + s u + t v with s and t in [0, 1]: a segment or a point where u, v, or both are zero or parallel.
struct Parallelogram {
    Point corner = Point::Zero();
    Vector u = Vector::Zero();  // mm
    Vector v = Vector::Zero();  // mm

    [[nodiscard]] Point at(double s, double t) const { return corner + s * u + t * v; }
};

// mm: 0 where they meet. Exact to rounding.
[[nodiscard]] double distance(const Parallelogram& swept, const std::array<Point, 3>& triangle);

}  // namespace palpate
