// A MaintainedDelaunay that is probed on a solid in closed form, and the brute-force check of all that it claims to know.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planner/motion/probed_space.h"
#include "tests/planner/delaunay/probe_edge.h"
#include "tests/planner/support.h"

namespace palpate {

class ProbedDelaunay {
public:
    // What rounding may cost, of the workspace (planner/delaunay/validity.cc).
    static constexpr double kTolerance = 1e-9;

    ProbedDelaunay(const Region& workspace, Solid solid, const std::vector<Point>& samples)
        : workspace_(workspace), solid_(std::move(solid)), space_(workspace), state_(space_.delaunay()) {
        state_.initialise(samples);
    }

    [[nodiscard]] MaintainedDelaunay& state() { return state_; }
    [[nodiscard]] ProbedSpace& space() { return space_; }
    [[nodiscard]] double tolerance() const { return kTolerance * workspace_.radius(); }

    template <typename Holds>
    [[nodiscard]] std::vector<DirectedEdge> edges_where(const Holds& holds) {
        std::vector<DirectedEdge> edges;
        state_.for_each_edge([&](DirectedEdge e) {
            if (holds(e)) edges.push_back(e);
        });
        return edges;
    }
    [[nodiscard]] std::vector<DirectedEdge> open_edges() {
        return edges_where([&](DirectedEdge e) { return state_.is_reachable(e) && state_.state(e) == EdgeState::unknown; });
    }
    [[nodiscard]] std::vector<DirectedEdge> crossings() {
        return edges_where([&](DirectedEdge e) { return state_.recorded_state(e) == EdgeState::crossing; });
    }

    // As the planner does. REQUIRES: reachable and unknown. Returns whether S was touched.
    bool probe(DirectedEdge e) {
        return probe_edge(
            space_, e, [this](const Point& from, const Point& to) { return solid_.first_hit(from, to); }, touches_);
    }

    // Along the edge's whole line, from outside ω: what a seed facet's dual edge gets.
    void probe_from_outside(DirectedEdge e) {
        const std::optional<EdgeSpan> along = state_.span(e);
        if (!along || state_.state(e) != EdgeState::unknown || along->start == along->end) return;
        const Vector onwards = along->end > along->start ? along->line.direction : Vector(-along->line.direction);
        const auto chord = workspace_.clip(along->line.origin, onwards);
        if (!chord) return;
        Roadmap& roadmap = space_.roadmap();
        const NodeId entry = roadmap.add_on_boundary(along->line.origin + chord->low * onwards);
        const auto hit = solid_.first_hit(roadmap.at(entry), along->end_point());
        if (!hit || onwards.dot(*hit - along->start_point()) < 0) return;
        space_.learn_contact_from_outside(e, *along, entry, roadmap.add(entry, *hit), touches_++);
    }

    // From a point of the edge that was reached by another way.
    void probe_from_within(DirectedEdge e, Random& random) {
        const std::optional<EdgeSpan> along = state_.span(e);
        if (!along || state_.state(e) != EdgeState::unknown) return;
        const Point q = along->line.at(random.uniform(along->start, along->end));
        Roadmap& roadmap = space_.roadmap();
        const Point outside = random.on_boundary(workspace_);
        if (solid_.first_hit(outside, q)) return;
        const auto hit = solid_.first_hit(q, along->end_point());
        if (!hit) return;
        const NodeId from = roadmap.add(roadmap.add_on_boundary(outside), q);
        space_.learn_contact(e, from, roadmap.add(from, *hit), touches_++, false);
    }

    // Inserts a point and checks the fate of everything that was known (planner/DESIGN.md, "Insertion"), by brute force.
    void insert(const Point& p, CellId near) {
        const std::map<CellKey, CellKnowledge> before = knowledge();
        const auto facets_before = crossed_facets();
        const MaintainedDelaunay::Insertion insertion = space_.insert(p, near);
        ASSERT_EQ(state_.sample(insertion.sample), p);
        ASSERT_EQ(insertion.sample + 1, state_.sample_count());
        expect_kept(before, p, insertion.sample);
        // Every new cell once, from its new vertex towards its survivor.
        std::size_t fresh = 0;
        for (CellId cell = 0; cell < state_.cell_slots(); ++cell) {
            if (state_.is_live(cell) && key_of(cell).contains(insertion.sample)) ++fresh;
        }
        ASSERT_EQ(insertion.cropped.size(), fresh);
        for (const DirectedEdge from_new : insertion.cropped) {
            ASSERT_EQ(state_.sample_of(from_new.cell, from_new.facet), insertion.sample);
        }
        std::set<std::array<std::uint32_t, 3>> lost;
        for (auto facet : insertion.lost) {
            std::sort(facet.begin(), facet.end());
            ASSERT_TRUE(lost.insert(facet).second) << "lost twice";
        }
        std::set<std::array<std::uint32_t, 3>> gone;
        const auto facets_after = crossed_facets();
        std::set_difference(facets_before.begin(), facets_before.end(), facets_after.begin(), facets_after.end(),
                            std::inserter(gone, gone.end()));
        ASSERT_EQ(lost, gone);
        // What came into Ŝ was there before, crossed twice.
        std::set<std::array<std::uint32_t, 3>> gained;
        for (const DirectedEdge e : insertion.gained)
            ASSERT_TRUE(gained.insert(in_order(state_.facet_samples(e))).second) << "gained twice";
        std::set<std::array<std::uint32_t, 3>> come;
        std::set_difference(facets_after.begin(), facets_after.end(), facets_before.begin(), facets_before.end(),
                            std::inserter(come, come.end()));
        std::erase_if(come, [&](const auto& facet) { return facet[2] == insertion.sample; });
        ASSERT_EQ(gained, come);
    }

    // The facets of Ŝ, each with its samples in order.
    [[nodiscard]] std::set<std::array<std::uint32_t, 3>> crossed_facets() const {
        std::set<std::array<std::uint32_t, 3>> facets;
        state_.for_each_edge([&](DirectedEdge e) {
            if (state_.recorded_state(e) != EdgeState::crossing || state_.is_double(e)) return;
            facets.insert(in_order(state_.facet_samples(e)));
        });
        return facets;
    }

    void expect_valid() {
        std::string why;
        ASSERT_TRUE(space_.is_valid(&why)) << why;
    }

    // Everything that is recorded is true of the solid.
    void expect_true() {
        for (CellId cell = 0; cell < state_.cell_slots(); ++cell) {
            if (!state_.is_live(cell)) continue;
            if (state_.is_free(cell) && !state_.is_outside(cell)) expect_free_vertex(cell);
            for (int i = 0; i < 4 && !testing::Test::HasFatalFailure(); ++i) expect_true_record({cell, i});
            if (testing::Test::HasFatalFailure()) return;
        }
    }

private:
    struct CellKey {
        std::array<std::uint32_t, 4> samples{};  // sorted; kInfinite for the vertex at infinity
        [[nodiscard]] bool contains(std::uint32_t sample) const {
            return std::find(samples.begin(), samples.end(), sample) != samples.end();
        }
        friend bool operator<(const CellKey& x, const CellKey& y) { return x.samples < y.samples; }
    };
    static constexpr std::uint32_t kInfinite = ~std::uint32_t{0};
    struct EdgeKnowledge {
        EdgeState state = EdgeState::unknown;
        Crossing crossing;
        bool inside = false;  // has a part inside ω
        CellKey neighbor;
    };
    struct CellKnowledge {
        bool free = false;
        std::map<std::uint32_t, EdgeKnowledge> edges;  // by the sample opposite to the facet
    };

    [[nodiscard]] CellKey key_of(CellId cell) const {
        CellKey key;
        for (int i = 0; i < 4; ++i) key.samples[static_cast<std::size_t>(i)] = state_.sample_of(cell, i).value_or(kInfinite);
        std::sort(key.samples.begin(), key.samples.end());
        return key;
    }

    [[nodiscard]] std::map<CellKey, CellKnowledge> knowledge() {
        std::map<CellKey, CellKnowledge> all;
        for (CellId cell = 0; cell < state_.cell_slots(); ++cell) {
            if (!state_.is_live(cell)) continue;
            CellKnowledge& known = all[key_of(cell)];
            known.free = state_.is_free(cell);
            for (int i = 0; i < 4; ++i) {
                EdgeKnowledge& edge = known.edges[state_.sample_of(cell, i).value_or(kInfinite)];
                edge.state = state_.recorded_state({cell, i});
                if (edge.state == EdgeState::crossing) edge.crossing = state_.crossing({cell, i});
                edge.inside = state_.span({cell, i}).has_value();
                edge.neighbor = key_of(state_.neighbor({cell, i}));
            }
        }
        return all;
    }

    // planner/DESIGN.md, "Insertion" for each edge of a cell that survived: u is that cell, w its old neighbour, v its new one.
    void expect_kept(const std::map<CellKey, CellKnowledge>& before, const Point& p, std::uint32_t fresh_sample) {
        const std::map<CellKey, CellKnowledge> after = knowledge();
        for (const auto& [u, known] : before) {
            const auto found = after.find(u);
            if (found == after.end()) continue;
            ASSERT_TRUE(found->second.free || !known.free) << "a survivor is no longer free";
            for (const auto& [opposite, was] : known.edges) {
                const EdgeKnowledge& is = found->second.edges.at(opposite);
                if (!is.neighbor.contains(fresh_sample)) {
                    ASSERT_EQ(is.state, was.state) << "knowledge of an edge that was not touched changed";
                    if (is.state == EdgeState::crossing) {
                        ASSERT_EQ(is.crossing.near, was.crossing.near);
                    }
                    continue;
                }
                if (!was.inside || !is.inside) continue;  // outside ω everything is clear
                const std::uint32_t far = beyond(was.neighbor, u, opposite);
                const EdgeKnowledge& from_w = before.at(was.neighbor).edges.at(far);
                const CellKnowledge& v = after.at(is.neighbor);
                expect_cropped(was, from_w, is, v.edges.at(fresh_sample), v.free, p, a_of(u, opposite));
                if (testing::Test::HasFatalFailure()) return;
            }
        }
    }

    // The sample of `cell` that its neighbour across the facet opposite to `opposite` of `neighbor` does not have.
    [[nodiscard]] static std::uint32_t beyond(const CellKey& cell, const CellKey& neighbor, std::uint32_t opposite) {
        for (const std::uint32_t s : cell.samples) {
            if (s == opposite || !neighbor.contains(s)) return s;
        }
        return kInfinite;
    }
    [[nodiscard]] Point a_of(const CellKey& u, std::uint32_t opposite) const {
        for (const std::uint32_t s : u.samples) {
            if (s != opposite && s != kInfinite) return state_.sample(s);
        }
        return Point::Zero();
    }

    void expect_cropped(const EdgeKnowledge& u_was, const EdgeKnowledge& w_was, const EdgeKnowledge& u_is, const EdgeKnowledge& v_is,
                        bool v_free, const Point& p, const Point& a) const {
        // Cut off, kept, or too close to tell.
        const auto margin = [&](const Point& x) { return (x - p).norm() - (x - a).norm(); };
        const auto cut = [&](const Point& x) { return margin(x) < -tolerance(); };
        const auto kept = [&](const Point& x) { return margin(x) > tolerance(); };
        if (u_was.state == EdgeState::clear) {
            ASSERT_EQ(u_is.state, EdgeState::clear);
            ASSERT_EQ(v_is.state, EdgeState::clear);
            ASSERT_TRUE(v_free);
            return;
        }
        if (u_was.state == EdgeState::crossing && kept(u_was.crossing.near)) {
            ASSERT_EQ(u_is.state, EdgeState::crossing);
            ASSERT_EQ(u_is.crossing.near, u_was.crossing.near);
            ASSERT_EQ(u_is.crossing.from_vertex, u_was.crossing.from_vertex);
        } else if (u_was.state == EdgeState::crossing && cut(u_was.crossing.near)) {
            ASSERT_EQ(u_is.state, u_was.crossing.from_vertex ? EdgeState::clear : EdgeState::unknown);
            if (u_was.crossing.from_vertex || kept(u_was.crossing.from)) {
                ASSERT_TRUE(v_free);
            }
        } else if (u_was.state == EdgeState::unknown) {
            ASSERT_EQ(u_is.state, EdgeState::unknown);
        }
        if (w_was.state == EdgeState::crossing && kept(w_was.crossing.near)) {
            ASSERT_EQ(v_is.state, EdgeState::crossing);
            ASSERT_EQ(v_is.crossing.near, w_was.crossing.near);
            if (w_was.crossing.from_vertex || cut(w_was.crossing.from)) {
                ASSERT_TRUE(v_free);
                ASSERT_TRUE(v_is.crossing.from_vertex);
            } else if (kept(w_was.crossing.from)) {
                ASSERT_FALSE(v_is.crossing.from_vertex);
            }
        } else if (w_was.state == EdgeState::crossing && cut(w_was.crossing.near)) {
            ASSERT_NE(v_is.state, EdgeState::crossing);
        }
        if (u_was.state == EdgeState::unknown && w_was.state == EdgeState::unknown) {
            ASSERT_EQ(v_is.state, EdgeState::unknown);
        }
    }

    void expect_free_vertex(CellId cell) {
        const Point& at = space_.roadmap().at(state_.anchor(cell));
        ASSERT_LE(solid_.depth_at(at), tolerance()) << "a free Voronoi vertex lies in the solid";
        ASSERT_GE(depth(workspace_, at), -tolerance()) << "the node of a vertex inside the workspace lies outside";
        // It is the circumcentre: as far from all four samples, and no sample nearer.
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t s = 0; s < state_.sample_count(); ++s) least = std::min(least, (state_.sample(s) - at).norm());
        for (int i = 0; i < 4; ++i) ASSERT_NEAR((state_.sample(*state_.sample_of(cell, i)) - at).norm(), least, 2 * tolerance());
    }

    void expect_true_record(DirectedEdge e) {
        const EdgeState known = state_.recorded_state(e);
        const std::optional<EdgeSpan> along = state_.span(e);
        if (known == EdgeState::unknown || !along) return;
        ASSERT_TRUE(!along->starts_on_boundary || depth(workspace_, along->start_point()) <= tolerance());
        if (known == EdgeState::clear) {
            ASSERT_FALSE(solid_.meets(along->start_point(), along->end_point(), tolerance())) << "clear, but the solid meets the edge";
            return;
        }
        const Crossing& c = state_.crossing(e);
        ASSERT_NEAR(solid_.depth_at(c.near), 0, tolerance()) << "the contact is not on the surface";
        ASSERT_EQ(c.near, c.far);
        const Point from = c.from_vertex ? along->start_point() : c.from;
        ASSERT_FALSE(solid_.meets(from, c.near, tolerance())) << "not the first contact from its end";
        ASSERT_GE((along->end - along->start) * along->line.direction.dot(c.near - from),
                  -tolerance() * std::abs(along->end - along->start));
        if (c.from_vertex) {
            ASSERT_TRUE(state_.is_free(e.cell));
        }
        // The surface Delaunay ball is empty.
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t s = 0; s < state_.sample_count(); ++s) least = std::min(least, (state_.sample(s) - c.near).norm());
        ASSERT_NEAR(c.ball_radius, least, 2 * tolerance());
    }

    const Region workspace_;
    const Solid solid_;
    ProbedSpace space_;
    MaintainedDelaunay& state_;
    std::uint32_t touches_ = 0;
};

}  // namespace palpate
