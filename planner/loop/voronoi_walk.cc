#include "planner/loop/voronoi_walk.h"

namespace palpate {

std::optional<DirectedEdge> VoronoiWalk::next() {
    while (!tasks_.empty()) {
        // The task stays until what it asks for is known: a wing may need several probes.
        if (const auto open = open_end(tasks_.back())) return open;
        tasks_.pop_back();
    }
    return std::nullopt;
}

std::optional<DirectedEdge> VoronoiWalk::open_end(const Task& task) {
    if (!state_.is_current(task.at)) return std::nullopt;
    const DirectedEdge e = task.at.edge;
    if (task.across != kWholeEdge) return walk(e, task.across);
    if (!state_.is_reachable(e) || state_.state(e) != EdgeState::unknown) return std::nullopt;
    return e;
}

std::optional<DirectedEdge> VoronoiWalk::walk(DirectedEdge e, int across) {
    // A crossing seen from within leaves its vertex unknown: there is nowhere to walk from.
    if (state_.recorded_state(e) != EdgeState::crossing || !state_.is_free(e.cell)) return std::nullopt;
    if (is_closed(e, across)) return std::nullopt;
    CellId cell = e.cell;
    int in = e.facet;
    int out = across;
    while (true) {
        const DirectedEdge ahead{cell, out};
        const EdgeState known = state_.state(ahead);
        if (known == EdgeState::unknown) return ahead;
        if (known == EdgeState::failed) return std::nullopt;
        // Past an edge that S crosses twice the walk goes on from its other end.
        const DirectedEdge back = state_.opposite(ahead);
        if (known == EdgeState::crossing && (back == e || !state_.is_double(ahead) || !state_.is_free(back.cell))) return std::nullopt;
        // The two vertices of the Delaunay edge keep their identity, their indices change from cell to cell.
        out = state_.next_facet_around(cell, in, out);
        in = back.facet;
        cell = back.cell;
    }
}

bool VoronoiWalk::is_closed(DirectedEdge e, int across) const {
    std::array<std::uint32_t, 2> ends{};  // of the Delaunay edge: samples, as it belongs to a facet of Ŝ
    std::size_t found = 0;
    for (int k = 0; k < 4; ++k) {
        if (k != e.facet && k != across) ends.at(found++) = *state_.sample_of(e.cell, k);
    }
    const auto [in_surface, doubled] = state_.count_facets_at(ends[0], ends[1], state_.ticket(e));
    // From an edge that S crosses twice, walks only find how far the wall goes.
    return state_.is_double(e) ? in_surface + doubled > 1 : in_surface == 2;
}

void VoronoiWalk::note_crossing(DirectedEdge e) {
    if (explore_ != Strategy::Explore::closure) return;
    for (int j = 0; j < 4; ++j) {
        if (j != e.facet) note_wing(e, j);
    }
}

void VoronoiWalk::note_free(CellId cell) {
    if (explore_ != Strategy::Explore::exhaustive) return;
    for (int i = 0; i < 4; ++i) note_edge({cell, i});
}

void VoronoiWalk::note_insertion(const MaintainedDelaunay::Insertion& insertion) {
    for (const DirectedEdge from_new : insertion.cropped) {
        if (explore_ == Strategy::Explore::exhaustive) {
            note_edge(state_.opposite(from_new));
            if (state_.is_free(from_new.cell)) note_free(from_new.cell);
        } else if (state_.recorded_state(from_new) == EdgeState::crossing) {
            note_crossing(from_new);  // the free side of an inherited crossing may be all new
        }
    }
    for (const auto& facet : insertion.lost) note_lost(facet);
    for (const DirectedEdge e : insertion.gained) note_crossing(e);
}

void VoronoiWalk::note_wings_beside(const std::array<std::uint32_t, 3>& lost) {
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = lost.at(k);
        const std::uint32_t b = lost.at((k + 1) % 3);
        state_.facets_around(a, b, {}, around_);
        for (const DirectedEdge facet : around_) {
            for (const DirectedEdge e : {facet, state_.opposite(facet)}) {
                if (state_.recorded_state(e) != EdgeState::crossing) continue;
                for (int j = 0; j < 4; ++j) {
                    const auto corner = state_.sample_of(e.cell, j);
                    if (j != e.facet && corner != a && corner != b) note_wing(e, j);
                }
            }
        }
    }
}

void VoronoiWalk::note_surroundings(std::uint32_t sample) {
    for (const CellId cell : state_.cells_around(sample)) {
        for (int i = 0; i < 4; ++i) {
            if (state_.sample_of(cell, i) != sample) note_edge({cell, i});
        }
    }
}

void VoronoiWalk::sweep() {
    for (CellId cell = 0; cell < state_.cell_slots(); ++cell) {
        if (!state_.is_live(cell)) continue;
        if (explore_ == Strategy::Explore::exhaustive) {
            if (state_.is_free(cell)) note_free(cell);
            continue;
        }
        for (int i = 0; i < 4; ++i) {
            if (state_.recorded_state({cell, i}) == EdgeState::crossing) note_crossing({cell, i});
        }
    }
}

}  // namespace palpate
