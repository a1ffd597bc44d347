// Where a sphere is touched, and the ways between: pure, so that whatever drives a ProbeDevice can follow it.
#pragma once

#include <cstddef>
#include <vector>

#include "devices/calibration/qualification.h"
#include "planner/tool_shape.h"

namespace palpate {

// ISO 10360-5's 25 directions on the half of a sphere around `axis` (unit): the pole, then rings of 4, 8, 4 and 8 at 67.5, 45, 22.5 and 0
// degrees above the equator, each turned by 22.5 degrees against the one before (NPL Good Practice Guide 42). Unit, outwards.
[[nodiscard]] std::vector<Vector> iso_directions(const Vector& axis);

// These, and `count` less 25 more, on a spiral from near the equator to near the pole. REQUIRES: count >= 25.
[[nodiscard]] std::vector<Vector> qualification_directions(const Vector& axis, std::size_t count);

// The pole and a ring of four at 30 degrees: high enough that the ball touches first where the centre is not yet known.
[[nodiscard]] std::vector<Vector> centering_directions(const Vector& axis);

// Which of ISO's directions are touched again for the repeatability: the pole, two at 45 degrees, two on the equator.
[[nodiscard]] std::vector<std::size_t> repeated_directions();

struct TouchMargins {
    double center_error_mm = 0.8;  // > 0: so far may the sphere's centre be from where it is said to be
    double clearance_mm = 2.0;     // > 0: ways pass the sphere at that distance at least
};

struct PlannedTouch {
    Vector normal = Vector::UnitZ();  // unit, outwards
    std::vector<Point> way;           // straight from one to the next; the last is where the touch begins, on the normal
    Point target = Point::Zero();     // the touch goes straight to the sphere's centre; here it has to have met the sphere
};

// To be followed in order. After each touch the tool goes straight back to where the touch began: off along the normal.
struct TouchPlan {
    std::vector<PlannedTouch> touches;
    std::vector<Point> leave;  // after the last: to above the pole
};

// mm: so far may a probe give way before it triggers, and the ball's diameter be wrong; beyond the margin it is no touch of this sphere.
inline constexpr double kMostPretravel_mm = 0.3;

// mm: the touched centre's distance from the sphere's.
[[nodiscard]] double touched_distance(const ReferenceSphere& sphere, const ToolShape& tool);
// mm: the same at the most; farther out there is no sphere to be touched.
[[nodiscard]] double farthest_touch(const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins);

// From `from`, which lies above the equator (or on it) and touches nothing. Ways go around the sphere, never nearer to its centre than
// touches begin, and never below the equator. They lie in planes through its centre: from one side to the other over the pole. Throws
// QualificationError if `from` lies elsewhere, a number makes no sense, the tool's holder would touch the sphere, or a direction is below
// the equator.
[[nodiscard]] TouchPlan plan_touches(const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins, const Point& from,
                                     const std::vector<Vector>& directions);

}  // namespace palpate
