// Is a facet of Ŝ bad? (Chew's criteria, thesis chapter 4.) The loop asks; nothing else decides on refinement.
#pragma once

#include "planner/options.h"

namespace palpate {

class Criteria {
public:
    explicit Criteria(const Options& options) : epsilon_(options.epsilon), floor_(options.refinement_floor * options.epsilon) {}

    // A surface Delaunay ball larger than ε: its centre becomes a sample.
    [[nodiscard]] bool is_bad(double ball_radius) const { return ball_radius > epsilon_; }
    // Whether a ball at a defect of Ŝ may still be refined (DESIGN section 4).
    [[nodiscard]] bool may_repair(double ball_radius) const { return ball_radius > floor_; }
    // No sample may come nearer to an earlier one than this: the packing bound on which termination rests (DESIGN
    // section 3) is guarded numerically. `repair` samples keep a wider packing.
    [[nodiscard]] double spacing(bool repair) const { return (repair ? floor_ : epsilon_) * (1 - kRounding); }

private:
    static constexpr double kRounding = 1e-9;  // relative: distances of touched points, far above their rounding
    double epsilon_;
    double floor_;
};

}  // namespace palpate
