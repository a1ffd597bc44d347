#include "planner/loop/earlier_touches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "planner/errors.h"
#include "tests/planner/support.h"

namespace palpate::earlier_touches_test {
namespace {

using Found = EarlierTouches::Found;

constexpr double kEpsilon = 0.5;
const Ball kBall{Point::Zero(), 2.0};

// A ball in a ball, touched by an earlier run at `count` places, from 1 mm above each.
struct Bench {
    Region workspace{Ball{Point::Zero(), 4.0}};
    Options options;
    SolidOracle oracle{Solid{}.add(kBall), Point(0, 0, 10)};
    ProbedSpace space{Surroundings(workspace)};
    ProbeHead head{oracle, space.delaunay().surroundings(), space.roadmap()};

    explicit Bench(std::size_t count) {
        options.epsilon = kEpsilon;
        Random random(7);
        for (std::size_t k = 0; k < count; ++k) add(random.direction(), true);
    }
    void add(const Vector& direction, bool is_sample) {
        options.earlier.push_back({kBall.radius * direction, (kBall.radius + 1) * direction, is_sample});
    }
    // The ball's.
    [[nodiscard]] Vector normal(std::uint32_t sample) const { return space.delaunay().sample(sample).normalized(); }
    [[nodiscard]] std::optional<EarlierTouches::Place> next(EarlierTouches& touches) const {
        return touches.next([this](std::uint32_t sample) { return normal(sample); });
    }
    // The first place is where it was.
    void find_first(EarlierTouches& touches) const {
        const auto first = next(touches);
        ASSERT_TRUE(first);
        touches.note(*first, Found{first->at});
    }
    [[nodiscard]] EarlierTouches earlier(double touch_error = 0) { return {options, touch_error, Criteria(options), space, head}; }
};

TEST(EarlierTouches, SamplesAreSamplesAgainAndNothingMoves) {
    Bench bench(100);
    const Point start = bench.oracle.position();
    const EarlierTouches earlier = bench.earlier();
    EXPECT_EQ(bench.space.delaunay().sample_count(), 100U);
    EXPECT_TRUE(earlier.others().empty());
    EXPECT_EQ(earlier.evidence().touches, 100U);
    EXPECT_EQ(earlier.evidence().samples, 100U);
    for (std::uint32_t k = 0; k < 100; ++k) {
        EXPECT_EQ(bench.space.delaunay().sample(k), bench.options.earlier[k].position);
        EXPECT_EQ(bench.head.touches()[k].sample, k);
        EXPECT_EQ(bench.head.touches()[k].role, Touch::Role::earlier);
        EXPECT_EQ(bench.head.touches()[k].from, bench.options.earlier[k].from);
    }
    EXPECT_EQ(bench.head.cost().probes(), 0U);
    EXPECT_EQ(bench.oracle.position(), start);
    std::string why;
    EXPECT_TRUE(bench.space.is_valid(&why)) << why;
}

TEST(EarlierTouches, OtherTouchesBecomeSamplesOnlyWhereSamplesAreFar) {
    Bench bench(6);
    const std::size_t before = bench.options.earlier.size();
    Random random(8);
    for (int k = 0; k < 300; ++k) bench.add(random.direction(), false);
    // Given first, they are looked at after the samples all the same.
    std::ranges::rotate(bench.options.earlier, bench.options.earlier.begin() + static_cast<std::ptrdiff_t>(before));
    const EarlierTouches earlier = bench.earlier();
    const MaintainedDelaunay& state = bench.space.delaunay();
    EXPECT_EQ(earlier.others().size() + state.sample_count(), 306U);
    EXPECT_GT(state.sample_count(), 40U);
    for (std::uint32_t k = 6; k < state.sample_count(); ++k) {
        for (std::uint32_t i = 0; i < k; ++i) ASSERT_GT((state.sample(k) - state.sample(i)).norm(), kEpsilon * (1 - 2 * kSeedSpacing));
    }
    for (const EarlierTouches::Other& other : earlier.others()) {
        ASSERT_LE((state.sample(state.nearest_sample(other.position, state.cell_at(0))) - other.position).norm(), kEpsilon);
    }
    EXPECT_EQ(bench.head.touches().size(), 306U) << "none is lost";
}

TEST(EarlierTouches, ATouchOnADualEdgeIsItsCrossing) {
    Bench bench(200);
    // The centres of surface Delaunay balls, by an own triangulation.
    Bench first(200);
    (void)first.earlier();
    const MaintainedDelaunay& state = first.space.delaunay();
    std::size_t wanted = 0;
    for (CellId cell = 0; cell < state.cell_slots() && wanted < 50; ++cell) {
        for (int i = 0; i < 4; ++i) {
            const DirectedEdge e{cell, i};
            if (!state.is_live(cell) || !state.is_finite(e)) continue;
            const auto span = state.span(e);
            if (!span || span->start_point().norm() < kBall.radius || span->end_point().norm() > kBall.radius) continue;
            const Vector way = (span->end_point() - span->start_point()).normalized();
            const auto piece = Region(kBall).clip(span->start_point(), way);
            ASSERT_TRUE(piece);
            const Point met = span->start_point() + piece->low * way;
            bench.options.earlier.push_back({met, met - way, false});
            ++wanted;
        }
    }
    ASSERT_GE(wanted, 50U);
    (void)bench.earlier();
    std::size_t found = 0;
    bench.space.delaunay().for_each_edge([&](DirectedEdge e) {
        if (bench.space.delaunay().recorded_state(e) != EdgeState::crossing) return;
        ++found;
        const Crossing& c = bench.space.delaunay().crossing(e);
        EXPECT_FALSE(c.inferred);
        EXPECT_NEAR(c.near.norm(), kBall.radius, 1e-9);
        EXPECT_LT(c.touch, bench.head.touches().size());
        EXPECT_EQ(bench.head.touches()[c.touch].position, c.near);
    });
    // Some lie farther than epsilon from samples, and are samples themselves.
    EXPECT_GE(found + bench.space.delaunay().sample_count() - 200, wanted * 9 / 10);
    EXPECT_GT(found, wanted / 2);
    std::string why;
    EXPECT_TRUE(bench.space.is_valid(&why)) << why;
}

TEST(EarlierTouches, ThreePlacesShowEveryShift) {
    Bench bench(300);
    EarlierTouches earlier = bench.earlier(1e-4);
    EXPECT_DOUBLE_EQ(earlier.evidence().limit, 0.01 * kEpsilon);
    std::vector<Vector> sides;
    while (const auto place = bench.next(earlier)) {
        sides.push_back(place->normal);
        EXPECT_EQ(bench.space.delaunay().sample(place->sample), place->at);
        earlier.note(*place, Found{Point(place->at + 1e-4 * place->outwards)});
    }
    ASSERT_EQ(sides.size(), 3U);
    EXPECT_GT(std::abs(sides[0].cross(sides[1]).dot(sides[2])), 0.9) << "as good as at right angles";
    EXPECT_EQ(earlier.evidence().checked, 3U);
    EXPECT_EQ(earlier.evidence().directions, 3);
    EXPECT_NEAR(earlier.evidence().worst, 1e-4, 1e-12);
}

TEST(EarlierTouches, TheLimitIsWhatDoesNoHarm) {
    Bench bench(300);
    bench.options.tolerance = 0.004;
    EXPECT_DOUBLE_EQ(bench.earlier().evidence().limit, 0.002);
    Bench noisy(300);
    noisy.options.tolerance = 0.004;
    EXPECT_DOUBLE_EQ(noisy.earlier(0.001).evidence().limit, 0.005);
    Bench told(300);
    told.options.earlier_limit = 0.3;
    EXPECT_DOUBLE_EQ(told.earlier(0.001).evidence().limit, 0.3);
}

TEST(EarlierTouches, ATouchWithoutAWayIsKeptAndIsNoSample) {
    Bench bench(50);
    bench.options.earlier.push_back({Point(0, 0, 2), Point(0, 0, 2), true});
    const EarlierTouches earlier = bench.earlier();
    EXPECT_EQ(earlier.evidence().touches, 51U);
    EXPECT_EQ(earlier.evidence().samples, 50U);
    EXPECT_EQ(bench.head.touches().size(), 51U);
    std::string why;
    EXPECT_TRUE(bench.space.is_valid(&why)) << why;
}

TEST(EarlierTouches, WhatIsMetElsewhereHasMoved) {
    Bench bench(300);
    EarlierTouches earlier = bench.earlier();
    const auto place = bench.next(earlier);
    ASSERT_TRUE(place);
    try {
        earlier.note(*place, Found{Point(place->at - 0.006 * place->outwards)});
        FAIL() << "it is 0.006 mm off, and 0.005 mm are allowed";
    } catch (const ContradictionError& error) {
        EXPECT_THAT(error.what(), ::testing::HasSubstr("0.006 mm off, more than 0.005 mm"));
    }
}

TEST(EarlierTouches, WithoutAWayToThemItDoesNotBegin) {
    Bench bench(300);
    EarlierTouches earlier = bench.earlier();
    int tries = 0;
    EXPECT_THROW(
        {
            while (const auto place = bench.next(earlier)) {
                ++tries;
                earlier.note(*place, Found{{}, place->at, false});
            }
        },
        SeedError);
    EXPECT_EQ(tries, 12);
}

TEST(EarlierTouches, WhereNothingIsMetItHasMoved) {
    Bench bench(300);
    EarlierTouches earlier = bench.earlier();
    const auto place = bench.next(earlier);
    ASSERT_TRUE(place);
    EXPECT_THROW(earlier.note(*place, Found{}), ContradictionError);
}

// No way leads to places that would show a shift across.
TEST(EarlierTouches, AShiftThatNoPlaceShowsIsSaid) {
    Bench bench(300);
    EarlierTouches earlier = bench.earlier();
    bench.find_first(earlier);
    while (const auto place = bench.next(earlier)) earlier.note(*place, Found{{}, {}, true});
    EXPECT_EQ(earlier.evidence().directions, 1);
}

// Something stands in the way that the earlier run would have touched.
TEST(EarlierTouches, WhatIsNewInTheWayIsNoBarrier) {
    Bench bench(300);
    EarlierTouches earlier = bench.earlier();
    bench.find_first(earlier);
    EXPECT_THROW(
        {
            while (const auto place = bench.next(earlier))
                earlier.note(*place, Found{{}, Point(place->at + kEpsilon * 2 * place->outwards), false});
        },
        ContradictionError);
}

// Their normals are alike: what is seen from many sides shows no more for that.
TEST(EarlierTouches, OnAPlaneOnlyOneDirectionShows) {
    Bench bench(0);
    Random random(3);
    for (int k = 0; k < 60; ++k) {
        const Point p(std::cos(k), std::sin(k), k == 0 ? 0.01 : 0);
        bench.options.earlier.push_back({p, p + random.direction() + Vector(0, 0, 1.5), true});
    }
    EarlierTouches earlier = bench.earlier();
    const auto up = [](std::uint32_t) { return Vector(0, 0, 1); };
    const auto first = earlier.next(up);
    ASSERT_TRUE(first);
    earlier.note(*first, Found{first->at});
    EXPECT_FALSE(earlier.next(up));
}

TEST(EarlierTouches, WhatSpansNoVolumeIsNoBeginning) {
    for (const std::size_t count : {0U, 3U}) {
        Bench bench(count);
        EXPECT_THROW((void)bench.earlier(), SeedError) << count;
    }
    Bench flat(0);
    for (int k = 0; k < 20; ++k) flat.add(Vector(std::cos(0.3 * k), std::sin(0.3 * k), 0), true);
    EXPECT_THROW((void)flat.earlier(), SeedError);
}

}  // namespace
}  // namespace palpate::earlier_touches_test
