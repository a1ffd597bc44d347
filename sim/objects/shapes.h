// Exact solids: what a ShapeSpec describes, with distances and line hits to rounding and measures in closed form.
//
// Reach of each (least distance from S to its medial axis):
//   sphere       radius
//   ellipsoid    c²/a, the least radius of curvature (at the tip of the longest semi-axis a, towards the shortest, c)
//   torus        min(minor, major - minor): its core circle, its axis
//   capsule      radius
//   rounded box  fillet; 0 for a sharp box
//   genus2       0.2 × scale. At scale 1 the solid is all points within r = 0.2 of a flat plate K in the plane z = 0: the points within 0.6
//                of the segment from (-0.6, 0) to (0.6, 0), without the open discs of radius 0.4 around its ends. Inside, K is the medial
//                axis, at distance r. Outside, a point has several nearest points of K only on the axes of the holes, at distance 0.4 or
//                more from K, so 0.4 - r from S. So the reach is min(r, 0.4 - r) = 0.2, and the signed distance is d(x, K) - r on both
//                sides. Euler characteristic -2. Outer size 2.8 × 1.6 × 0.4.
//   union        the least of its parts' and half the smallest gap between two parts. A medial point that has its nearest points
//                on two parts is at least half their gap from both, and the middle of the gap is one; one with all of them on one part is
//                no nearer than that part's reach, and is only lost if another part is nearer still, which then makes the gap the smaller.
#pragma once

#include <optional>
#include <vector>

#include "sim/objects/object_spec.h"

namespace palpate {

struct PlacedPart;

class Shape {
public:
    // Throws ObjectError if a parameter is out of range or not finite, a union is empty, or two parts of a union overlap or touch.
    explicit Shape(const ShapeSpec& spec);
    ~Shape();
    Shape(Shape&&) noexcept;
    Shape& operator=(Shape&&) noexcept;

    // mm, negative inside; exact to rounding (about 1e-15 of the shape's size).
    [[nodiscard]] double signed_distance(const Point& p) const;
    // One of the nearest points of S.
    [[nodiscard]] Point closest_point(const Point& p) const;
    [[nodiscard]] bool contains(const Point& p) const { return signed_distance(p) < 0.0; }

    // First point of S on the segment, counted from its source, which may be inside or outside. Never misses one, however thin the
    // solid is there. A source within rounding (1e-14 of size and distance from the origin) of S is itself the first hit, whichever way the
    // segment goes on.
    [[nodiscard]] std::optional<Point> first_hit(const Segment& segment) const;
    // All points where the segment passes from one side of S to the other, in order from its source. Touching without passing does
    // not count. S within rounding of an end may count or not.
    [[nodiscard]] std::vector<Point> crossings(const Segment& segment) const;

    [[nodiscard]] const Box& bounds() const { return bounds_; }
    [[nodiscard]] int euler_characteristic() const { return euler_characteristic_; }
    [[nodiscard]] int components() const;
    [[nodiscard]] double reach() const { return reach_; }  // mm

private:
    std::vector<PlacedPart> parts_;  // unions, nested too, are flattened
    Box bounds_;
    int euler_characteristic_ = 0;
    double reach_ = 0.0;
};

}  // namespace palpate
