// What the reference point of a machine cannot enter: the hidden object for a point, that and more for a tool with a body (sim/tool).
#pragma once

#include <optional>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// A closed solid and its surface S. Const queries may run at the same time on several threads.
class Obstacle {
public:
    virtual ~Obstacle() = default;

    // First point of S on the segment from its source, inside or outside. A source on S, up to rounding, may be the hit itself or be
    // taken to lie on either side: a caller that starts on S decides for itself what to overlook (SimulatedDevice does).
    [[nodiscard]] virtual std::optional<Point> first_hit(const Segment& segment) const = 0;
    // All points where the segment passes through S, in order from its source. Points where it only touches S may be among them, and
    // near its ends those within rounding may be missing.
    [[nodiscard]] virtual std::vector<Point> crossings(const Segment& segment) const = 0;

    [[nodiscard]] virtual bool contains(const Point& p) const = 0;  // strictly inside
    // mm below S, or a lower bound of it; 0 outside, never negative.
    [[nodiscard]] virtual double depth(const Point& p) const = 0;
    // Unit, out of the solid: of S where a tool that goes in that direction (unit) has touched it, as first_hit() told; at an edge one of
    // those that support the solid there. Against the direction where none can be told.
    [[nodiscard]] virtual Vector normal(const Point& touched, const Vector& direction) const = 0;
    // mm: what positions and lengths are large as; they are exact to about 1e-15 of it, and tolerances are shares of it.
    [[nodiscard]] virtual double scale() const = 0;

protected:
    // Nobody copies or moves one whose kind he does not know.
    Obstacle() = default;
    Obstacle(const Obstacle&) = default;
    Obstacle(Obstacle&&) = default;
    Obstacle& operator=(const Obstacle&) = default;
    Obstacle& operator=(Obstacle&&) = default;
};

}  // namespace palpate
