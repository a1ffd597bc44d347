// Is a facet of Ŝ bad? (Chew's criteria, thesis chapter 4; sizing fields and angles: 5.3, 5.4.) The loop asks; nothing else decides on
// refinement.
#pragma once

#include <optional>
#include <vector>

#include "planner/options.h"

namespace palpate {

class Criteria {
public:
    explicit Criteria(const Options& options);

    // mm: the size that is wanted at p by `options.sizing.regions`, at most ε. 1-Lipschitz, as slopes are at most 1.
    [[nodiscard]] double size_at(const Point& p) const;
    // A surface Delaunay ball larger than the size at its centre: its centre becomes a sample.
    [[nodiscard]] bool is_bad(double ball_radius, const Point& centre) const { return ball_radius > size_at(centre); }

    // The criteria that need more of Ŝ than one ball; asked once Ŝ is closed.
    [[nodiscard]] bool look_at_facets() const { return !sizing_.regions.empty() || sizing_.radii_of_curvature > 0 || min_angle_ > 0; }
    // Whether a facet is too large for the surface's estimated radius of curvature (mm) there.
    [[nodiscard]] bool is_too_flat(double ball_radius, double radius_of_curvature) const;
    // Whether the smallest angle of a triangle is too small. The ball is not smaller than the shortest edge then, so its
    // centre keeps the samples' spacing (thesis 5.3).
    [[nodiscard]] bool is_skinny(const Point& a, const Point& b, const Point& c) const;

    // Whether a ball at a defect of Ŝ may still be refined (planner/DESIGN.md, "Repair").
    [[nodiscard]] bool may_repair(double ball_radius) const { return ball_radius > floor_; }
    // No sample may come nearer to an earlier one than this, seeds and what is refined for angles aside: the packing bound on
    // which termination rests (planner/DESIGN.md, "What a run may cost") is guarded numerically.
    [[nodiscard]] double spacing(const Point& p) const { return size_at(p) * kRounding; }
    // The same for repairs at defects.
    [[nodiscard]] double repair_spacing() const { return floor_ * kRounding; }
    // The smallest spacing anywhere.
    [[nodiscard]] double least_spacing() const { return least_ * kRounding; }

private:
    static constexpr double kRounding = 1 - 1e-9;  // distances of touched points, far above their rounding
    double epsilon_;
    double floor_;
    double least_;
    Sizing sizing_;
    double min_angle_;
};

}  // namespace palpate
