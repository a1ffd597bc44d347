// When a capsule that moves straight first touches a triangle, in closed form.
//
// The capsule is all points within `radius` of the segment from its position p to p + core; a ball if the core is zero. It touches the
// triangle K when p enters K ⊕ −[0, core] ⊕ ball: a prism of five faces, nine edges and six corners, grown by the radius. So what is asked
// is when a ray enters one of: the faces moved outwards, cylinders around the edges, balls around the corners.
#pragma once

#include <array>
#include <optional>

#include "planner/geometry.h"

namespace palpate {

struct Capsule {
    Vector core = Vector::Zero();  // mm
    double radius = 0.0;           // mm, > 0: what has none passes through a face that it touches
};

// Parameter in [0, 1] along the move of p; 0 where it begins within the triangle's reach. Nothing if they do not touch, or only where the
// move begins and it leads away. Exact to rounding: about 1e-9 of the lengths involved, 1e-8 where it only grazes.
[[nodiscard]] std::optional<double> first_contact(const std::array<Point, 3>& triangle, const Capsule& capsule, const Segment& move);

// The same with the half-space of all x with <x, normal> <= offset. REQUIRES: a unit normal.
[[nodiscard]] std::optional<double> first_contact_with_half_space(const Vector& normal, double offset, const Capsule& capsule,
                                                                  const Segment& move);

}  // namespace palpate
