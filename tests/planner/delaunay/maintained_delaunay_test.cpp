#include "planner/delaunay/maintained_delaunay.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/planner/delaunay/probed_delaunay.h"

namespace palpate::maintained_delaunay_test {
namespace {

constexpr std::uint64_t kSeed = 20240615;

struct Scene {
    std::string name;
    Region workspace;
    Solid solid;
};

std::vector<Scene> scenes() {
    const Point far(200, -30, 10);
    return {
        {"sphere", Region(Ball{{0, 0, 0}, 3}), Solid().add(Ball{{0.3, 0.1, -0.2}, 1})},
        {"sphere that almost fills its workspace", Region(Ball{{0, 0, 0}, 1.01}), Solid().add(Ball{{0, 0, 0}, 1})},
        {"two spheres apart", Region(Box{{-3, -2, -2}, {3, 2, 2}}), Solid().add(Ball{{-1.3, 0, 0}, 1}).add(Ball{{1.2, 0.3, 0}, 0.8})},
        {"two spheres that meet", Region(Ball{far, 2.5}),
         Solid().add(Ball{far + Vector(0.5, 0, 0), 1}).add(Ball{far + Vector(-0.6, 0.2, 0), 0.7})},
        {"sharp box", Region(Ball{{0, 0, 0}, 3}), Solid().add(Box{{-1, -1, -1}, {1, 1, 1}})},
        {"sharp box in a tight box", Region(Box{{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}}), Solid().add(Box{{-1, -1, -1}, {1, 1, 1}})},
    };
}

std::vector<Point> first_samples(const Scene& scene, Random& random) {
    std::vector<Point> samples;
    for (int k = 0; k < 6; ++k) samples.push_back(scene.solid.surface_point(random));
    return samples;
}

CellId any_cell(MaintainedDelaunay& state, Random& random) {
    return state.cell_at(static_cast<std::uint32_t>(random.below(state.sample_count())));
}

// One step of a run that does everything in any order: mostly probes, then samples.
void random_step(ProbedDelaunay& probed, const Scene& scene, Random& random, double chance_to_insert) {
    MaintainedDelaunay& state = probed.state();
    if (random.chance(chance_to_insert)) {
        const std::vector<DirectedEdge> crossings = probed.crossings();
        if (!crossings.empty() && random.chance(0.6)) {
            const DirectedEdge e = random.one_of(crossings);
            const Crossing& c = state.crossing(e);
            if (c.ball_radius > 1e-6) probed.insert(Point(c.near), e.cell);
        } else if (random.chance(0.7)) {
            probed.insert(scene.solid.surface_point(random), any_cell(state, random));
        } else {  // not on S: the records have to stand that too
            probed.insert(scene.workspace.center() + random.uniform(0, 0.5) * scene.workspace.radius() * random.direction(),
                          any_cell(state, random));
        }
        return;
    }
    const double how = random.uniform(0, 1);
    if (how < 0.8) {
        const std::vector<DirectedEdge> open = probed.open_edges();
        if (!open.empty()) probed.probe(random.one_of(open));
        return;
    }
    const std::vector<DirectedEdge> unknown = probed.edges_where([&](DirectedEdge e) { return state.state(e) == EdgeState::unknown; });
    if (unknown.empty()) return;
    const DirectedEdge e = random.one_of(unknown);
    how < 0.9 ? probed.probe_from_outside(e) : probed.probe_from_within(e, random);
}

TEST(MaintainedDelaunay, WhatItKnowsIsTrueAfterEveryStep) {
    for (const Scene& scene : scenes()) {
        for (std::uint64_t seed = kSeed; seed < kSeed + 6; ++seed) {
            SCOPED_TRACE(scene.name + ", " + seed_text(seed));
            Random random(seed);
            ProbedDelaunay probed(scene.workspace, scene.solid, first_samples(scene, random));
            const double chance_to_insert = random.uniform(0.05, 0.4);
            for (int step = 0; step < 150; ++step) {
                SCOPED_TRACE("step " + std::to_string(step));
                random_step(probed, scene, random, chance_to_insert);
                if (HasFatalFailure()) return;
                probed.expect_valid();
                if (HasFatalFailure()) return;
                probed.expect_true();
                if (HasFatalFailure()) return;
            }
            EXPECT_GT(probed.crossings().size(), 0U);
        }
    }
}

// As in a long run: everything that can be probed is, between the samples.
TEST(MaintainedDelaunay, WhatItKnowsIsTrueWhenEverythingReachableIsProbed) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name + ", " + seed_text(kSeed));
        Random random(kSeed);
        ProbedDelaunay probed(scene.workspace, scene.solid, first_samples(scene, random));
        for (int sample = 0; sample < 40; ++sample) {
            SCOPED_TRACE("sample " + std::to_string(sample));
            for (auto open = probed.open_edges(); !open.empty(); open = probed.open_edges()) probed.probe(random.one_of(open));
            probed.expect_valid();
            if (HasFatalFailure()) return;
            probed.expect_true();
            if (HasFatalFailure()) return;
            const std::vector<DirectedEdge> crossings = probed.crossings();
            ASSERT_FALSE(crossings.empty());
            DirectedEdge worst = crossings.front();
            for (const DirectedEdge e : crossings) {
                if (probed.state().crossing(e).ball_radius > probed.state().crossing(worst).ball_radius) worst = e;
            }
            probed.insert(Point(probed.state().crossing(worst).near), worst.cell);
            if (HasFatalFailure()) return;
        }
    }
}

// Four samples of a planar grid make cells whose circumcentre is anywhere (planner/DESIGN.md, "Numerics").
TEST(MaintainedDelaunay, WhatItKnowsIsTrueOnNearlyPlanarGrids) {
    const Scene scene{"", Region(Ball{{0.1, 0.05, 0}, 4}), Solid().add(Box{{-1, -1, -1}, {1, 1, 1}})};
    for (const double jitter : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0}) {
        SCOPED_TRACE("jitter " + std::to_string(jitter) + ", " + seed_text(kSeed));
        Random random(kSeed);
        std::vector<Point> grid;
        for (int x = -2; x <= 2; ++x) {
            for (int y = -2; y <= 2; ++y) grid.push_back(Point(0.5 * x, 0.5 * y, 1) + jitter * random.direction());
        }
        std::shuffle(grid.begin(), grid.end(), std::mt19937_64(kSeed));
        std::vector<Point> samples(grid.begin(), grid.begin() + 5);
        samples.emplace_back(0, 0, -1);
        ProbedDelaunay probed(scene.workspace, scene.solid, samples);
        for (std::size_t k = 5; k < grid.size(); ++k) {
            SCOPED_TRACE("sample " + std::to_string(k));
            for (int probe = 0; probe < 12; ++probe) random_step(probed, scene, random, 0);
            probed.insert(grid[k], any_cell(probed.state(), random));
            if (HasFatalFailure()) return;
            probed.expect_valid();
            if (HasFatalFailure()) return;
            probed.expect_true();
            if (HasFatalFailure()) return;
        }
        for (auto open = probed.open_edges(); !open.empty(); open = probed.open_edges()) probed.probe(random.one_of(open));
        probed.expect_valid();
        if (HasFatalFailure()) return;
        probed.expect_true();
        if (HasFatalFailure()) return;
    }
}

// Exactly cospherical and exactly coplanar: the corners of a lattice. The solid is askew to it, so that no Voronoi vertex
// lies on its surface, where contact and clear are a matter of rounding.
TEST(MaintainedDelaunay, WhatItKnowsIsTrueOnALattice) {
    const Scene scene{"", Region(Box{{-2, -2, -2}, {2, 2, 2}}), Solid().add(Box{{-0.87, -0.91, -0.83}, {0.79, 0.93, 0.77}})};
    for (std::uint64_t seed = kSeed; seed < kSeed + 3; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Random random(seed);
        std::vector<Point> lattice;
        for (int k = 0; k < 27; ++k) {
            if (k != 13) lattice.emplace_back(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        }
        std::shuffle(lattice.begin(), lattice.end(), std::mt19937_64(seed));
        std::vector<Point> samples = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
        std::erase_if(lattice, [&](const Point& p) { return std::find(samples.begin(), samples.end(), p) != samples.end(); });
        ProbedDelaunay probed(scene.workspace, scene.solid, samples);
        for (const Point& p : lattice) {
            for (int probe = 0; probe < 8; ++probe) random_step(probed, scene, random, 0);
            probed.insert(p, any_cell(probed.state(), random));
            if (HasFatalFailure()) return;
            probed.expect_valid();
            if (HasFatalFailure()) return;
            probed.expect_true();
            if (HasFatalFailure()) return;
        }
    }
}

// Up to rounding, which edges of no length are made of: the samples of a sphere are cospherical.
TEST(MaintainedDelaunay, SpanIsTheSameSegmentFromBothEndsAndBisectsTheFacet) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name + ", " + seed_text(kSeed));
        Random random(kSeed);
        ProbedDelaunay probed(scene.workspace, scene.solid, first_samples(scene, random));
        MaintainedDelaunay& state = probed.state();
        for (int k = 0; k < 60; ++k) probed.insert(scene.solid.surface_point(random), any_cell(state, random));
        int seen = 0;
        state.for_each_edge([&](DirectedEdge e) {
            ASSERT_EQ(state.opposite(state.opposite(e)), e);
            const auto there = state.span(e);
            const auto back = state.span(state.opposite(e));
            ASSERT_EQ(there.has_value(), back.has_value());
            if (!there) return;
            ++seen;
            ASSERT_LE((there->start_point() - back->end_point()).norm(), probed.tolerance());
            ASSERT_LE((there->end_point() - back->start_point()).norm(), probed.tolerance());
            ASSERT_EQ(there->starts_on_boundary, back->ends_on_boundary);
            const auto facet = state.facet_samples(e);
            const auto behind = state.facet_samples(state.opposite(e));
            ASSERT_EQ(facet[0], behind[0]);
            ASSERT_EQ(facet[1], behind[2]);
            ASSERT_EQ(facet[2], behind[1]);
            // Counter-clockwise from the cell's side: the edge runs against the normal.
            const Point& a = state.sample(facet[0]);
            const Vector normal = (state.sample(facet[1]) - a).cross(state.sample(facet[2]) - a);
            ASSERT_LE((there->end_point() - there->start_point()).dot(normal), 1e-15);
            for (const Point& x : {there->start_point(), there->end_point()}) {
                ASSERT_GE(depth(scene.workspace, x), -probed.tolerance());
                ASSERT_NEAR((x - a).norm(), (x - state.sample(facet[1])).norm(), probed.tolerance());
                ASSERT_NEAR((x - a).norm(), (x - state.sample(facet[2])).norm(), probed.tolerance());
                // A point of a Voronoi edge: nothing is nearer.
                for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
                    ASSERT_GE((x - state.sample(s)).norm(), (x - a).norm() - probed.tolerance());
                }
            }
        });
        if (HasFatalFailure()) return;
        EXPECT_GT(seen, 100);
    }
}

TEST(MaintainedDelaunay, FirstProbesOfATetrahedron) {
    const Region workspace(Ball{{0, 0, 0}, 10});
    ProbedDelaunay probed(workspace, Solid().add(Ball{{0, 0, 0}, 1}), {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    MaintainedDelaunay& state = probed.state();
    EXPECT_EQ(state.sample_count(), 4U);
    // One finite cell, whose Voronoi vertex is the centre, and four infinite ones, free at once.
    EXPECT_EQ(state.cell_slots(), 5U);
    std::vector<DirectedEdge> open = probed.open_edges();
    EXPECT_EQ(open.size(), 4U) << "one edge per hull facet, from outside";
    for (const DirectedEdge e : open) {
        EXPECT_TRUE(state.is_outside(e.cell));
        const auto along = state.span(e);
        ASSERT_TRUE(along);
        EXPECT_TRUE(along->starts_on_boundary);
        EXPECT_FALSE(along->ends_on_boundary);
        EXPECT_NEAR(along->start_point().norm(), 10, 1e-9);
        EXPECT_NEAR(along->end_point().norm(), 0, 1e-12);
        EXPECT_TRUE(probed.probe(e));
        EXPECT_EQ(state.state(e), EdgeState::crossing);
        EXPECT_EQ(state.state(state.opposite(e)), EdgeState::unknown) << "the other direction is another record";
        EXPECT_FALSE(state.is_free(state.neighbor(e)));
    }
    probed.expect_valid();
    probed.expect_true();
    EXPECT_TRUE(probed.open_edges().empty());
}

TEST(MaintainedDelaunay, TicketsAndCrossingIdsOutliveNothing) {
    const Scene scene = scenes().front();
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    ProbedDelaunay probed(scene.workspace, scene.solid, first_samples(scene, random));
    MaintainedDelaunay& state = probed.state();
    struct Held {
        EdgeTicket ticket;
        std::array<std::uint32_t, 3> facet;
    };
    struct Known {
        CrossingId id;
        std::uint32_t generation;
        Point near;
    };
    std::vector<Held> held;
    std::vector<Known> known;
    std::size_t gone = 0;
    for (int step = 0; step < 300; ++step) {
        random_step(probed, scene, random, 0.2);
        if (HasFatalFailure()) return;
        // A ticket that is still good means the same facet as ever.
        for (const Held& h : held) {
            if (state.is_current(h.ticket)) {
                ASSERT_EQ(state.facet_samples(h.ticket.edge), h.facet);
            }
        }
        // A crossing that is still there is the same touch, on an edge that says so.
        for (const Known& k : known) {
            const auto e = state.edge_of(k.id, k.generation);
            gone += e ? 0 : 1;
            if (!e) continue;
            ASSERT_EQ(state.recorded_state(*e), EdgeState::crossing);
            ASSERT_EQ(state.crossing_id(*e), k.id);
            ASSERT_EQ(state.crossing(*e).near, k.near);
        }
        if (step % 10 == 0) {
            const auto edges = probed.edges_where([&](DirectedEdge e) { return state.span(e).has_value(); });
            const DirectedEdge e = random.one_of(edges);
            held.push_back({state.ticket(e), state.facet_samples(e)});
            for (const DirectedEdge c : probed.crossings()) {
                known.push_back({state.crossing_id(c), state.generation_of(state.crossing_id(c)), state.crossing(c).near});
            }
        }
    }
    EXPECT_GT(gone, 0U);
}

TEST(MaintainedDelaunay, FindsFacetsAndCellsOfSamples) {
    const Scene scene = scenes().front();
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    ProbedDelaunay probed(scene.workspace, scene.solid, first_samples(scene, random));
    MaintainedDelaunay& state = probed.state();
    for (int k = 0; k < 30; ++k) probed.insert(scene.solid.surface_point(random), any_cell(state, random));
    std::map<std::uint32_t, std::size_t> cells_of;
    std::map<std::array<std::uint32_t, 3>, bool> facets;
    for (CellId cell = 0; cell < state.cell_slots(); ++cell) {
        if (!state.is_live(cell)) continue;
        for (int i = 0; i < 4; ++i) {
            if (const auto s = state.sample_of(cell, i)) ++cells_of[*s];
            bool finite = true;
            for (int k = 0; k < 4; ++k) finite &= k == i || state.sample_of(cell, k).has_value();
            if (!finite) continue;
            auto facet = state.facet_samples({cell, i});
            const auto found = state.find_facet(facet[0], facet[1], facet[2]);
            ASSERT_TRUE(found);
            ASSERT_TRUE(*found == (DirectedEdge{cell, i}) || *found == state.opposite({cell, i}));
            std::sort(facet.begin(), facet.end());
            facets[facet] = true;
        }
    }
    for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
        EXPECT_EQ(state.cells_around(s).size(), cells_of[s]);
        const CellId cell = state.cell_at(s);
        EXPECT_TRUE(state.sample_of(cell, 0) == s || state.sample_of(cell, 1) == s || state.sample_of(cell, 2) == s ||
                    state.sample_of(cell, 3) == s);
    }
    for (int k = 0; k < 1000; ++k) {
        std::array<std::uint32_t, 3> f{};
        for (std::uint32_t& s : f) s = static_cast<std::uint32_t>(random.below(state.sample_count()));
        std::sort(f.begin(), f.end());
        if (f[0] == f[1] || f[1] == f[2]) continue;
        ASSERT_EQ(state.find_facet(f[0], f[1], f[2]).has_value(), facets.contains(f));
    }
}

TEST(MaintainedDelaunay, NextFacetAroundStaysAroundTheEdgeAndComesBack) {
    const Scene scene = scenes().front();
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    ProbedDelaunay probed(scene.workspace, scene.solid, first_samples(scene, random));
    MaintainedDelaunay& state = probed.state();
    for (int k = 0; k < 20; ++k) probed.insert(scene.solid.surface_point(random), any_cell(state, random));
    const auto has = [&](CellId cell, std::optional<std::uint32_t> sample) {
        for (int k = 0; k < 4; ++k) {
            if (state.sample_of(cell, k) == sample) return true;
        }
        return false;
    };
    state.for_each_edge([&](DirectedEdge first) {
        for (int across = 0; across < 4; ++across) {
            if (across == first.facet) continue;
            std::vector<std::optional<std::uint32_t>> ends;
            for (int k = 0; k < 4; ++k) {
                if (k != first.facet && k != across) ends.push_back(state.sample_of(first.cell, k));
            }
            std::size_t around = 0;
            for (CellId cell = 0; cell < state.cell_slots(); ++cell) {
                if (state.is_live(cell) && has(cell, ends[0]) && has(cell, ends[1])) ++around;
            }
            CellId cell = first.cell;
            int in = first.facet;
            int out = across;
            std::size_t steps = 0;
            do {
                const DirectedEdge back = state.opposite({cell, out});
                out = state.next_facet_around(cell, in, out);
                in = back.facet;
                cell = back.cell;
                ASSERT_NE(in, out);
                ASSERT_TRUE(has(cell, ends[0]) && has(cell, ends[1]));
                ASSERT_LE(++steps, around);
            } while (cell != first.cell);
            ASSERT_EQ(steps, around);
            ASSERT_EQ(in, first.facet);
            ASSERT_EQ(out, across);
        }
    });
}

TEST(MaintainedDelaunay, RefusesWhatItCannotHold) {
    const Region workspace(Ball{{0, 0, 0}, 10});
    const std::vector<Point> flat = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 2, 0}};
    EXPECT_THROW(MaintainedDelaunay(workspace).initialise(flat), std::logic_error);
    const std::vector<Point> twice = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    EXPECT_THROW(MaintainedDelaunay(workspace).initialise(twice), std::logic_error);
    MaintainedDelaunay state(workspace);
    const std::vector<Point> good = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    state.initialise(good);
    EXPECT_THROW((void)state.insert({0, 1, 0}, state.cell_at(0)), std::logic_error);
}

TEST(MaintainedDelaunay, AnEdgeThatIsClearFromItsOtherEndWasOnlyGrazed) {
    const Region workspace(Ball{{0, 0, 0}, 10});
    ProbedDelaunay probed(workspace, Solid().add(Ball{{0, 0, 0}, 1}), {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    MaintainedDelaunay& state = probed.state();
    const DirectedEdge e = probed.open_edges().front();
    probed.probe(e);
    ASSERT_TRUE(state.in_surface(e));
    const DirectedEdge back = state.opposite(e);
    Roadmap& roadmap = probed.space().roadmap();
    const NodeId start = roadmap.add_on_boundary({0, 0, 10});
    probed.space().learn_clear(back, start, roadmap.add(start, probed.space().end_of(back, *state.span(back))));
    EXPECT_EQ(state.grazes(), 1U);
    EXPECT_EQ(state.recorded_state(e), EdgeState::clear);
    EXPECT_EQ(state.recorded_state(back), EdgeState::clear);
}

// A plate between two samples on its sides: their facets' edges cross it twice.
TEST(MaintainedDelaunay, AFacetWhoseEdgeIsCrossedTwiceIsNotInTheSurface) {
    const Region workspace(Ball{{0, 0, 0}, 10});
    const double t = 0.1;
    ProbedDelaunay probed(workspace, Solid().add(Box{{-5, -5, 0}, {5, 5, t}}), {{1, 0, t}, {-1, 0.1, t}, {0, 1, t}, {0.1, -0.2, 0}});
    MaintainedDelaunay& state = probed.state();
    while (!probed.open_edges().empty()) probed.probe(probed.open_edges().front());
    std::size_t doubles = 0;
    state.for_each_edge([&](DirectedEdge e) {
        if (!state.is_double(e)) return;
        ++doubles;
        EXPECT_FALSE(state.in_surface(e));
        EXPECT_TRUE(state.is_double(state.opposite(e)));
        EXPECT_NEAR(std::abs(state.crossing(e).near.z() - state.crossing(state.opposite(e)).near.z()), t, 1e-9);
        EXPECT_GE(state.thickness(e), t * (1 - 1e-9));
        for (const std::uint32_t sample : state.facet_samples(e)) EXPECT_TRUE(state.is_thin_at(sample));
    });
    EXPECT_GT(doubles, 0U);
    std::string why;
    EXPECT_TRUE(state.is_valid(&why)) << why;
}

}  // namespace
}  // namespace palpate::maintained_delaunay_test
