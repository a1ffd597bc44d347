// How far a run is, for whoever watches it.
#pragma once

#include <cstdint>

namespace palpate {

struct Progress {
    std::uint64_t samples = 0;
    std::uint64_t probes = 0;          // guarded moves that asked for an answer
    double worst_ball_radius = 0.0;    // mm: of the surface Delaunay balls seen and not yet refined; 0 before the first
    double epsilon = 0.0;              // mm
    std::uint64_t open_edges = 0;      // edges of Ŝ, or Voronoi edges under exhaustive exploration, still to look at
    std::uint64_t audited = 0;         // facets that were touched to see whether what is inferred is right
    std::uint64_t audits_left = 0;     // about how many more will be
    double fraction_done = 0.0;        // estimate in [0, 1], never falling
    std::uint64_t tolerance_left = 0;  // about how many touches a tolerance will take still
};

}  // namespace palpate
