// The straight way that a move was told to take. What a machine reports only ever selects a point of it (devices/FACTS.md, "Safety floor").
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "devices/motion_model.h"
#include "planner/geometry.h"

namespace palpate {

// Places are mm from the start. REQUIRES: start and target differ.
struct Way {
    Way(const Point& from, const Point& to) : start(from), target(to), length((to - from).norm()), direction((to - from) / length) {}

    // The point at that place; the target itself at the end and beyond.
    [[nodiscard]] Point at(double place) const { return place >= length ? target : Point(start + place * direction); }
    // Of the point of the way that is nearest to `p`.
    [[nodiscard]] double place_of(const Point& p) const { return std::clamp((p - start).dot(direction), 0.0, length); }
    // mm: how far `p` is from the way.
    [[nodiscard]] double distance_to(const Point& p) const { return (p - at(place_of(p))).norm(); }

    Point start;
    Point target;
    double length;  // mm, > 0
    Vector direction;
};

// mm: from where the probe changed to where the tool stands, at most; what stops farther from it did not stop for it. `tolerance`: mm, how
// exactly the machine can say where it is.
[[nodiscard]] double longest_overrun(const MotionModel& motion, double feed_mm_per_s, double tolerance);
// To the resolution of the machine's positions.
[[nodiscard]] Point rounded(const MotionModel& motion, const Point& p);
// So far before `place` as a retract goes, but not past `start`; rounded.
[[nodiscard]] Point retracted(const MotionModel& motion, const Point& place, const Point& start);

// Where a guarded move is said to have ended, in the coordinates of its way.
struct WayEnd {
    std::optional<Point> touched{};  // nothing: at the target
    Point rest = Point::Zero();
};

// What of that cannot be true, as "reports a contact at ..., which is not on its way"; empty: nothing. `tolerance`: mm, how exactly the
// machine can say where it is.
[[nodiscard]] std::string problem_of(const WayEnd& end, const Way& way, double tolerance);

}  // namespace palpate
