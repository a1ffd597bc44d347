// Which Voronoi edge to look at next (planner/DESIGN.md, "Strategy", option `explore`).
//
// A wing is an edge of a facet of Ŝ as seen from the facet's free side: (cell u, i, j), where facet i of u is in Ŝ and
// the Delaunay edge is the one that facets i and j of u share. Walking from u around that edge, away from facet i,
// stays in free space until the next crossing; there the next facet of Ŝ begins, and the wing is closed. It is closed as well, and
// needs no walk, as soon as a second facet of Ŝ is known at the Delaunay edge: what has to be shown is that Ŝ is a closed
// manifold with small balls, wherever else the dual edges run (planner/DESIGN.md, "Guarantees").
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "planner/delaunay/maintained_delaunay.h"
#include "planner/options.h"

namespace palpate {

class VoronoiWalk {
public:
    VoronoiWalk(MaintainedDelaunay& state, Strategy::Explore explore) : state_(state), explore_(explore) {}

    // The next edge that a probe must answer: reachable and unknown. Nothing when all that was noted is known. Last
    // noted comes first: the tool is near it.
    [[nodiscard]] std::optional<DirectedEdge> next();

    // What may have opened new work.
    void note_crossing(DirectedEdge e);
    void note_free(CellId cell);
    // The facet left Ŝ: what ended there goes on.
    void note_lost(const std::array<std::uint32_t, 3>& facet) {
        if (explore_ == Strategy::Explore::closure) note_wings_beside(facet);
    }
    void note_insertion(const MaintainedDelaunay::Insertion& insertion);

    // Notes everything afresh. Linear time.
    void sweep();
    // Notes all edges of a sample's Voronoi cell, whatever the strategy.
    void note_surroundings(std::uint32_t sample);

    // Tasks noted; some may be closed or gone already.
    [[nodiscard]] std::size_t open_count() const { return tasks_.size(); }

private:
    struct Task {
        EdgeTicket at;
        int across = kWholeEdge;  // of a wing: the index j
    };
    static constexpr int kWholeEdge = -1;  // the task is the edge itself, not a wing

    void note_edge(DirectedEdge e) { tasks_.push_back({state_.ticket(e), kWholeEdge}); }
    // The wings of what is left of Ŝ at a facet that left it.
    void note_wings_beside(const std::array<std::uint32_t, 3>& lost);
    void note_wing(DirectedEdge e, int across) { tasks_.push_back({state_.ticket(e), across}); }
    [[nodiscard]] bool is_closed(DirectedEdge e, int across) const;
    // The first unknown edge on the walk from a wing; nothing if it is closed.
    [[nodiscard]] std::optional<DirectedEdge> walk(DirectedEdge e, int across);
    [[nodiscard]] std::optional<DirectedEdge> open_end(const Task& task);

    MaintainedDelaunay& state_;
    const Strategy::Explore explore_;
    std::vector<Task> tasks_;
    std::vector<DirectedEdge> around_;  // scratch
};

}  // namespace palpate
