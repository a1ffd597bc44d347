// MaintainedDelaunay::is_valid: the invariants of planner/DESIGN.md, "State" and "Insertion", as far as they can be told without O.
#include <fmt/format.h>

#include <cmath>

#include "planner/delaunay/maintained_delaunay.h"

namespace palpate {
namespace {

// What rounding may cost a point on a dual edge, as a fraction of the workspace (planner/delaunay/dual_line.h).
constexpr double kTolerance = 1e-9;

}  // namespace

bool MaintainedDelaunay::is_valid(std::string* why, const std::function<Point(Anchor)>& place_of) const {
    std::string wrong;
    const double tolerance = kTolerance * surroundings_.region().radius();
    const auto check = [&](bool good, DirectedEdge e, const char* what) {
        if (!good && wrong.empty()) wrong = fmt::format("cell {}, facet {}: {}", e.cell, e.facet, what);
        return good;
    };
    bool valid = delaunay_.is_valid();
    if (!valid) wrong = "the triangulation is not Delaunay";
    std::size_t live = 0;
    for (CellId id = 0; id < cells_.size(); ++id) {
        const Cell& cell = cells_[id];
        if (!cell.live) continue;
        ++live;
        valid &= check(cell.handle->info() == id, {id, 0}, "the slot and the cell disagree");
        valid &= check(!cell.outside || cell.free, {id, 0}, "outside the workspace, but not free");
        valid &= check(cell.outside || cell.free == (cell.anchor != kNoAnchor), {id, 0},
                       "free without an anchor, or an anchor without being free");
        for (int i = 0; i < 4; ++i) {
            const DirectedEdge e{id, i};
            const DirectedEdge back = opposite(e);
            const EdgeRecord& r = record(e);
            if (r.state == EdgeState::unknown || r.state == EdgeState::failed) continue;
            const std::optional<EdgeSpan> along = span(e);
            if (r.state == EdgeState::clear) {
                valid &= check(record(back).state == EdgeState::clear, e, "clear from one end only");
                valid &= check(cell.free && cells_[back.cell].free, e, "clear, but an end is not free");
                valid &= check(!along || r.anchor != kNoAnchor, e, "clear inside the workspace without an anchor");
                if (along && r.anchor != kNoAnchor && place_of) {
                    valid &= check((place_of(r.anchor) - along->start_point()).norm() <= tolerance, e,
                                   "the anchor is not where the edge starts");
                }
                continue;
            }
            valid &= check(along.has_value(), e, "a crossing outside the workspace");
            if (!along) continue;
            const Crossing& c = crossings_[r.crossing];
            valid &= check(crossing_edges_[r.crossing] == e, e, "the crossing is registered elsewhere");
            valid &= check(!c.from_vertex || cell.free, e, "crossing from a vertex that is not free");
            const double sign = along->end >= along->start ? 1 : -1;
            const auto parameter = [&](const Point& p) { return sign * along->line.direction.dot(p - along->line.origin); };
            valid &= check((c.near - along->line.at(sign * parameter(c.near))).norm() <= tolerance, e, "the crossing is off its edge");
            valid &= check(parameter(c.near) >= sign * along->start - tolerance && parameter(c.far) <= sign * along->end + tolerance, e,
                           "the crossing is beyond its edge");
            valid &= check(parameter(c.near) <= parameter(c.far) + tolerance, e, "the gap is upside down");
            if (c.from_vertex) {
                valid &=
                    check((c.from - along->start_point()).norm() <= tolerance, e, "the crossing was not seen from where the edge starts");
            }
            const Point& a = samples_[facet_samples(e)[0]];
            const double radius = std::max((c.near - a).norm(), (c.far - a).norm());
            valid &= check(!c.inferred || (!c.from_vertex && c.from_anchor == kNoAnchor && c.near_anchor == kNoAnchor), e,
                           "an inferred crossing that frees something");
            valid &= check(std::abs(radius - c.ball_radius) <= tolerance, e, "the ball radius is wrong");
        }
    }
    if (live != delaunay_.tds().number_of_cells()) {
        valid = false;
        wrong += " cells without a slot";
    }
    if (why != nullptr) *why = wrong;
    return valid;
}

}  // namespace palpate
