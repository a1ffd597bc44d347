// What a caller chooses about a run: sizing, strategy, seeds (DESIGN sections 4 and 5).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// The four independent options of DESIGN section 5. The first value of each is the thesis'.
struct Strategy {
    enum class Refine { exhaustive, eager };
    enum class Explore { exhaustive, closure };
    enum class Infer { none, reach, adaptive };  // adaptive: local bounds that follow the touches, a heuristic
    enum class Travel { voronoi, free_space };

    Refine refine = Refine::eager;
    Explore explore = Explore::closure;
    Infer infer = Infer::reach;
    Travel travel = Travel::free_space;

    friend bool operator==(const Strategy&, const Strategy&) = default;

    [[nodiscard]] static constexpr Strategy adaptive() { return {.infer = Infer::adaptive}; }
    [[nodiscard]] static constexpr Strategy thesis() { return {Refine::exhaustive, Explore::exhaustive, Infer::none, Travel::voronoi}; }
};

struct Options {
    double epsilon = 0.0;         // mm, > 0: upper bound on the radius of every surface Delaunay ball of the result
    std::optional<double> reach;  // mm, > 0: a lower bound on rch(S) that the user vouches for
    Strategy strategy;
    std::optional<double> standoff;       // mm, > 0: how far above S a probe starts where that is proven free; none: epsilon
    double audit = 0.02;                  // share, in [0, 1], of the inferred crossings that are touched anyway
    std::uint64_t random_seed = 1;        // of that choice
    std::vector<Segment> seed_rays;       // one per component at least; empty: rays from the workspace towards its centre
    double refinement_floor = 1.0 / 8.0;  // of epsilon, in (0, 1]: the extra refinement of DESIGN section 4 stops there
};

}  // namespace palpate
