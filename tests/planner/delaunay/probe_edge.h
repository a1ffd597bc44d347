// A probe of a dual edge as the planner makes it, answered by a surface in closed form.
#pragma once

#include <gtest/gtest.h>

#include "planner/motion/probed_space.h"

namespace palpate {

// `first_hit(from, to)`: the first point of S on the way, if there is one. `touches` numbers them. REQUIRES: reachable and unknown. Returns
// whether S was touched.
template <typename FirstHit>
bool probe_edge(ProbedSpace& space, DirectedEdge e, const FirstHit& first_hit, std::uint32_t& touches) {
    const EdgeSpan along = *space.delaunay().span(e);
    const NodeId start = space.start_of(e, along);
    const Destination end = space.end_of(e, along);
    Roadmap& roadmap = space.roadmap();
    if (const auto hit = first_hit(roadmap.at(start), end.position)) {
        space.learn_contact(e, start, roadmap.add(start, *hit), touches++);
        return true;
    }
    // The tool stops at the target, exactly, and that node is where the planner takes it to be.
    const NodeId arrived = roadmap.add(start, end);
    EXPECT_EQ(roadmap.at(arrived), end.position);
    space.learn_clear(e, start, arrived);
    return false;
}

}  // namespace palpate
