// Del(E) with what is known of every cell and directed Voronoi edge, kept through insertions (planner/DESIGN.md, "State" and "Insertion").
//
// May not live here: how that came to be known. Voronoi vertices and crossings have anchors, which whoever moves a tool puts there.
#pragma once

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planner/delaunay/dual_line.h"
#include "planner/delaunay/edge_record.h"
#include "planner/surroundings.h"

namespace palpate {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;  // index of the sample
using CellBase = CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

using CellId = std::uint32_t;
using CrossingId = std::uint32_t;
inline constexpr CrossingId kNoCrossing = ~CrossingId{0};

// The Voronoi edge that leaves the Voronoi vertex of `cell` through its facet opposite to vertex `facet`.
struct DirectedEdge {
    CellId cell = 0;
    int facet = 0;

    friend bool operator==(const DirectedEdge&, const DirectedEdge&) = default;
};

// A facet by its samples, whichever side it is seen from.
[[nodiscard]] inline std::array<std::uint32_t, 3> in_order(std::array<std::uint32_t, 3> facet) {
    std::sort(facet.begin(), facet.end());
    return facet;
}

// The same edge for as long as its cell lives: CellIds are used again, generations are not.
struct EdgeTicket {
    DirectedEdge edge;
    std::uint32_t generation = 0;
};

// Where a directed edge runs inside ω.
struct EdgeSpan {
    DualLine line;       // of the facet; `line.direction` may point either way along the edge
    double start = 0.0;  // parameters on the line: at the cell's Voronoi vertex, or where the edge enters ω
    double end = 0.0;    // at the neighbour's Voronoi vertex, or where the edge leaves ω
    bool starts_on_boundary = false;
    bool ends_on_boundary = false;

    [[nodiscard]] Point start_point() const { return line.at(start); }
    [[nodiscard]] Point end_point() const { return line.at(end); }
};

class MaintainedDelaunay {
public:
    // Points nearer than this fraction of ω's radius are the same place: far above the rounding of dual edges.
    static constexpr double kSamePlace = 1e-9;

    // `touch_error` (mm): touches and ways may be off by that.
    explicit MaintainedDelaunay(const Surroundings& surroundings, double touch_error = 0.0)
        : surroundings_(surroundings), touch_error_(touch_error) {}
    MaintainedDelaunay(const MaintainedDelaunay&) = delete;
    MaintainedDelaunay& operator=(const MaintainedDelaunay&) = delete;

    // --- building ---------------------------------------------------------------------------------------------------
    // REQUIRES: called once, before all else; at least four points that are not coplanar. Nothing is known of any edge.
    void initialise(std::span<const Point> samples);

    // A new Voronoi vertex on a straight way that was known to be free.
    struct Split {
        DirectedEdge from_new;  // from that vertex towards the survivor
        Anchor before = kNoAnchor;
        Anchor beyond = kNoAnchor;
        Point vertex = Point::Zero();
    };
    // What an insertion changed. Valid until the next insertion.
    struct Insertion {
        std::uint32_t sample = 0;
        // The edges that the new Voronoi cell cropped, from the new vertex towards the survivor. Every new cell has one.
        std::span<const DirectedEdge> cropped;
        // The facets that left Ŝ: destroyed, or their dual edge lost its crossing.
        std::span<const std::array<std::uint32_t, 3>> lost;
        // The dual edges of facets that came into Ŝ, as one of two crossings was cropped off: the direction that holds the other.
        std::span<const DirectedEdge> gained;
        // The new Voronoi vertices that lie on known ways. Each wants an anchor: see place().
        std::span<const Split> splits;
    };
    // Inserts a sample; records of cells that survive stay, records of edges that the new Voronoi cell crops are
    // inherited. Throws std::logic_error if the sample is already there. `near` is a cell to start the search from.
    Insertion insert(const Point& p, CellId near);

    // --- triangulation ----------------------------------------------------------------------------------------------
    [[nodiscard]] std::size_t sample_count() const { return delaunay_.number_of_vertices(); }
    [[nodiscard]] const Point& sample(std::uint32_t index) const { return samples_[index]; }
    [[nodiscard]] std::span<const Point> samples() const { return samples_; }
    // Whether the sample lies on a known solid: nobody touched it. Whether all of these do.
    [[nodiscard]] bool is_known(std::uint32_t index) const { return surroundings_.known_normal(samples_[index]).has_value(); }
    [[nodiscard]] bool are_known(std::span<const std::uint32_t> indices) const {
        return std::all_of(indices.begin(), indices.end(), [&](std::uint32_t index) { return is_known(index); });
    }
    [[nodiscard]] std::size_t cell_slots() const { return cells_.size(); }
    [[nodiscard]] bool is_live(CellId cell) const { return cells_[cell].live; }
    // visit(DirectedEdge) for all of them, by cell and facet. It may change what is known, but insert nothing.
    template <typename Visit>
    void for_each_edge(const Visit& visit) const {
        for (CellId cell = 0; cell < cell_slots(); ++cell) {
            if (!is_live(cell)) continue;
            for (int i = 0; i < 4; ++i) visit(DirectedEdge{cell, i});
        }
    }
    // The sample at a vertex of a cell; nothing for the vertex at infinity.
    [[nodiscard]] std::optional<std::uint32_t> sample_of(CellId cell, int vertex) const;
    [[nodiscard]] CellId neighbor(DirectedEdge e) const { return handle(e.cell)->neighbor(e.facet)->info(); }
    // The same edge from its other end.
    [[nodiscard]] DirectedEdge opposite(DirectedEdge e) const;
    // Whether the facet is a triangle of samples, and the edge not at infinity.
    [[nodiscard]] bool is_finite(DirectedEdge e) const;
    // The facet's vertices, counter-clockwise seen from the cell's side; its edge is not at infinity.
    [[nodiscard]] std::array<std::uint32_t, 3> facet_samples(DirectedEdge e) const;
    // The sample's cell to search from.
    [[nodiscard]] CellId cell_at(std::uint32_t sample) const;
    // `near` is a cell to start the search from.
    [[nodiscard]] std::uint32_t nearest_sample(const Point& p, CellId near) const;
    [[nodiscard]] std::vector<CellId> cells_around(std::uint32_t sample) const;
    // The samples that a Delaunay edge joins to one.
    void adjacent_samples(std::uint32_t sample, std::vector<std::uint32_t>& out) const;
    // Nearest to p first; among equals the older.
    void sort_by_distance(const Point& p, std::vector<std::uint32_t>& samples) const;
    // The facets around a Delaunay edge, in turn, each from one side; none if a and b are not joined. Facets at infinity
    // are left out. `hint` may be a facet that had both; if it still is, nothing is searched.
    void facets_around(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint, std::vector<DirectedEdge>& out) const;
    // Leaving `cell` through facet `out` around the Delaunay edge that facets `in` and `out` share: the facet of the next
    // cell by which that walk goes on.
    [[nodiscard]] int next_facet_around(CellId cell, int in, int out) const;
    // The facet that holds the triangle, seen from either side, if it is in the triangulation.
    [[nodiscard]] std::optional<DirectedEdge> find_facet(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;

    // --- knowledge --------------------------------------------------------------------------------------------------
    // Of cells: proven free, and whether the Voronoi vertex lies outside ω (then it is free).
    [[nodiscard]] bool is_free(CellId cell) const { return cells_[cell].free; }
    [[nodiscard]] bool is_outside(CellId cell) const { return cells_[cell].outside; }
    // Of the Voronoi vertex. REQUIRES: free and inside ω.
    [[nodiscard]] Anchor anchor(CellId cell) const { return cells_[cell].anchor; }

    // The edge inside ω; nothing where the whole edge lies outside (or at infinity).
    [[nodiscard]] std::optional<EdgeSpan> span(DirectedEdge e) const;
    // Learns at once that an edge outside ω is clear.
    [[nodiscard]] EdgeState state(DirectedEdge e);
    [[nodiscard]] EdgeState recorded_state(DirectedEdge e) const { return record(e).state; }
    [[nodiscard]] const Crossing& crossing(DirectedEdge e) const { return crossings_[record(e).crossing]; }
    // The direction in which the edge holds a crossing, if its facet is in Ŝ; the given one if both do.
    [[nodiscard]] std::optional<DirectedEdge> crossed(DirectedEdge e) const {
        if (recorded_state(e) == EdgeState::crossing) return e;
        const DirectedEdge back = opposite(e);
        if (recorded_state(back) == EdgeState::crossing) return back;
        return std::nullopt;
    }
    // The same, if that crossing is inferred.
    [[nodiscard]] std::optional<DirectedEdge> inferred(DirectedEdge e) const {
        const std::optional<DirectedEdge> known = crossed(e);
        return known && crossing(*known).inferred ? known : std::nullopt;
    }
    // Whether S was met from both ends of the edge, at two places: it crosses the edge twice, and the facet is not in Ŝ.
    [[nodiscard]] bool is_double(DirectedEdge e) const;
    // How far apart those places are, mm. REQUIRES: is_double(e).
    [[nodiscard]] double thickness(DirectedEdge e) const { return (crossing(e).near - crossing(opposite(e)).near).norm(); }
    // Whether some facet at the sample has a dual edge that S crosses twice.
    [[nodiscard]] bool is_thin_at(std::uint32_t sample) const;
    [[nodiscard]] bool in_surface(DirectedEdge e) const { return crossed(e) && !is_double(e); }
    // How many facets at a Delaunay edge are in Ŝ, and at how many S crosses the dual edge twice; `hint` as for facets_around.
    struct FacetCount {
        int in_surface = 0;
        int doubled = 0;
    };
    [[nodiscard]] FacetCount count_facets_at(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint) const;
    [[nodiscard]] CrossingId crossing_id(DirectedEdge e) const { return record(e).crossing; }
    // Where a crossing is now; nothing once it has left all edges.
    [[nodiscard]] std::optional<DirectedEdge> edge_of(CrossingId id, std::uint32_t generation) const;
    [[nodiscard]] std::uint32_t generation_of(CrossingId id) const { return crossing_generations_[id]; }

    // A probe can start at the edge's beginning: its vertex is free, or it enters ω from outside.
    [[nodiscard]] bool is_reachable(DirectedEdge e) const { return cells_[e.cell].free; }

    [[nodiscard]] EdgeTicket ticket(DirectedEdge e) const { return {e, cells_[e.cell].generation}; }
    [[nodiscard]] bool is_current(const EdgeTicket& t) const {
        return cells_[t.edge.cell].live && cells_[t.edge.cell].generation == t.generation;
    }

    // --- learning ---------------------------------------------------------------------------------------------------
    // The Voronoi vertex was reached.
    void free(CellId cell, Anchor anchor) {
        cells_[cell].free = true;
        cells_[cell].anchor = anchor;
    }
    // Where the vertex of a split, and all that is seen from it, is anchored: exactly there.
    void place(const Split& split, Anchor anchor, const Point& at);
    // The edge was passed from there. Takes back, and returns, the touch from its other end, which S then only grazes: the later answer
    // holds. Not so an exact touch at the start itself, where S passes through.
    std::optional<Crossing> take_back_graze(DirectedEdge e, const Point& start);
    // The whole edge turned out free, between those anchors; its far end is free.
    void learn_clear(DirectedEdge e, Anchor start, Anchor end);
    // A probe of the edge had no answer, or one that nothing can be made of.
    void note_failed(DirectedEdge e) {
        drop_crossing(record(e));
        record(e).state = EdgeState::failed;
    }
    // S was touched on the edge. `seen` says where, from where, and which touch it was; the rest follows.
    void learn_contact(DirectedEdge e, const Crossing& seen);
    // S must cross the edge between `near`, which is free, and `far`, inside O, both on the edge: inferred, so nothing was
    // traversed. REQUIRES: no crossing is known.
    void learn_inferred(DirectedEdge e, const Point& near, const Point& far);
    // What was inferred, or touched by an earlier run, does not hold. REQUIRES: e holds a crossing that no tool of this run was at.
    void withdraw(DirectedEdge e);
    // Touches that a later answer took back.
    [[nodiscard]] std::uint64_t grazes() const { return grazes_; }
    [[nodiscard]] const Surroundings& surroundings() const { return surroundings_; }

    // Checks the structure and every record against the others and the geometry; `why` gets the first thing wrong.
    // `place_of` tells where an anchor is; empty: anchors are not looked at. For tests: linear time, with exact predicates.
    [[nodiscard]] bool is_valid(std::string* why = nullptr, const std::function<Point(Anchor)>& place_of = {}) const;

private:
    struct EdgeRecord {
        EdgeState state = EdgeState::unknown;
        CrossingId crossing = kNoCrossing;
        // Where the proven-free part of the edge begins on this side: at the vertex, or where the edge enters ω. Only
        // with state clear inside ω; a crossing has its own.
        Anchor anchor = kNoAnchor;
    };
    struct Cell {
        Delaunay::Cell_handle handle;
        std::array<EdgeRecord, 4> edges;
        Anchor anchor = kNoAnchor;
        std::uint32_t generation = 0;
        bool live = false;
        bool free = false;
        bool outside = false;
    };
    // A boundary facet of the conflict hole, from the surviving side, with the record that dies on the other side.
    struct HoleFacet {
        Delaunay::Cell_handle survivor;
        int facet = 0;
        EdgeRecord dying;
    };

    // visit(DirectedEdge) for every facet around a Delaunay edge, in turn.
    template <typename Visit>
    void visit_facets_around(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint, const Visit& visit) const;
    [[nodiscard]] Delaunay::Cell_handle handle(CellId cell) const { return cells_[cell].handle; }
    [[nodiscard]] EdgeRecord& record(DirectedEdge e) { return cells_[e.cell].edges[static_cast<std::size_t>(e.facet)]; }
    [[nodiscard]] const EdgeRecord& record(DirectedEdge e) const { return cells_[e.cell].edges[static_cast<std::size_t>(e.facet)]; }
    [[nodiscard]] const Point& point(Delaunay::Vertex_handle v) const { return samples_[v->info()]; }
    CellId register_cell(Delaunay::Cell_handle cell);
    [[nodiscard]] bool lies_outside(Delaunay::Cell_handle cell) const;
    [[nodiscard]] std::array<Delaunay::Vertex_handle, 3> sorted_facet(DirectedEdge e) const;
    CrossingId new_crossing(const Crossing& crossing, DirectedEdge e);
    void drop_crossing(EdgeRecord& r);
    void forget_stars(Delaunay::Cell_handle dying);
    void inherit(const HoleFacet& facet, const Point& p);
    // Two crossings seen from an edge's two ends are one if S passes through an end.
    [[nodiscard]] bool are_two(const Crossing& x, const Crossing& y) const {
        return (x.near - y.near).norm() > kSamePlace * surroundings_.region().radius() + 2 * touch_error_;
    }

    const Surroundings surroundings_;
    const double touch_error_;
    std::uint64_t grazes_ = 0;
    Delaunay delaunay_;
    std::vector<Point> samples_;
    std::vector<Delaunay::Vertex_handle> vertices_;
    std::vector<Cell> cells_;
    std::vector<CellId> free_slots_;
    std::vector<Crossing> crossings_;
    std::vector<DirectedEdge> crossing_edges_;  // parallel to crossings_
    std::vector<std::uint32_t> crossing_generations_;
    std::vector<CrossingId> free_crossings_;
    // Scratch of insert().
    std::vector<Delaunay::Cell_handle> conflict_;
    std::vector<Delaunay::Facet> hole_;
    std::vector<HoleFacet> hole_facets_;
    std::vector<DirectedEdge> cropped_;
    std::vector<std::array<std::uint32_t, 3>> lost_;
    std::vector<DirectedEdge> gained_;
    std::vector<Split> splits_;
    // What adjacent_samples() has found since the sample's star changed last; empty: to be found. Searches ask for the same ones again and
    // again.
    mutable std::vector<std::vector<std::uint32_t>> stars_;
    mutable std::vector<Delaunay::Vertex_handle> adjacent_;  // its scratch
};

}  // namespace palpate
