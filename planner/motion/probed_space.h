// What probes have proven: in the triangulation, and as ways that the tool can go. Anchors of the one are nodes of the other.
#pragma once

#include <optional>
#include <string>

#include "planner/delaunay/maintained_delaunay.h"
#include "planner/motion/roadmap.h"

namespace palpate {

class ProbedSpace {
public:
    // `touch_error` (mm): as MaintainedDelaunay has it.
    explicit ProbedSpace(const Surroundings& surroundings, double touch_error = 0.0)
        : delaunay_(surroundings, touch_error), roadmap_(surroundings) {}

    [[nodiscard]] MaintainedDelaunay& delaunay() { return delaunay_; }
    [[nodiscard]] const MaintainedDelaunay& delaunay() const { return delaunay_; }
    [[nodiscard]] Roadmap& roadmap() { return roadmap_; }
    [[nodiscard]] const Roadmap& roadmap() const { return roadmap_; }

    // As MaintainedDelaunay::insert; new Voronoi vertices on known ways become nodes.
    MaintainedDelaunay::Insertion insert(const Point& p, CellId near);

    // The node to start a probe of the edge from. REQUIRES: the edge is reachable, and `along` its span.
    NodeId start_of(DirectedEdge e, const EdgeSpan& along);
    // Where such a probe aims: the far end, exactly where the tool has been if it has.
    [[nodiscard]] Destination end_of(DirectedEdge e, const EdgeSpan& along) const;

    // A probe of the whole edge from `start`, a node as start_of() gives it, arrived at `end`, a node that end_of() leads to. Returns the
    // touch that this takes back, if S was only grazed there.
    std::optional<Crossing> learn_clear(DirectedEdge e, NodeId start, NodeId end);
    // S was touched on the edge at node `contact`, coming from node `from` of the edge: its start, or (not from_vertex) a point q within.
    // `touch` numbers the touch for the caller.
    void learn_contact(DirectedEdge e, NodeId from, NodeId contact, std::uint32_t touch, bool from_vertex = true);
    // The tool came along the edge's whole line from outside ω (node `entry`), past the edge's start, to `contact`.
    void learn_contact_from_outside(DirectedEdge e, const EdgeSpan& along, NodeId entry, NodeId contact, std::uint32_t touch);

    // As MaintainedDelaunay::is_valid, with the roadmap.
    [[nodiscard]] bool is_valid(std::string* why = nullptr) const;

private:
    MaintainedDelaunay delaunay_;
    Roadmap roadmap_;
};

}  // namespace palpate
