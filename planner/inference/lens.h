// Where a bound on the reach proves space free, or inside, near a touched point (planner/DESIGN.md, "Inference").
//
// Notation as in normal_cone.h. If n is the outward normal at a, then B(a + r n, r) is free and B(a - r n, r) inside O. With n known to lie
// in a cone only, what all its normals agree on remains:
//   exterior lens  the x with |x - a|² < 2 r <x - a, n> for all n of the cone
//   interior lens  the same with -n
// The n with <x - a, n> >= c >= 0 are a spherical cap not larger than a half-sphere, which is convex; so it holds the cone as soon as
// it holds the cone's extremes. A lens is therefore the intersection of one ball of radius r for each of them, and convex.
// a itself is on the boundary of both.
#pragma once

#include <optional>
#include <span>

#include "planner/geometry.h"
#include "planner/surroundings.h"

namespace palpate {

enum class Side : std::int8_t { exterior = 1, interior = -1 };

struct Lens {
    const Point& apex;                // a
    std::span<const Vector> normals;  // the extremes of a cone that is known
    double reach = 0.0;               // r, mm
    double margin = 0.0;              // mm: points of the lens are at least so deep in every ball
    Side side = Side::exterior;

    [[nodiscard]] bool contains(const Point& x) const;
    // The parameters t for which origin + t·direction lies in the lens. `direction` is a unit vector.
    [[nodiscard]] std::optional<Interval> clip(const Point& origin, const Vector& direction) const;
};

}  // namespace palpate
