// The surface over one facet: the zero of its corners' splines, blended.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "planner/curved/internal/facet_sides.h"
#include "planner/curved/internal/local_spline.h"

namespace palpate {

// What is known of one side of one point.
struct SideSurface {
    std::optional<LocalSpline> spline;
    // mm: root mean squares over it and the sides around.
    double surprise = 0.0;
    double far_surprise = 0.0;
};

// At most three sides with their shares of a place: barycentric coordinates.
struct Share {
    const FacetSides::Side* side = nullptr;
    const SideSurface* surface = nullptr;
    double share = 0.0;
};

struct BlendedPlace {
    Point point = Point::Zero();
    Vector normal = Vector::UnitZ();        // unit
    std::array<double, 2> curvature{0, 0};  // 1/mm, the larger first
};

// Blended by the cubes of the shares, so that on an edge the third corner has no part in value and slope.
class Blend {
public:
    explicit Blend(std::array<Share, 3> shares);

    [[nodiscard]] bool is_valid() const { return is_valid_; }  // all that has a share has a spline and a normal
    // The place that `from` goes to along the mean of the normals. Nothing where that is farther than `most` (mm), or cannot be told.
    [[nodiscard]] std::optional<BlendedPlace> project(const Point& from, double most) const;
    [[nodiscard]] LocalSpline::Jet jet(const Point& p) const;
    [[nodiscard]] BlendedPlace at(const Point& p) const;  // p with the normal and the curvature there

private:
    std::array<Share, 3> shares_;
    std::array<double, 3> weights_{};
    Vector direction_ = Vector::Zero();
    bool is_valid_ = false;
};

// The place nearest to `from` where both are zero: a crease. Nothing where that is farther than `most` (mm), or cannot be told.
[[nodiscard]] std::optional<Point> crease_place(const Blend& one, const Blend& other, const Point& from, double most);

}  // namespace palpate
