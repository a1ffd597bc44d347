// Where a line segment meets a primitive's surface.
//
// Notation: u the segment's direction, d the distance to S at the current point, c the cosine between u and the direction
// away from S there, ρ the reach on the side we are on (inside or outside the solid).
//
// Sphere and ellipsoid: closed form. Other convex solids: the distance is convex along u, so Newton's method from outside
// approaches the first point of S from one side and cannot jump over it. The others: the open ball of radius ρ tangent to S at the nearest
// point, on our side of S, misses S (planner/DESIGN.md, "Inference"). Going to where u leaves that ball never jumps over S thin as O is;
// far from S this is sphere tracing, near S it is Newton's method, along S it takes steps of √(2ρd) instead of d.
#pragma once

#include <optional>
#include <vector>

#include "sim/objects/internal/primitive.h"

namespace palpate {

struct Ray {
    Point origin = Point::Zero();
    Vector direction = Vector::UnitX();  // unit
    double length = 0.0;                 // mm
};

// Least t in [0, length] with origin + t * direction on S; 0 if the origin is within `tolerance` (mm) of S.
[[nodiscard]] std::optional<double> first_hit(const Primitive& primitive, const Ray& ray, double tolerance);

// All t in [0, length] where the ray passes from one side of S to the other, increasing, appended to `out`. Touches without
// passing do not count; within `tolerance` of the ends anything goes.
void append_crossings(const Primitive& primitive, const Ray& ray, double tolerance, std::vector<double>& out);

}  // namespace palpate
