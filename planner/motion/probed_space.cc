#include "planner/motion/probed_space.h"

#include <cassert>

namespace palpate {

MaintainedDelaunay::Insertion ProbedSpace::insert(const Point& p, CellId near) {
    const MaintainedDelaunay::Insertion insertion = delaunay_.insert(p, near);
    for (const MaintainedDelaunay::Split& split : insertion.splits) {
        const NodeId node = roadmap_.split(split.before, split.beyond, split.vertex);
        delaunay_.place(split, node, roadmap_.at(node));
    }
    return insertion;
}

NodeId ProbedSpace::start_of(DirectedEdge e, const EdgeSpan& along) {
    assert(delaunay_.is_reachable(e));
    assert(along.starts_on_boundary || delaunay_.anchor(e.cell) != kNoAnchor);
    return along.starts_on_boundary ? roadmap_.add_on_boundary(along.start_point()) : delaunay_.anchor(e.cell);
}

Destination ProbedSpace::end_of(DirectedEdge e, const EdgeSpan& along) const {
    if (along.ends_on_boundary) return {along.end_point(), kNoNode, true};
    const CellId far = delaunay_.neighbor(e);
    if (!delaunay_.is_free(far)) return {along.end_point()};
    const NodeId node = delaunay_.anchor(far);
    return {roadmap_.at(node), node};
}

std::optional<Crossing> ProbedSpace::learn_clear(DirectedEdge e, NodeId start, NodeId end) {
    const DirectedEdge back = delaunay_.opposite(e);
    // What an earlier run touched has no ways of this one: the later answer holds.
    if (delaunay_.recorded_state(back) == EdgeState::crossing && delaunay_.crossing(back).near_anchor == kNoAnchor)
        delaunay_.withdraw(back);
    const std::optional<Crossing> graze = delaunay_.take_back_graze(e, roadmap_.at(start));
    if (!delaunay_.is_free(back.cell)) delaunay_.free(back.cell, end);
    if (delaunay_.recorded_state(back) != EdgeState::crossing) {
        delaunay_.learn_clear(e, start, end);
        return graze;
    }
    // S passes through the Voronoi vertex itself: the touch holds for both directions.
    const Crossing touched = delaunay_.crossing(back);
    roadmap_.connect(start, touched.near_anchor);
    learn_contact(e, start, touched.near_anchor, touched.touch);
    return graze;
}

void ProbedSpace::learn_contact(DirectedEdge e, NodeId from, NodeId contact, std::uint32_t touch, bool from_vertex) {
    Crossing seen;
    seen.near = roadmap_.at(contact);
    seen.from = roadmap_.at(from);
    seen.from_vertex = from_vertex;
    seen.from_anchor = from;
    seen.near_anchor = contact;
    seen.touch = touch;
    delaunay_.learn_contact(e, seen);
}

void ProbedSpace::learn_contact_from_outside(DirectedEdge e, const EdgeSpan& along, NodeId entry, NodeId contact, std::uint32_t touch) {
    NodeId from = entry;
    if (!along.starts_on_boundary) {
        from = roadmap_.split(entry, contact, along.start_point());
        if (delaunay_.is_free(e.cell)) {
            roadmap_.connect(from, delaunay_.anchor(e.cell));
        } else {
            delaunay_.free(e.cell, from);
        }
    }
    learn_contact(e, from, contact, touch);
}

bool ProbedSpace::is_valid(std::string* why) const {
    if (!delaunay_.is_valid(why, [this](Anchor anchor) { return roadmap_.at(anchor); })) return false;
    const bool is_sound = roadmap_.is_valid();
    if (!is_sound && why != nullptr) *why = "the roadmap is broken";
    return is_sound;
}

}  // namespace palpate
