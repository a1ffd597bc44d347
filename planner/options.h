// What a caller chooses about a run: sizing, strategy, seeds (planner/DESIGN.md, "Guarantees" and "Strategy").
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Of epsilon: samples of persistent facets are at least so far apart (planner/loop/seeding.h).
inline constexpr double kSeedSpacing = 1.0 / 128.0;

// The four independent options of planner/DESIGN.md, "Strategy". The first value of each is the thesis'.
struct Strategy {
    enum class Refine { exhaustive, eager };
    enum class Explore { exhaustive, closure };
    // reach: what a bound proves; adaptive: what is plausible by the samples around; automatic: reach where one is given, else adaptive.
    enum class Infer { none, reach, adaptive, automatic };
    enum class Travel { voronoi, free_space };

    Refine refine = Refine::eager;
    Explore explore = Explore::closure;
    Infer infer = Infer::automatic;
    Travel travel = Travel::free_space;

    friend bool operator==(const Strategy&, const Strategy&) = default;

    [[nodiscard]] static constexpr Strategy adaptive() { return {.infer = Infer::adaptive}; }
    [[nodiscard]] static constexpr Strategy thesis() { return {Refine::exhaustive, Explore::exhaustive, Infer::none, Travel::voronoi}; }
};

// Where smaller facets are wanted.
struct RegionOfInterest {
    Box box;             // a point if its corners are the same
    double size = 0.0;   // mm, > 0: radius of surface Delaunay balls there
    double slope = 0.5;  // in [0, 1]: how that grows with the distance from the box, up to epsilon
};

// Smaller facets than epsilon asks for (thesis 5.4).
struct Sizing {
    std::vector<RegionOfInterest> regions;
    double radii_of_curvature = 0.0;  // balls are at most that many of the surface's radii of curvature, as estimated; 0: any
    std::optional<double> smallest;   // mm, > 0: that criterion refines nothing smaller; none: twice the refinement floor
};

// A run that used up one of these after its seeds ends, incomplete. What is under way is finished.
struct Budget {
    std::optional<std::uint64_t> probes;
    std::optional<double> displacement;  // mm
    std::optional<double> machine_time;  // s, as estimate_machine_time() has it
};

// A place of S that an earlier run touched.
struct EarlierTouch {
    Point position = Point::Zero();
    Point from = Point::Zero();  // where the probe that found it started: from there to it all was free
    bool is_sample = false;      // of that run
};

struct Options {
    double epsilon = 0.0;         // mm, > 0: upper bound on the radius of every surface Delaunay ball of the result
    std::optional<double> reach;  // mm, > 0: a lower bound on rch(S) that the user vouches for
    Strategy strategy;
    std::optional<double> standoff;  // mm, > 0: how far above S a probe starts where that is proven free; none: half of epsilon
    double trust = 0.01;            // in [0, 1]: a plausible facet that is 8 times as likely wrong is touched; 0: all that is not proven is
    double audit = 0.01;            // share, in [0, 1], of the inferred facets that are touched anyway (planner/loop/audit.h)
    std::uint64_t random_seed = 1;  // of the choice of audited facets
    std::vector<Segment> seed_rays;       // one per component at least; empty: rays from the workspace towards its centre
    double refinement_floor = 1.0 / 8.0;  // of epsilon, in (0, 1]: the extra refinement of planner/DESIGN.md, "Repair" stops there
    // mm, > 0: a curved surface through the samples is to be that near to S in 99 of 100 places, as touches foretell; samples are as near
    // to each other as that takes. None: as near as epsilon asks.
    std::optional<double> tolerance;
    std::optional<double> spacing_min;  // mm, > 0: with a tolerance samples come no nearer; none: the tolerance, or 20 touch errors
    std::optional<Box> tolerance_box;   // the tolerance is asked for in there alone; none: everywhere
    // Known before anything moves (planner/DESIGN.md, "Going on"). Some are touched again, and have to be within the limit (mm, > 0) of
    // where they were; none: a hundredth of epsilon or, if less, half the tolerance; but no less than five touch errors.
    std::vector<EarlierTouch> earlier;
    std::optional<double> earlier_limit;
    Sizing sizing;
    double min_angle = 0.0;  // rad, in [0, π/6]: triangles with a smaller angle are refined, away from seeds (thesis 5.3)
    Budget budget;
    bool goes_home = false;  // whether the tool is brought back to where it began

    // What the strategy infers from, never `automatic`.
    [[nodiscard]] constexpr Strategy::Infer inference() const {
        if (strategy.infer != Strategy::Infer::automatic) return strategy.infer;
        return reach ? Strategy::Infer::reach : Strategy::Infer::adaptive;
    }
};

}  // namespace palpate
