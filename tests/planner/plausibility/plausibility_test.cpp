#include "planner/plausibility/plausibility.h"

#include <gtest/gtest.h>

#include <functional>

#include "planner/motion/probed_space.h"
#include "tests/planner/delaunay/explored_torus.h"

namespace palpate::plausibility_test {
namespace {

constexpr std::uint64_t kSeed = 20261205;
constexpr double kSpacing = 0.12;
constexpr double kTrusted = 0.96;

// A solid, with samples of its surface all over that were touched from sides up to 60° off its normals. No edge is probed.
struct Solid {
    std::function<bool(const Point&)> contains;
    std::vector<Point> samples;
    std::vector<Vector> normals;
};

Solid torus_of(Random& random) {
    const Torus torus;
    Solid solid{[torus](const Point& p) { return torus.distance(p) < 0; }, ExploredTorus::spread(torus, kSpacing, random), {}};
    for (const Point& p : solid.samples) solid.normals.push_back(torus.nearest(p).normal);
    return solid;
}

Solid cube_of(Random& random) {
    Solid cube{[](const Point& p) { return p.cwiseAbs().maxCoeff() < 1; }, {}, {}};
    for (int failed = 0; failed < 1000;) {
        Point p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const auto axis = static_cast<Eigen::Index>(random.below(3));
        p[axis] = random.chance(0.5) ? 1 : -1;
        const bool fits = std::ranges::all_of(cube.samples, [&](const Point& q) { return (p - q).norm() > kSpacing; });
        failed = fits ? 0 : failed + 1;
        if (!fits) continue;
        cube.samples.push_back(p);
        cube.normals.push_back(p[axis] * Vector::Unit(axis));
    }
    return cube;
}

struct Guessing {
    Solid solid;
    ProbedSpace space;
    MaintainedDelaunay& state;
    Plausibility plausibility;

    Guessing(Solid s, Random& random)
        : solid(std::move(s)),
          space(Region(Ball{Point::Zero(), 4})),
          state(space.delaunay()),
          plausibility((state.initialise(solid.samples), state), 1.1 * kSpacing, 1e-9) {
        for (std::uint32_t sample = 0; sample < state.sample_count(); ++sample) {
            Vector from = random.direction();
            while (from.dot(solid.normals[sample]) < 0.5) from = random.direction();
            plausibility.note_sample(sample, from);
        }
    }
};

class PlausibilityOf : public ::testing::TestWithParam<Solid (*)(Random&)> {};

TEST_P(PlausibilityOf, NormalsFollowNeighborsWhereverProbesCameFrom) {
    Random random(kSeed);
    Guessing guess(GetParam()(random), random);
    std::size_t near = 0;
    for (std::uint32_t sample = 0; sample < guess.state.sample_count(); ++sample) {
        const double cosine = guess.plausibility.normal(sample).dot(guess.solid.normals[sample]);
        EXPECT_NEAR(guess.plausibility.normal(sample).norm(), 1, 1e-9);
        EXPECT_GT(cosine, 0) << sample;
        near += cosine > std::cos(0.4);
    }
    // The others lie at edges of the cube. The torus is coarsely sampled: 0.6 of its reach.
    EXPECT_GT(static_cast<double>(near), 0.95 * static_cast<double>(guess.state.sample_count()));
}

TEST_P(PlausibilityOf, SidesAreRightTheMoreSoTheMorePlausible) {
    Random random(kSeed + 1);
    Guessing guess(GetParam()(random), random);
    std::array<std::size_t, 2> wrong{};
    std::array<std::size_t, 2> all{};
    guess.state.for_each_edge([&](DirectedEdge e) {
        if (e.facet != 0 || !guess.state.is_finite(e)) return;
        const auto along = guess.state.span(e);
        if (!along || along->starts_on_boundary) return;
        const Plausibility::Side side = guess.plausibility.side(e.cell, along->start_point());
        const std::size_t k = side.plausibility > 0.3;
        ++all[k];
        wrong[k] += side.is_outside == guess.solid.contains(along->start_point());
    });
    ASSERT_GT(all[1], 2 * guess.state.sample_count());
    EXPECT_LE(static_cast<double>(wrong[1]), 0.001 * static_cast<double>(all[1]));
    EXPECT_LE(static_cast<double>(wrong[0]), 0.3 * static_cast<double>(all[0])) << "samples on one circle, with the centre on S";
}

TEST_P(PlausibilityOf, CrossingsAreWhereSIsAndFewAreMissed) {
    Random random(kSeed + 2);
    Guessing guess(GetParam()(random), random);
    std::size_t crossed = 0;
    std::size_t inferred = 0;
    std::size_t wrong = 0;
    guess.plausibility.watch(
        [&](const Point& near, const Point& far) { wrong += guess.solid.contains(near) || !guess.solid.contains(far); });
    guess.state.for_each_edge([&](DirectedEdge e) {
        if (!guess.state.is_finite(e) || guess.state.neighbor(e) < e.cell) return;
        const auto along = guess.state.span(e);
        if (!along || along->line.circumradius > kSpacing) return;
        crossed += guess.solid.contains(along->start_point()) != guess.solid.contains(along->end_point());
        const auto view = guess.plausibility.view(e);
        const std::size_t wrong_before = wrong;
        const std::optional<DirectedEdge> found = guess.plausibility.infer(e, 1.1 * kSpacing);
        if (!found) return;
        if (view->confidence < kTrusted) wrong = wrong_before;  // it would be touched
        ++inferred;
        EXPECT_LE(guess.state.crossing(*found).ball_radius, 1.1 * kSpacing);
        guess.plausibility.distrust(*found);
        EXPECT_FALSE(guess.plausibility.infer(e, 1.1 * kSpacing)) << "never again";
    });
    EXPECT_GT(static_cast<double>(inferred), 0.8 * static_cast<double>(crossed));
    EXPECT_LE(static_cast<double>(wrong), 0.005 * static_cast<double>(inferred));
    std::cout << wrong << " of " << inferred << " wrong, " << crossed << " crossed\n";
}

TEST_P(PlausibilityOf, DoubtsAreHeard) {
    Random random(kSeed + 3);
    Guessing guess(GetParam()(random), random);
    const auto facets_at = [&](std::uint32_t sample) {
        std::size_t found = 0;
        for (const CellId cell : guess.state.cells_around(sample)) {
            for (int i = 0; i < 4; ++i) {
                const DirectedEdge e{cell, i};
                if (!guess.state.is_finite(e) || guess.state.sample_of(cell, i) == sample) continue;
                const auto view = guess.plausibility.view(e);
                found += view && view->is_crossed();
            }
        }
        return found;
    };
    for (int k = 0; k < 20; ++k) {
        const auto sample = static_cast<std::uint32_t>(random.below(guess.state.sample_count()));
        std::size_t before = facets_at(sample);
        EXPECT_GT(before, 2U);
        for (int doubts = 0; doubts < 16; ++doubts) {
            guess.plausibility.contradict(std::array{sample}, Point::Zero());
            EXPECT_EQ(guess.plausibility.take_doubted(), std::vector{sample});
            EXPECT_TRUE(guess.plausibility.take_doubted().empty());
            const std::size_t after = facets_at(sample);
            EXPECT_LE(after, before);
            before = after;
        }
        EXPECT_EQ(before, 0U) << "nothing is that plausible";
    }
}

TEST_P(PlausibilityOf, WhatIsTouchedIsNotFree) {
    Random random(kSeed + 4);
    Guessing guess(GetParam()(random), random);
    for (int k = 0; k < 100; ++k) {
        const auto sample = static_cast<std::uint32_t>(random.below(guess.state.sample_count()));
        const Point touched = guess.state.sample(sample) + random.uniform(0.1, 2) * kSpacing * guess.plausibility.normal(sample);
        const bool was_free = guess.plausibility.clearance(sample).contains(touched);
        guess.plausibility.check(touched, false, std::array{sample});
        EXPECT_EQ(guess.plausibility.clearance(sample).contains(touched), was_free) << "nothing was touched";
        guess.plausibility.check(touched, true, std::array{sample});
        EXPECT_FALSE(guess.plausibility.clearance(sample).contains(touched));
        EXPECT_TRUE(guess.plausibility.has_clearance(sample));
    }
}

INSTANTIATE_TEST_SUITE_P(Solids, PlausibilityOf, ::testing::Values(&torus_of, &cube_of),
                         [](const auto& solid) { return solid.index == 0 ? "Torus" : "Cube"; });

}  // namespace
}  // namespace palpate::plausibility_test
