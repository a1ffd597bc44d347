#include "planner/loop/voronoi_walk.h"

#include <gtest/gtest.h>

#include "tests/planner/delaunay/probed_delaunay.h"

namespace palpate::voronoi_walk_test {
namespace {

constexpr std::uint64_t kSeed = 20240616;

// The loop of a run without a tool, on two spheres; samples are balls larger than epsilon.
class Exploring {
public:
    Exploring(Strategy::Explore explore, std::uint64_t seed)
        : random_(seed), probed_(workspace(), solid(), first_samples(random_)), walk_(probed_.state(), explore) {
        // A persistent facet to begin with, touched from outside.
        const DirectedEdge e = *state().find_facet(0, 1, 2);
        probed_.probe_from_outside(e);
        probed_.probe_from_outside(state().opposite(e));
        walk_.sweep();
    }

    [[nodiscard]] ProbedDelaunay& probed() { return probed_; }
    [[nodiscard]] MaintainedDelaunay& state() { return probed_.state(); }
    [[nodiscard]] VoronoiWalk& exploration() { return walk_; }

    // Until there is nothing left to probe, inserting what is larger than epsilon.
    void run(double epsilon) {
        while (const auto e = walk_.next()) {
            ASSERT_TRUE(state().is_live(e->cell));
            ASSERT_TRUE(state().is_reachable(*e)) << "a probe cannot start there";
            ASSERT_EQ(state().state(*e), EdgeState::unknown) << "the answer is known";
            ASSERT_LT(++probes_, 20000);
            const CellId far = state().neighbor(*e);
            const bool was_free = state().is_free(far);
            if (!probed_.probe(*e)) {
                if (!was_free) walk_.note_free(far);
            } else if (const Crossing& c = state().crossing(*e); c.ball_radius > epsilon) {
                walk_.note_insertion(probed_.space().insert(Point(c.near), e->cell));
            } else {
                walk_.note_crossing(*e);
            }
        }
    }

    [[nodiscard]] int probes() const { return probes_; }

private:
    static Region workspace() { return Region(Ball{{0, 0, 0}, 3}); }
    static Solid solid() { return Solid().add(Ball{{-0.5, 0, 0}, 1}).add(Ball{{0.7, 0.1, 0}, 0.8}); }
    static std::vector<Point> first_samples(Random& random) {
        std::vector<Point> samples;
        const Vector seed = (random.direction() - 2 * Vector::UnitX()).normalized();
        for (const Vector& aside : {Vector(0, 0, 0.05), Vector(0, 0.05, -0.01), Vector(0, -0.05, 0)}) {
            samples.push_back(Point(-0.5, 0, 0) + (seed + aside).normalized());
        }
        for (int k = 0; k < 4; ++k) samples.push_back(solid().surface_point(random));
        return samples;
    }

    Random random_;
    ProbedDelaunay probed_;
    VoronoiWalk walk_;
    int probes_ = 0;
};

// Walks from a wing by the names of samples alone: through cells around the Delaunay edge p–q, away from the wing's
// facet, until an edge is not clear. Returns the state of that edge.
EdgeState end_of_walk(MaintainedDelaunay& state, DirectedEdge wing, int across) {
    std::vector<std::optional<std::uint32_t>> axis;
    for (int k = 0; k < 4; ++k) {
        if (k != wing.facet && k != across) axis.push_back(state.sample_of(wing.cell, k));
    }
    DirectedEdge ahead{wing.cell, across};
    while (state.state(ahead) == EdgeState::clear) {
        const DirectedEdge arrived = state.opposite(ahead);
        int next = 0;
        while (next == arrived.facet || state.sample_of(arrived.cell, next) == axis[0] || state.sample_of(arrived.cell, next) == axis[1])
            ++next;
        ahead = {arrived.cell, next};
    }
    return state.state(ahead);
}

// Facets of Ŝ at the Delaunay edge that a wing walks around, by the names of samples alone.
int facets_at(Exploring& exploring, DirectedEdge wing, int across) {
    const std::set<std::array<std::uint32_t, 3>> all = exploring.probed().crossed_facets();
    return static_cast<int>(std::count_if(all.begin(), all.end(), [&](const auto& facet) {
        int shared = 0;
        for (int k = 0; k < 4; ++k) {
            if (k != wing.facet && k != across)
                shared += std::count(facet.begin(), facet.end(), exploring.state().sample_of(wing.cell, k)) > 0;
        }
        return shared == 2;
    }));
}

// A wing walks from a free vertex; every crossing of such a vertex has three of them.
std::pair<int, int> closed_and_open_wings(Exploring& exploring) {
    MaintainedDelaunay& state = exploring.state();
    int closed = 0;
    int open = 0;
    for (const DirectedEdge e : exploring.probed().crossings()) {
        if (!state.is_free(e.cell)) continue;
        for (int j = 0; j < 4; ++j) {
            if (j == e.facet) continue;
            ++(facets_at(exploring, e, j) > 1 || end_of_walk(state, e, j) == EdgeState::crossing ? closed : open);
        }
    }
    return {closed, open};
}

TEST(VoronoiWalk, ClosureEndsExactlyWhenEveryWingIsClosed) {
    for (std::uint64_t seed = kSeed; seed < kSeed + 5; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Exploring exploring(Strategy::Explore::closure, seed);
        EXPECT_GT(closed_and_open_wings(exploring).second, 0);
        exploring.run(0.3);
        if (HasFatalFailure()) return;
        const auto [closed, open] = closed_and_open_wings(exploring);
        EXPECT_GT(closed, 100);
        EXPECT_EQ(open, 0);
        exploring.probed().expect_valid();
        exploring.probed().expect_true();
        // And it does not forget: a fresh look finds nothing more.
        exploring.exploration().sweep();
        EXPECT_GT(exploring.exploration().open_count(), 0U);
        EXPECT_FALSE(exploring.exploration().next());
    }
}

TEST(VoronoiWalk, ClosureAsksOnlyForEdgesThatAWalkMeets) {
    Exploring exploring(Strategy::Explore::closure, kSeed);
    MaintainedDelaunay& state = exploring.state();
    int asked = 0;
    while (const auto e = exploring.exploration().next()) {
        // Some wing's walk ends exactly there, and only one facet is known at its Delaunay edge.
        bool met = false;
        for (int in = 0; in < 4 && !met; ++in) {
            if (in == e->facet) continue;
            // Backwards around the edge that facets `in` and `e` share, until the crossing that the walk began at.
            std::vector<std::optional<std::uint32_t>> axis;
            for (int k = 0; k < 4; ++k) {
                if (k != in && k != e->facet) axis.push_back(state.sample_of(e->cell, k));
            }
            DirectedEdge behind{e->cell, in};
            const DirectedEdge first = behind;
            do {
                const EdgeState known = state.state(behind);
                // A walk may have begun here, and goes past edges that S crosses twice.
                if (known == EdgeState::crossing) {
                    const auto [in_surface, doubled] = state.count_facets_at(*axis[0], *axis[1], {});
                    met |= state.is_double(behind) ? in_surface + doubled < 2 : in_surface != 2;
                }
                const DirectedEdge arrived = state.opposite(behind);
                const bool goes_on = known == EdgeState::clear || (state.is_double(behind) && state.is_free(arrived.cell));
                if (met || !goes_on) break;
                int next = 0;
                while (next == arrived.facet || state.sample_of(arrived.cell, next) == axis[0] ||
                       state.sample_of(arrived.cell, next) == axis[1])
                    ++next;
                behind = {arrived.cell, next};
            } while (behind != first);
        }
        ASSERT_TRUE(met);
        ASSERT_LT(++asked, 1000);
        const CellId far = state.neighbor(*e);
        if (exploring.probed().probe(*e)) {
            exploring.exploration().note_crossing(*e);
        } else {
            exploring.exploration().note_free(far);
        }
    }
    EXPECT_GT(asked, 0);
}

TEST(VoronoiWalk, ExhaustiveEndsExactlyWhenNothingReachableIsUnknown) {
    for (std::uint64_t seed = kSeed; seed < kSeed + 5; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Exploring exploring(Strategy::Explore::exhaustive, seed);
        exploring.run(0.3);
        if (HasFatalFailure()) return;
        EXPECT_TRUE(exploring.probed().open_edges().empty());
        EXPECT_EQ(closed_and_open_wings(exploring).second, 0);
        exploring.probed().expect_valid();
        exploring.probed().expect_true();
    }
}

TEST(VoronoiWalk, ClosureAsksForLessThanExhaustive) {
    Exploring closure(Strategy::Explore::closure, kSeed);
    Exploring exhaustive(Strategy::Explore::exhaustive, kSeed);
    closure.run(0.3);
    exhaustive.run(0.3);
    EXPECT_LT(closure.probes(), exhaustive.probes());
}

TEST(VoronoiWalk, SurroundingsOfASampleAreProbedWhateverTheStrategy) {
    Exploring exploring(Strategy::Explore::closure, kSeed);
    MaintainedDelaunay& state = exploring.state();
    exploring.run(0.5);
    if (HasFatalFailure()) return;
    for (std::uint32_t sample = 0; sample < state.sample_count(); ++sample) {
        exploring.exploration().note_surroundings(sample);
        // Without insertions: the sample's Voronoi cell stays as it is, and each probe answers one of its edges or one that
        // closes a wing.
        exploring.run(1e9);
        if (HasFatalFailure()) return;
        for (const CellId cell : state.cells_around(sample)) {
            for (int i = 0; i < 4; ++i) {
                if (state.sample_of(cell, i) == sample || !state.is_reachable({cell, i})) continue;
                EXPECT_NE(state.state({cell, i}), EdgeState::unknown);
            }
        }
    }
}

}  // namespace
}  // namespace palpate::voronoi_walk_test
