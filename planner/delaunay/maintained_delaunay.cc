#include "planner/delaunay/maintained_delaunay.h"

#include <algorithm>
#include <cassert>
#include <stdexcept>

namespace palpate {
namespace {

Kernel::Point_3 to_cgal(const Point& p) { return {p.x(), p.y(), p.z()}; }

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// +1 if the permutation that sends (0, 1, 2, 3) to the given order is even, -1 if it is odd.
int parity(std::array<int, 4> order) {
    int sign = 1;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = i + 1; j < 4; ++j) {
            if (order[i] > order[j]) sign = -sign;
        }
    }
    return sign;
}

}  // namespace

// --- building --------------------------------------------------------------------------------------------------------

void MaintainedDelaunay::initialise(std::span<const Point> samples) {
    assert(samples_.empty());
    for (const Point& p : samples) {
        const std::size_t before = delaunay_.number_of_vertices();
        const Delaunay::Vertex_handle v = delaunay_.insert(to_cgal(p));
        if (delaunay_.number_of_vertices() == before) throw std::logic_error("MaintainedDelaunay: a sample is given twice");
        v->info() = static_cast<std::uint32_t>(samples_.size());
        samples_.push_back(p);
        vertices_.push_back(v);
    }
    if (delaunay_.dimension() < 3) throw std::logic_error("MaintainedDelaunay: the first samples are coplanar");
    for (auto cell = delaunay_.all_cells_begin(); cell != delaunay_.all_cells_end(); ++cell) register_cell(cell);
}

CellId MaintainedDelaunay::register_cell(Delaunay::Cell_handle cell) {
    CellId id = 0;
    if (free_slots_.empty()) {
        id = static_cast<CellId>(cells_.size());
        cells_.emplace_back();
    } else {
        id = free_slots_.back();
        free_slots_.pop_back();
    }
    Cell& slot = cells_[id];
    slot.handle = cell;
    slot.edges = {};
    slot.anchor = kNoAnchor;
    slot.live = true;
    slot.outside = lies_outside(cell);
    slot.free = slot.outside;
    cell->info() = id;
    return id;
}

bool MaintainedDelaunay::lies_outside(Delaunay::Cell_handle cell) const {
    if (delaunay_.is_infinite(cell)) return true;
    const Point& a = point(cell->vertex(0));
    const double limit = (a - surroundings_.region().center()).norm() + surroundings_.region().radius();
    return surroundings_.is_free(circumcentre(a, point(cell->vertex(1)), point(cell->vertex(2)), point(cell->vertex(3)), limit));
}

MaintainedDelaunay::Insertion MaintainedDelaunay::insert(const Point& p, CellId near) {
    const Kernel::Point_3 query = to_cgal(p);
    Delaunay::Locate_type type{};
    int i = 0;
    int j = 0;
    const Delaunay::Cell_handle start = delaunay_.locate(query, type, i, j, handle(near));
    if (type == Delaunay::VERTEX) throw std::logic_error("MaintainedDelaunay: a sample is inserted twice");
    conflict_.clear();
    hole_.clear();
    delaunay_.find_conflicts(query, start, std::back_inserter(hole_), std::back_inserter(conflict_));

    hole_facets_.clear();
    for (const auto& [cell, facet] : hole_) {
        EdgeRecord& dying = record({cell->info(), facet});
        const Delaunay::Cell_handle survivor = cell->neighbor(facet);
        hole_facets_.push_back({survivor, survivor->index(cell), dying});
        dying = {};  // its crossing, if any, goes on with the hole facet
    }
    lost_.clear();
    gained_.clear();
    splits_.clear();
    for (const Delaunay::Cell_handle cell : conflict_) {
        for (int k = 0; k < 4; ++k) {
            const DirectedEdge e{cell->info(), k};
            if (recorded_state(e) != EdgeState::crossing || is_double(e)) continue;
            const DirectedEdge back = opposite(e);  // of a cell that dies as well
            if (recorded_state(back) != EdgeState::crossing || e.cell < back.cell) lost_.push_back(facet_samples(e));
        }
    }
    for (const Delaunay::Cell_handle cell : conflict_) {
        forget_stars(cell);
        Cell& slot = cells_[cell->info()];
        for (EdgeRecord& r : slot.edges) drop_crossing(r);
        slot.live = false;
        ++slot.generation;
        free_slots_.push_back(cell->info());
    }

    const Delaunay::Vertex_handle v =
        delaunay_.insert_in_hole(query, conflict_.begin(), conflict_.end(), hole_.front().first, hole_.front().second);
    const auto index = static_cast<std::uint32_t>(samples_.size());
    v->info() = index;
    samples_.push_back(p);
    vertices_.push_back(v);

    cropped_.clear();
    for (const HoleFacet& facet : hole_facets_) {
        const Delaunay::Cell_handle fresh = facet.survivor->neighbor(facet.facet);
        cropped_.push_back({register_cell(fresh), fresh->index(v)});
    }
    for (const HoleFacet& facet : hole_facets_) {
        const DirectedEdge from_survivor{facet.survivor->info(), facet.facet};
        const EdgeRecord& known = record(from_survivor);
        const bool was_dying = facet.dying.state == EdgeState::crossing;
        const bool was_known = known.state == EdgeState::crossing;
        const bool was_double = was_dying && was_known && are_two(crossings_[facet.dying.crossing], crossings_[known.crossing]);
        inherit(facet, p);
        const auto still = crossed(from_survivor);
        if ((was_dying || was_known) && !was_double && !still) lost_.push_back(facet_samples(from_survivor));
        if (was_double && still && !is_double(*still)) gained_.push_back(*still);
    }
    return {index, cropped_, lost_, gained_, splits_};
}

// planner/DESIGN.md, "Insertion". The old edge ran from u (the survivor) to w (destroyed); it now ends at v, the vertex of the new cell.
void MaintainedDelaunay::inherit(const HoleFacet& hole_facet, const Point& p) {
    const DirectedEdge from_u{hole_facet.survivor->info(), hole_facet.facet};
    const DirectedEdge from_v = opposite(from_u);
    EdgeRecord dying = hole_facet.dying;
    EdgeRecord& u_record = record(from_u);
    const auto is_blank = [](const EdgeRecord& r) { return r.state == EdgeState::unknown || r.state == EdgeState::failed; };
    if (is_blank(u_record) && is_blank(dying)) {
        u_record = {};
        return;
    }
    const std::optional<EdgeSpan> remains = span(from_u);
    if (!remains) {  // what is left of the edge is outside ω
        drop_crossing(u_record);
        drop_crossing(dying);
        u_record.state = record(from_v).state = EdgeState::clear;
        return;
    }
    if (u_record.state == EdgeState::clear && u_record.anchor == kNoAnchor) {  // was outside, grazes ω now, by rounding
        u_record = {};
        return;
    }

    const Point& a = samples_[facet_samples(from_u)[0]];
    const auto in_new_cell = [&](const Point& x) { return (x - p).squaredNorm() < (x - a).squaredNorm(); };
    const Crossing* const u_crossing = u_record.state == EdgeState::crossing ? &crossings_[u_record.crossing] : nullptr;
    const Crossing* const w_crossing = dying.state == EdgeState::crossing ? &crossings_[dying.crossing] : nullptr;
    const CroppedEdge cropped = crop_edge(u_record.state, u_crossing, dying.state, w_crossing, in_new_cell);

    Cell& v_cell = cells_[from_v.cell];
    EdgeRecord& v_record = record(from_v);
    // The straight way that is known to be free past v: its two ends.
    Anchor before = kNoAnchor;
    Anchor beyond = kNoAnchor;
    if (u_record.state == EdgeState::clear) {
        before = u_record.anchor;
        beyond = dying.anchor;
    } else if (cropped.frees_v) {
        const Crossing& traversed = cropped.on_segment_of_u ? *u_crossing : *w_crossing;
        before = traversed.from_anchor;
        beyond = traversed.near_anchor;
    }
    // Where v is outside ω, the way went on to the boundary or came in from it: its end there stays.
    const bool is_split = !v_cell.outside && cropped.frees_v && (before == kNoAnchor) == (beyond == kNoAnchor);
    if (is_split) {
        v_cell.free = true;
        splits_.push_back({from_v, before, beyond, remains->end_point()});
    }

    if (cropped.from_v == EdgeState::crossing) {
        v_record = dying;
        Crossing& crossing = crossings_[v_record.crossing];
        crossing_edges_[v_record.crossing] = from_v;
        if (cropped.from_v_becomes_vertex) {
            crossing.from_vertex = true;
            if (!v_cell.outside) crossing.from = remains->end_point();
        }
        dying = {};
    } else if (cropped.from_v == EdgeState::clear) {
        v_record = {EdgeState::clear, kNoCrossing, v_cell.outside ? beyond : kNoAnchor};
    }
    if (cropped.from_u != EdgeState::crossing) drop_crossing(u_record);
    if (cropped.from_u == EdgeState::clear) u_record = {EdgeState::clear, kNoCrossing, before};
    drop_crossing(dying);
}

// --- triangulation ---------------------------------------------------------------------------------------------------

std::optional<std::uint32_t> MaintainedDelaunay::sample_of(CellId cell, int vertex) const {
    const Delaunay::Vertex_handle v = handle(cell)->vertex(vertex);
    if (delaunay_.is_infinite(v)) return std::nullopt;
    return v->info();
}

DirectedEdge MaintainedDelaunay::opposite(DirectedEdge e) const {
    const Delaunay::Cell_handle cell = handle(e.cell);
    const Delaunay::Cell_handle other = cell->neighbor(e.facet);
    return {other->info(), other->index(cell)};
}

bool MaintainedDelaunay::is_finite(DirectedEdge e) const { return !delaunay_.is_infinite(handle(e.cell), e.facet); }

std::array<Delaunay::Vertex_handle, 3> MaintainedDelaunay::sorted_facet(DirectedEdge e) const {
    const Delaunay::Cell_handle cell = handle(e.cell);
    std::array<Delaunay::Vertex_handle, 3> facet;
    for (std::size_t k = 0; k < 3; ++k) facet[k] = cell->vertex((e.facet + 1 + static_cast<int>(k)) & 3);
    if (facet[0]->info() > facet[1]->info()) std::swap(facet[0], facet[1]);
    if (facet[1]->info() > facet[2]->info()) std::swap(facet[1], facet[2]);
    if (facet[0]->info() > facet[1]->info()) std::swap(facet[0], facet[1]);
    return facet;
}

std::array<std::uint32_t, 3> MaintainedDelaunay::facet_samples(DirectedEdge e) const {
    const auto facet = sorted_facet(e);
    const Delaunay::Cell_handle cell = handle(e.cell);
    const bool counter_clockwise = parity({cell->index(facet[0]), cell->index(facet[1]), cell->index(facet[2]), e.facet}) > 0;
    return {facet[0]->info(), facet[counter_clockwise ? 1 : 2]->info(), facet[counter_clockwise ? 2 : 1]->info()};
}

std::uint32_t MaintainedDelaunay::nearest_sample(const Point& p, CellId near) const {
    return delaunay_.nearest_vertex(to_cgal(p), handle(near))->info();
}

CellId MaintainedDelaunay::cell_at(std::uint32_t sample) const { return vertices_[sample]->cell()->info(); }

std::vector<CellId> MaintainedDelaunay::cells_around(std::uint32_t sample) const {
    std::vector<Delaunay::Cell_handle> handles;
    delaunay_.incident_cells(vertices_[sample], std::back_inserter(handles));
    std::vector<CellId> cells;
    cells.reserve(handles.size());
    for (const Delaunay::Cell_handle cell : handles) cells.push_back(cell->info());
    return cells;
}

void MaintainedDelaunay::adjacent_samples(std::uint32_t sample, std::vector<std::uint32_t>& out) const {
    if (stars_.size() <= sample) stars_.resize(samples_.size());
    std::vector<std::uint32_t>& star = stars_[sample];
    if (star.empty()) {
        adjacent_.clear();
        delaunay_.finite_adjacent_vertices(vertices_[sample], std::back_inserter(adjacent_));
        star.reserve(adjacent_.size());
        for (const Delaunay::Vertex_handle v : adjacent_) star.push_back(v->info());
    }
    out.assign(star.begin(), star.end());
}

void MaintainedDelaunay::forget_stars(Delaunay::Cell_handle cell) {
    for (int k = 0; k < 4; ++k) {
        const Delaunay::Vertex_handle v = cell->vertex(k);
        if (!delaunay_.is_infinite(v) && v->info() < stars_.size()) stars_[v->info()].clear();
    }
}

void MaintainedDelaunay::sort_by_distance(const Point& p, std::vector<std::uint32_t>& samples) const {
    std::sort(samples.begin(), samples.end(), [&](std::uint32_t b, std::uint32_t c) {
        const double db = (sample(b) - p).squaredNorm();
        const double dc = (sample(c) - p).squaredNorm();
        return db != dc ? db < dc : b < c;
    });
}

template <typename Visit>
void MaintainedDelaunay::visit_facets_around(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint, const Visit& visit) const {
    Delaunay::Cell_handle cell;
    int i = 0;
    int j = 0;
    if (hint.edge.cell < cells_.size() && is_current(hint)) cell = handle(hint.edge.cell);
    const bool found = cell != Delaunay::Cell_handle() && cell->has_vertex(vertices_[a], i) && cell->has_vertex(vertices_[b], j);
    if (!found && !delaunay_.is_edge(vertices_[a], vertices_[b], cell, i, j)) return;
    // Of the cell's two other vertices, the walk leaves through the facet opposite to the first, which holds the second.
    int out_of = 0;
    while (out_of == i || out_of == j) ++out_of;
    int through = 6 - i - j - out_of;
    const Delaunay::Cell_handle first = cell;
    do {
        const Delaunay::Vertex_handle third = cell->vertex(through);
        if (!delaunay_.is_infinite(third)) visit(DirectedEdge{cell->info(), out_of});
        const Delaunay::Cell_handle next = cell->neighbor(out_of);
        through = next->index(cell);
        out_of = next->index(third);
        cell = next;
    } while (cell != first);
}

void MaintainedDelaunay::facets_around(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint, std::vector<DirectedEdge>& out) const {
    out.clear();
    visit_facets_around(a, b, hint, [&](DirectedEdge e) { out.push_back(e); });
}

bool MaintainedDelaunay::is_double(DirectedEdge e) const {
    if (recorded_state(e) != EdgeState::crossing) return false;
    const DirectedEdge back = opposite(e);
    if (recorded_state(back) != EdgeState::crossing) return false;
    return are_two(crossing(e), crossing(back));
}

bool MaintainedDelaunay::is_thin_at(std::uint32_t sample) const {
    for (const CellId cell : cells_around(sample)) {
        for (int i = 0; i < 4; ++i) {
            if (sample_of(cell, i) != sample && is_double({cell, i})) return true;
        }
    }
    return false;
}

MaintainedDelaunay::FacetCount MaintainedDelaunay::count_facets_at(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint) const {
    FacetCount count;
    visit_facets_around(a, b, hint, [&](DirectedEdge e) {
        if (const auto known = crossed(e)) ++(is_double(*known) ? count.doubled : count.in_surface);
    });
    return count;
}

int MaintainedDelaunay::next_facet_around(CellId cell, int in, int out) const {
    // The next cell shares the facet opposite to `out`, with the Delaunay edge and the vertex `in`; the facet opposite to
    // that vertex holds the edge too and is not the one by which we come.
    const Delaunay::Cell_handle from = handle(cell);
    return from->neighbor(out)->index(from->vertex(in));
}

std::optional<DirectedEdge> MaintainedDelaunay::find_facet(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    Delaunay::Cell_handle cell;
    int i = 0;
    int j = 0;
    int k = 0;
    if (!delaunay_.is_facet(vertices_[a], vertices_[b], vertices_[c], cell, i, j, k)) return std::nullopt;
    return DirectedEdge{cell->info(), 6 - i - j - k};
}

std::optional<EdgeSpan> MaintainedDelaunay::span(DirectedEdge e) const {
    const Delaunay::Cell_handle u = handle(e.cell);
    const Delaunay::Cell_handle w = u->neighbor(e.facet);
    const Cell& from = cells_[e.cell];
    const Cell& to = cells_[w->info()];
    const auto facet = sorted_facet(e);
    for (const auto& v : facet) {
        if (delaunay_.is_infinite(v)) return std::nullopt;
    }
    const Point& a = point(facet[0]);
    const Point& b = point(facet[1]);
    const Point& c = point(facet[2]);
    EdgeSpan result;
    result.line = dual_line(a, b, c);
    const std::optional<Interval> inside = surroundings_.unknown_part(result.line.origin, result.line.direction);
    if (from.outside && to.outside && !inside) return std::nullopt;

    // u's fourth vertex lies on u's side of the facet; the edge runs away from it. The sign is exact: it is the
    // orientation of the cell, which the triangulation guarantees.
    const int sign = -parity({u->index(facet[0]), u->index(facet[1]), u->index(facet[2]), e.facet});
    const int side_of_u = -sign;
    const double limit = inside ? std::max(std::abs(inside->low), std::abs(inside->high)) : kInfinity;
    const auto vertex_parameter = [&](Delaunay::Cell_handle cell, int opposite_vertex, int side) {
        return circumcentre_parameter(result.line, a, b, c, point(cell->vertex(opposite_vertex)), side, limit);
    };
    double at_u = delaunay_.is_infinite(u) ? -sign * kInfinity : vertex_parameter(u, e.facet, side_of_u);
    double at_w = delaunay_.is_infinite(w) ? sign * kInfinity : vertex_parameter(w, w->index(u), -side_of_u);
    if (!inside) {  // an end is inside, by rounding only: the line grazes ω there
        const double at = from.outside ? at_w : at_u;
        result.start = result.end = at;
        result.starts_on_boundary = from.outside;
        result.ends_on_boundary = to.outside;
        return result;
    }
    const double entry = sign > 0 ? inside->low : inside->high;
    const double leave = sign > 0 ? inside->high : inside->low;
    if (from.outside && to.outside) {
        const double middle = (inside->low + inside->high) / 2;
        if (sign * (middle - at_u) <= 0 || sign * (at_w - middle) <= 0) return std::nullopt;
    }
    if (from.outside) at_u = entry;
    if (to.outside) at_w = leave;
    result.start = std::clamp(at_u, inside->low, inside->high);
    result.end = std::clamp(at_w, inside->low, inside->high);
    if (sign * (result.end - result.start) < 0) result.end = result.start;  // by rounding: an edge of no length
    result.starts_on_boundary = from.outside;
    result.ends_on_boundary = to.outside;
    return result;
}

// --- knowledge -------------------------------------------------------------------------------------------------------

EdgeState MaintainedDelaunay::state(DirectedEdge e) {
    EdgeRecord& known = record(e);
    if (known.state == EdgeState::unknown && is_outside(e.cell) && is_outside(neighbor(e)) && !span(e)) {
        known.state = record(opposite(e)).state = EdgeState::clear;
    }
    return known.state;
}

std::optional<DirectedEdge> MaintainedDelaunay::edge_of(CrossingId id, std::uint32_t generation) const {
    if (crossing_generations_[id] != generation) return std::nullopt;
    return crossing_edges_[id];
}

// --- learning --------------------------------------------------------------------------------------------------------

void MaintainedDelaunay::place(const Split& split, Anchor anchor, const Point& at) {
    cells_[split.from_new.cell].anchor = anchor;
    EdgeRecord& seen = record(split.from_new);
    if (seen.state == EdgeState::clear) seen.anchor = anchor;
    if (seen.state != EdgeState::crossing || !crossings_[seen.crossing].from_vertex) return;
    crossings_[seen.crossing].from_anchor = anchor;
    crossings_[seen.crossing].from = at;
}

CrossingId MaintainedDelaunay::new_crossing(const Crossing& crossing, DirectedEdge e) {
    if (free_crossings_.empty()) {
        crossings_.push_back(crossing);
        crossing_edges_.push_back(e);
        crossing_generations_.push_back(0);
        return static_cast<CrossingId>(crossings_.size() - 1);
    }
    const CrossingId id = free_crossings_.back();
    free_crossings_.pop_back();
    crossings_[id] = crossing;
    crossing_edges_[id] = e;
    return id;
}

void MaintainedDelaunay::drop_crossing(EdgeRecord& r) {
    if (r.state == EdgeState::crossing) {
        ++crossing_generations_[r.crossing];
        free_crossings_.push_back(r.crossing);
    }
    r = {};
}

std::optional<Crossing> MaintainedDelaunay::take_back_graze(DirectedEdge e, const Point& start) {
    const DirectedEdge back = opposite(e);
    if (recorded_state(back) != EdgeState::crossing) return std::nullopt;
    const Crossing touched = crossing(back);
    const bool is_at_start = (touched.near - start).norm() <= kSamePlace * surroundings_.region().radius();
    if (touch_error_ == 0 && is_at_start) return std::nullopt;
    ++grazes_;
    drop_crossing(record(back));
    return touched;
}

void MaintainedDelaunay::learn_clear(DirectedEdge e, Anchor start, Anchor end) {
    assert(is_free(neighbor(e)));
    record(e) = {EdgeState::clear, kNoCrossing, start};
    record(opposite(e)) = {EdgeState::clear, kNoCrossing, end};
}

void MaintainedDelaunay::learn_contact(DirectedEdge e, const Crossing& seen) {
    Crossing crossing = seen;
    crossing.far = crossing.near;
    crossing.inferred = false;
    crossing.ball_radius = (crossing.near - samples_[facet_samples(e)[0]]).norm();
    drop_crossing(record(e));
    record(e) = {EdgeState::crossing, new_crossing(crossing, e), kNoAnchor};
}

void MaintainedDelaunay::learn_inferred(DirectedEdge e, const Point& near, const Point& far) {
    assert(!crossed(e));
    Crossing crossing;
    crossing.near = crossing.from = near;
    crossing.far = far;
    crossing.from_vertex = false;
    crossing.inferred = true;
    const Point& a = samples_[facet_samples(e)[0]];
    crossing.ball_radius = std::max((near - a).norm(), (far - a).norm());
    record(e) = {EdgeState::crossing, new_crossing(crossing, e), kNoAnchor};
}

void MaintainedDelaunay::withdraw(DirectedEdge e) {
    assert(recorded_state(e) == EdgeState::crossing && crossing(e).near_anchor == kNoAnchor);
    drop_crossing(record(e));
}

}  // namespace palpate
