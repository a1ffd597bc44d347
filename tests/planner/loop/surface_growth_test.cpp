#include "planner/loop/surface_growth.h"

#include <gtest/gtest.h>

#include <tuple>

#include "tests/planner/loop/growing.h"

namespace palpate::surface_growth_test {
namespace {

// Everything inferred that is in the state was inferred since then.
void expect_inferred_since(Growing& growing, std::size_t first) {
    growing.for_each_inferred([&](DirectedEdge e) {
        const Crossing& gap = growing.state().crossing(e);
        const bool is_new = std::any_of(growing.inferred.begin() + static_cast<std::ptrdiff_t>(first), growing.inferred.end(),
                                        [&](const Segment& s) { return s.source == gap.near && s.target == gap.far; });
        ASSERT_TRUE(is_new) << "it rests on a bound that was refuted";
    });
}

void expect_true_inferences(Growing& growing) {
    const Seeded& seeded = growing.seeded();
    growing.for_each_inferred([&](DirectedEdge e) {
        const Crossing& gap = growing.state().crossing(e);
        ASSERT_GE(seeded.torus.distance(gap.near), -seeded.rounding());
        ASSERT_LE(seeded.torus.distance(gap.far), seeded.rounding());
    });
}

TEST(SurfaceGrowth, WithATrueBoundClosesTheSurfaceAtHardlyMoreThanOneProbePerSample) {
    for (const auto& [torus, epsilon, most] : {std::tuple{Torus::sphere(1), 0.118, 1.15}, {Torus{1, 0.4}, 0.1, 1.25}}) {
        Growing growing(torus, epsilon);
        Seeded& seeded = growing.seeded();
        while (growing.step([](std::size_t /*before*/) { ADD_FAILURE() << "a true bound was refuted"; })) {
            seeded.expect_safe_moves();
            seeded.expect_true_account();
            if (HasFailure()) return;
        }
        EXPECT_FALSE(growing.growth().evidence().refuted);
        EXPECT_EQ(growing.growth().evidence().used, torus.reach());
        EXPECT_EQ(growing.growth().open_count(), 0U);
        const Topology topology = seeded.topology();
        EXPECT_TRUE(topology.is_closed_oriented_manifold());
        EXPECT_EQ(topology.euler_characteristic, torus.euler_characteristic());
        const auto samples = static_cast<double>(growing.state().sample_count());
        EXPECT_GT(samples, 400);
        EXPECT_LE(static_cast<double>(seeded.head.cost().probes()), most * samples);
        EXPECT_LE(seeded.head.cost().displacement(), 10 * epsilon * samples);
        expect_true_inferences(growing);
        std::string why;
        EXPECT_TRUE(seeded.space.is_valid(&why)) << why;
    }
}

TEST(SurfaceGrowth, AuditsCountWhatTheOracleSaw) {
    for (const double share : {0.1, 1.0}) {
        Growing growing(Torus::sphere(1), 0.15, [&](Options& options) { options.audit = share; });
        Seeded& seeded = growing.seeded();
        // A probe that met S in a gap that had been inferred: nothing but an audit does.
        std::size_t audits = 0;
        std::size_t seen = seeded.oracle.probes.size();
        while (growing.step() || growing.growth().begin_audit()) {
            const std::vector<Segment>& gaps = growing.inferred;
            for (; seen < seeded.oracle.probes.size(); ++seen) {
                const Segment& probe = seeded.oracle.probes[seen];
                audits += std::ranges::any_of(gaps, [&](const Segment& gap) {
                    return distance_to(gap, probe.target) < seeded.rounding() &&
                           distance_to({probe.source, probe.target}, gap.source) < seeded.rounding();
                });
            }
            ASSERT_EQ(growing.growth().evidence().audited, audits);
        }
        EXPECT_GT(audits, share < 1 ? 20U : 200U);
        EXPECT_LE(audits, Audit::kEnough);
        EXPECT_EQ(growing.growth().evidence().audit_barred, 0U);
        EXPECT_EQ(growing.growth().evidence().audited_wrong, 0U) << "the bound is true";
        EXPECT_TRUE(seeded.topology().is_closed_oriented_manifold());
    }
}

TEST(SurfaceGrowth, AFalseBoundIsLoweredAndNothingThatRestedOnItStays) {
    for (const auto& [torus, factor] :
         {std::pair{Torus::sphere(1), 2.0}, {Torus::sphere(1), 1.3}, {Torus{1, 0.4}, 2.0}, {Torus{1, 0.4}, 4.0}}) {
        SCOPED_TRACE("a bound of " + std::to_string(factor) + " times " + std::to_string(torus.reach()));
        Growing growing(torus, 0.15, [&, &t = torus, &f = factor](Options& options) { options.reach = f * t.reach(); });
        Seeded& seeded = growing.seeded();
        double used = factor * torus.reach();
        EXPECT_DOUBLE_EQ(growing.growth().evidence().used, used);
        int rounds = 0;
        double largest = std::numeric_limits<double>::infinity();
        while (growing.step([&](std::size_t before) {
            ++rounds;
            const ReachEvidence evidence = growing.growth().evidence();
            ASSERT_TRUE(evidence.refuted);
            ASSERT_FALSE(evidence.detail.empty());
            ASSERT_GE(evidence.largest, torus.reach() * (1 - 1e-6)) << "the touches allow the truth";
            ASSERT_LE(evidence.largest, largest) << "evidence gets no weaker";
            ASSERT_LE(evidence.used, 0.8 * used * (1 + 1e-12));
            ASSERT_LE(evidence.used, evidence.largest * (1 + 1e-9));
            used = evidence.used;
            largest = evidence.largest;
            expect_inferred_since(growing, before);
        })) {
            seeded.expect_safe_moves();
            seeded.expect_true_account();
            if (HasFatalFailure()) return;
        }
        EXPECT_GT(rounds, 0);
        EXPECT_LT(rounds, 20);
        if (used <= torus.reach()) expect_true_inferences(growing);
    }
}

// Any inferred crossing.
std::optional<DirectedEdge> some_inferred(Growing& growing) {
    std::optional<DirectedEdge> found;
    growing.for_each_inferred([&](DirectedEdge e) { found = e; });
    return found;
}

TEST(SurfaceGrowth, WhatIsDistrustedOpensTheSurfaceUntilATouchClosesIt) {
    Growing growing(Torus::sphere(1), 0.2);
    growing.run();
    ASSERT_TRUE(growing.seeded().topology().is_closed_oriented_manifold());
    for (int k = 0; k < 20; ++k) {
        const auto e = some_inferred(growing);
        ASSERT_TRUE(e);
        const auto facet = growing.state().facet_samples(*e);
        growing.growth().distrust(*e);
        EXPECT_EQ(growing.seeded().topology().boundary_edges, 3U);
        EXPECT_EQ(growing.growth().open_count(), 3U);
        EXPECT_FALSE(growing.growth().infer(*e)) << "only a touch can say now";
        growing.growth().sweep();
        EXPECT_FALSE(growing.state().crossed(*e));
        growing.run();
        const auto again = growing.state().find_facet(facet[0], facet[1], facet[2]);
        ASSERT_TRUE(again);
        const auto touched = growing.state().crossed(*again);
        ASSERT_TRUE(touched);
        const Crossing& crossing = growing.state().crossing(*touched);
        EXPECT_FALSE(crossing.inferred);
        EXPECT_EQ(crossing.near, growing.seeded().head.touches().back().position);
        EXPECT_TRUE(growing.seeded().topology().is_closed_oriented_manifold());
        growing.seeded().expect_safe_moves();
        growing.seeded().expect_true_account();
        if (HasFatalFailure()) return;
    }
    EXPECT_FALSE(growing.growth().evidence().refuted);
}

TEST(SurfaceGrowth, AnInferredCrossingThatIsNotThereRefutesTheBound) {
    Growing growing(Torus::sphere(1), 0.2);
    growing.run();
    const auto e = some_inferred(growing);
    ASSERT_TRUE(e);
    const Point free = growing.state().crossing(*e).far;
    const auto facet = growing.state().facet_samples(*e);
    growing.growth().withdraw(*e, free);
    EXPECT_FALSE(growing.state().crossed(*e));
    const std::size_t before = growing.inferred.size();
    ASSERT_TRUE(growing.growth().settle_refutation());
    EXPECT_FALSE(growing.growth().settle_refutation()) << "once";
    const ReachEvidence evidence = growing.growth().evidence();
    EXPECT_TRUE(evidence.refuted);
    EXPECT_EQ(evidence.largest, 1) << "all that is known is that this bound is false";
    EXPECT_DOUBLE_EQ(evidence.used, 0.8);
    expect_inferred_since(growing, before);
    EXPECT_GT(growing.inferred.size(), before) << "inferred anew";
    const auto again = growing.state().find_facet(facet[0], facet[1], facet[2]);
    ASSERT_TRUE(again);
    EXPECT_FALSE(growing.state().crossed(*again));
    growing.run();
    EXPECT_TRUE(growing.seeded().topology().is_closed_oriented_manifold());
}

TEST(SurfaceGrowth, BelowTwoEpsilonTheFrontIsLeftAlone) {
    Growing grows(Torus::sphere(1), 0.2, [](Options& options) { options.reach = 0.41; });
    EXPECT_TRUE(grows.growth().step());
    Growing rests(Torus::sphere(1), 0.2, [](Options& options) { options.reach = 0.39; });
    EXPECT_FALSE(rests.growth().step());
    Growing walks(Torus::sphere(1), 0.2, [](Options& options) { options.strategy.travel = Strategy::Travel::voronoi; });
    EXPECT_FALSE(walks.growth().step());
}

TEST(SurfaceGrowth, WhatIsPlausibleGrowsSafelyWithNothingKnown) {
    for (const auto& [torus, epsilon] : {std::pair{Torus::sphere(1), 0.16}, {Torus{1, 0.4}, 0.12}}) {
        Growing growing(torus, epsilon, [](Options& options) {
            options.strategy = Strategy::adaptive();
            options.reach.reset();
        });
        Seeded& seeded = growing.seeded();
        std::size_t steps = 0;
        while (growing.step()) {
            ASSERT_LT(++steps, 20'000U);
            seeded.expect_safe_moves();
            seeded.expect_true_account();
            if (HasFatalFailure()) return;
        }
        EXPECT_TRUE(growing.growth().evidence().is_plausible);
        EXPECT_FALSE(growing.growth().evidence().refuted) << "nobody gave a bound";
        const Topology topology = seeded.topology();
        EXPECT_TRUE(topology.is_closed_oriented_manifold());
        EXPECT_EQ(topology.euler_characteristic, torus.euler_characteristic());
        EXPECT_LT(seeded.head.cost().probes(), 1.5 * static_cast<double>(growing.state().sample_count()));
    }
}

}  // namespace
}  // namespace palpate::surface_growth_test
