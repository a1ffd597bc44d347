// Two planes near a crease as one: what lies on the second is turned about the crease into the first, and back. A lattice goes on over a
// crease so, as it would over a bend.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "planner/geometry.h"

namespace palpate {

class Fold {
public:
    // The planes through `first` and `second` with those unit normals, out of the solid. Nothing where they are nearly parallel, or one
    // point is above the other's plane and the other below: no crease lies between them then.
    [[nodiscard]] static std::optional<Fold> between(const Point& first, const Vector& first_normal, const Point& second,
                                                     const Vector& second_normal) {
        constexpr double kLeastSine = 0.3;
        const Vector across = second_normal - second_normal.dot(first_normal) * first_normal;
        const double sine = across.norm();
        if (sine < kLeastSine) return std::nullopt;
        const double here = second_normal.dot(first - second);
        const double there = first_normal.dot(second - first);
        if ((here > 0) != (there > 0)) return std::nullopt;
        const double turn = here < 0 ? 1 : -1;  // convex: away from the solid
        Fold fold;
        fold.crease_ = first - here / sine * (across / sine);
        fold.across_ = turn * across / sine;
        fold.beyond_ = -turn * (first_normal - first_normal.dot(second_normal) * second_normal) / sine;
        return fold;
    }

    // mm: how far a point of the first plane lies beyond the crease.
    [[nodiscard]] double past(const Point& p) const { return (p - crease_).dot(across_); }
    // From the first plane, beyond the crease, onto the second, ...
    [[nodiscard]] Point fold(const Point& p) const { return p + past(p) * (beyond_ - across_); }
    // ... and back.
    [[nodiscard]] Point unfold(const Point& p) const { return p + (p - crease_).dot(beyond_) * (across_ - beyond_); }

private:
    Point crease_ = Point::Zero();    // a point of it
    Vector across_ = Vector::Zero();  // in the first plane, orthogonal to the crease, towards the second
    Vector beyond_ = Vector::Zero();  // in the second plane, away from the first
};

}  // namespace palpate
