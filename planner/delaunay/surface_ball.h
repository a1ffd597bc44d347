// Surface Delaunay balls, for who waits to refine one.
#pragma once

#include <cstdint>

#include "planner/delaunay/maintained_delaunay.h"

namespace palpate {

// By its crossing: insertions move and remove edges.
struct SurfaceBall {
    double radius = 0.0;  // mm
    CrossingId id = kNoCrossing;
    std::uint32_t generation = 0;

    // Largest first; among equals the first found.
    friend bool operator<(const SurfaceBall& x, const SurfaceBall& y) { return x.radius != y.radius ? x.radius < y.radius : x.id > y.id; }
};

// REQUIRES: the edge holds a crossing.
[[nodiscard]] inline SurfaceBall ball_of(const MaintainedDelaunay& state, DirectedEdge e) {
    const CrossingId id = state.crossing_id(e);
    return {state.crossing(e).ball_radius, id, state.generation_of(id)};
}

// The direction whose crossing is to be refined: of an edge that S crosses twice the one with the larger ball, because a sample is
// missing there; but where S was not touched no sample can be.
[[nodiscard]] inline DirectedEdge larger_ball(const MaintainedDelaunay& state, DirectedEdge e) {
    if (!state.is_double(e)) return e;
    const DirectedEdge back = state.opposite(e);
    if (state.crossing(back).inferred) return e;
    return state.crossing(e).inferred || ball_of(state, e) < ball_of(state, back) ? back : e;
}

}  // namespace palpate
