#include "sim/machines/virtual_tool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "sim/objects/hidden_object.h"
#include "tests/sim/support.h"

namespace palpate::virtual_tool_test {
namespace {

using Guard = VirtualTool::Guard;

class VirtualToolTest : public testing::Test {
protected:
    VirtualToolTest() { options.start = Point(20, 0, 0); }

    HiddenObject ball{ShapeSpec{SphereSpec{10.0}}};
    VirtualToolOptions options;
};

TEST_F(VirtualToolTest, TakesTheTimeOfATrapezoid) {
    VirtualTool tool(ball, options);
    tool.start_move({20, 30, 0}, 10, Guard::until_contact);
    tool.advance(Seconds(1.0));
    EXPECT_TRUE(tool.is_moving());
    EXPECT_NEAR(tool.position().y(), 10 * 1.0 - 100.0 / 400, 1e-3);
    EXPECT_NEAR(tool.speed_mm_per_s(), 10, 1e-9);
    const Seconds rest = tool.finish();
    EXPECT_NEAR(1.0 + rest.count(), move_duration(options.motion, 30, 10).count(), 1e-9);
    EXPECT_EQ(tool.position(), Point(20, 30, 0));
    EXPECT_FALSE(tool.trigger());
}

TEST_F(VirtualToolTest, RunsOnPastTheTriggerByTheStoppingDistance) {
    VirtualTool tool(ball, options);
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    tool.finish();
    ASSERT_TRUE(tool.trigger());
    EXPECT_EQ(*tool.trigger(), Point(10, 0, 0));
    EXPECT_NEAR(tool.position().x(), 10 - stopping_distance(options.motion, 10), 1e-3);
    EXPECT_TRUE(tool.is_probe_closed());
    EXPECT_NEAR(tool.audit().deepest_mm, stopping_distance(options.motion, 10), 1e-3);
    EXPECT_EQ(tool.audit().unsafe_moves, 0U);
    EXPECT_EQ(tool.audit().unguarded_moves, 0U);
}

TEST_F(VirtualToolTest, OpensOnTheWayOutWhereItLeavesTheSolid) {
    VirtualTool tool(ball, options);
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    tool.finish();
    tool.start_move({20, 0, 0}, 10, Guard::until_release);
    tool.finish();
    ASSERT_TRUE(tool.trigger());
    EXPECT_EQ(*tool.trigger(), Point(10, 0, 0));
    EXPECT_GT(tool.position().x(), 10);
    EXPECT_FALSE(tool.is_probe_closed());
    EXPECT_EQ(tool.audit().unsafe_moves, 0U) << "coming out is safe";
}

TEST_F(VirtualToolTest, AMoveThatIsClosedAtItsStartStopsAtOnce) {
    VirtualTool tool(ball, options);
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    tool.finish();
    const Point rest = tool.position();
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    tool.finish();
    EXPECT_EQ(tool.trigger(), rest);
    EXPECT_LT((tool.position() - rest).norm(), 0.01);
}

TEST_F(VirtualToolTest, TheTriggerIsTheFirstHitEverywhere) {
    constexpr std::uint64_t kSeed = 5;
    SCOPED_TRACE(seed_text(kSeed));
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name);
        const HiddenObject object(spec);
        Random random(kSeed);
        int contacts = 0;
        for (int i = 0; i < 300; ++i) {
            VirtualToolOptions place = options;
            place.origin = Point(3, -1, 7);
            place.motion.resolution_mm = 1e-6;
            const Segment way{random.around(object.bounds(), 0.5), random.around(object.bounds(), 0.1)};
            if (object.contains(way.source)) continue;
            place.start = way.source + place.origin;
            VirtualTool tool(object, place);
            tool.start_move(way.target + place.origin, random.uniform(0.1, 5), Guard::until_contact);
            tool.finish();
            const auto hit = object.first_hit(way);
            ASSERT_EQ(hit.has_value(), tool.trigger().has_value());
            if (!hit) continue;
            ++contacts;
            EXPECT_LT((*hit + place.origin - *tool.trigger()).norm(), 2e-6);
        }
        EXPECT_GT(contacts, 5);
    }
}

TEST_F(VirtualToolTest, SmallStepsOfTimeAndOneLargeStepAreTheSame) {
    VirtualTool one(ball, options);
    VirtualTool many(ball, options);
    one.start_move(Point(0, 3, 0), 8, Guard::until_contact);
    many.start_move(Point(0, 3, 0), 8, Guard::until_contact);
    one.advance(Seconds(10.0));
    for (int i = 0; i < 10000; ++i) many.advance(Seconds(0.001));
    EXPECT_EQ(one.position(), many.position());
    EXPECT_EQ(one.trigger(), many.trigger());
    EXPECT_EQ(one.audit().deepest_mm, many.audit().deepest_mm);
}

TEST_F(VirtualToolTest, HoldingSlowsDownAndKeepsThePosition) {
    VirtualTool tool(ball, options);
    tool.start_move({20, 30, 0}, 10, Guard::until_contact);
    tool.advance(Seconds(1.0));
    const Point before = tool.position();
    tool.decelerate();
    tool.finish();
    EXPECT_NEAR((tool.position() - before).norm(), 100.0 / 400, 2e-3);
    EXPECT_LT((tool.true_position() - tool.position()).norm(), 1e-3);
}

TEST_F(VirtualToolTest, AnAbortedMoveLosesThePositionUntilItIsPlaced) {
    VirtualTool tool(ball, options);
    tool.start_move({20, 30, 0}, 10, Guard::until_contact);
    tool.advance(Seconds(1.0));
    const Point counted = tool.position();
    tool.abort();
    EXPECT_FALSE(tool.is_moving());
    EXPECT_EQ(tool.position(), counted);
    EXPECT_NEAR(tool.true_position().y() - counted.y(), 100.0 / 400, 2e-3);
    tool.start_move({20, 30, 0}, 10, Guard::until_contact);
    tool.finish();
    EXPECT_EQ(tool.position(), Point(20, 30, 0));
    EXPECT_NEAR(tool.true_position().y(), 30.25, 2e-3);
    tool.place({20, 0, 0});
    EXPECT_EQ(tool.true_position(), Point(20, 0, 0));
}

TEST_F(VirtualToolTest, UnsafeMovesAreCounted) {
    const auto unsafe_after = [&](const Point& target, Guard guard, double feed, double overtravel) {
        VirtualToolOptions changed = options;
        changed.motion.overtravel_mm = overtravel;
        VirtualTool tool(ball, changed);
        tool.start_move(target, feed, guard);
        tool.finish();
        return tool.audit().unsafe_moves;
    };
    EXPECT_EQ(unsafe_after({15, 0, 0}, Guard::none, 10, 2), 0U) << "ends outside";
    EXPECT_EQ(unsafe_after({9, 0, 0}, Guard::none, 10, 2), 1U) << "enters unguarded, however little";
    EXPECT_EQ(unsafe_after({-20, 0, 0}, Guard::none, 10, 2), 1U) << "through";
    EXPECT_EQ(unsafe_after({-20, 0, 0}, Guard::until_contact, 10, 2), 0U);
    EXPECT_EQ(unsafe_after({-20, 0, 0}, Guard::until_contact, 60, 2), 1U) << "60²/400 mm are too fast for 2 mm";
    EXPECT_EQ(unsafe_after({-20, 0, 0}, Guard::until_contact, 10, 0.1), 1U);
    EXPECT_EQ(unsafe_after({20, 20, 0}, Guard::until_contact, 10, 0.1), 0U);
}

TEST_F(VirtualToolTest, AfterATouchOnlyGoingDeeperUnguardedIsUnsafe) {
    VirtualTool tool(ball, options);
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    tool.finish();
    tool.start_move({20, 0, 0}, 10, Guard::none);
    tool.finish();
    EXPECT_EQ(tool.audit().unsafe_moves, 0U);
    EXPECT_EQ(tool.audit().unguarded_moves, 1U);
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    tool.finish();
    tool.start_move({9, 0, 0}, 10, Guard::none);
    tool.finish();
    EXPECT_EQ(tool.audit().unsafe_moves, 1U);
    tool.start_move({-20, 0, 0}, 10, Guard::until_release);
    tool.finish();
    EXPECT_EQ(tool.audit().unsafe_moves, 2U) << "out at the other side";
}

TEST_F(VirtualToolTest, MovesThatLeaveTheLimitsAreCounted) {
    options.limits = {Point(-30, -30, -30), Point(30, 30, 30)};
    VirtualTool tool(ball, options);
    tool.start_move({30, 0, 0}, 10, Guard::until_contact);
    tool.finish();
    EXPECT_EQ(tool.audit().outside_limits, 0U);
    tool.start_move({30.1, 0, 0}, 10, Guard::until_contact);
    tool.finish();
    EXPECT_EQ(tool.audit().outside_limits, 1U);
    EXPECT_EQ(tool.audit().moves, 2U);
    EXPECT_NEAR(tool.audit().distance_mm, 10.1, 1e-9);
}

TEST_F(VirtualToolTest, FaultsOfTheProbe) {
    VirtualTool spurious(ball, options);
    spurious.start_move({20, 30, 0}, 10, Guard::until_contact);
    spurious.advance(Seconds(1.0));
    spurious.trigger_spuriously();
    spurious.finish();
    ASSERT_TRUE(spurious.trigger());
    EXPECT_NEAR(spurious.trigger()->y(), 9.75, 1e-3);
    EXPECT_FALSE(spurious.is_probe_closed());

    VirtualTool missing(ball, options);
    missing.miss_next_trigger();
    missing.start_move({8, 0, 0}, 10, Guard::until_contact);
    missing.finish();
    EXPECT_FALSE(missing.trigger());
    EXPECT_FALSE(missing.is_probe_closed());
    missing.start_move({20, 0, 0}, 10, Guard::none);
    missing.finish();
    missing.start_move({8, 0, 0}, 10, Guard::until_contact);
    missing.finish();
    EXPECT_TRUE(missing.trigger()) << "only the next one is missed";

    VirtualTool cut(ball, options);
    cut.set_unplugged(true);
    cut.start_move({0, 0, 0}, 10, Guard::until_contact);
    cut.finish();
    EXPECT_FALSE(cut.trigger());
    EXPECT_EQ(cut.audit().unsafe_moves, 1U);
}

TEST_F(VirtualToolTest, AProbeThatIsHeldByHandIsClosedWhereverTheToolIs) {
    VirtualTool tool(ball, options);
    tool.press(true);
    EXPECT_TRUE(tool.is_probe_closed());
    tool.start_move({20, 30, 0}, 10, Guard::until_contact);
    tool.finish();
    ASSERT_TRUE(tool.trigger());
    EXPECT_EQ(*tool.trigger(), Point(20, 0, 0)) << "it was closed at once";
    tool.press(false);
    EXPECT_FALSE(tool.is_probe_closed());
    tool.start_move({20, 30, 0}, 10, Guard::until_contact);
    tool.advance(Seconds(1.0));
    tool.press(true);
    tool.finish();
    ASSERT_TRUE(tool.trigger());
    EXPECT_NEAR(tool.trigger()->y(), 9.75, 0.01);
    tool.start_move(Point::Zero(), 10, Guard::until_release);
    tool.advance(Seconds(0.1));
    tool.press(false);
    tool.finish();
    EXPECT_TRUE(tool.trigger()) << "letting go is a release";
}

TEST_F(VirtualToolTest, TheSameShareOfTouchesIsMissedForTheSameSeed) {
    constexpr int kTouches = 1000;
    constexpr double kShare = 0.2;
    const auto misses = [&](std::uint64_t seed) {
        VirtualTool tool(ball, options);
        tool.set_miss_share(kShare, seed);
        std::string seen;
        for (int i = 0; i < kTouches; ++i) {
            tool.start_move({9.5, 0, 0}, 50, Guard::until_contact);
            tool.finish();
            seen += tool.trigger() ? 't' : 'm';
            tool.start_move({12, 0, 0}, 50, Guard::none);
            tool.finish();
        }
        return seen;
    };
    const std::string first = misses(3);
    EXPECT_NEAR(static_cast<double>(std::ranges::count(first, 'm')), kShare * kTouches, 5 * std::sqrt(kShare * (1 - kShare) * kTouches));
    EXPECT_EQ(misses(3), first);
    EXPECT_NE(misses(4), first);
}

TEST_F(VirtualToolTest, ANoisyProbeClosesBesideTheSurfaceAnewAtEveryApproach) {
    constexpr double kNoise = 0.05;
    constexpr int kTouches = 1000;
    options.touch_noise_mm = kNoise;
    options.motion.resolution_mm = 1e-6;
    const auto touches = [&](std::uint64_t seed) {
        options.touch_noise_seed = seed;
        VirtualTool tool(ball, options);
        std::vector<double> off;
        for (int i = 0; i < kTouches; ++i) {
            tool.start_move(Point::Zero(), 10, Guard::until_contact);
            tool.finish();
            off.push_back(10 - tool.trigger().value_or(Point::Zero()).x());
            EXPECT_NEAR(10 - tool.position().x(), off.back() + stopping_distance(options.motion, 10), 1e-5) << "stops from there";
            tool.start_move({12, 0, 0}, 10, Guard::until_release);
            tool.finish();
            EXPECT_EQ(tool.trigger(), Point(10, 0, 0)) << "opens where the surface is";
            tool.start_move({12, 0, 0}, 10, Guard::none);
            tool.finish();
        }
        EXPECT_EQ(tool.audit().unsafe_moves, 0U);
        return off;
    };
    const std::vector<double> first = touches(3);
    const auto [least, most] = std::ranges::minmax(first);
    EXPECT_GE(least, -kNoise - 1e-6);
    EXPECT_LE(most, kNoise + 1e-6);
    EXPECT_LT(least, -0.98 * kNoise);
    EXPECT_GT(most, 0.98 * kNoise);
    EXPECT_NEAR(std::accumulate(first.begin(), first.end(), 0.0) / kTouches, 0, 5 * kNoise / std::sqrt(3.0 * kTouches));
    EXPECT_EQ(touches(3), first);
    EXPECT_NE(touches(4), first);
}

TEST_F(VirtualToolTest, ANoisyProbeThatClosedBeforeTheSurfaceOpensAsItMovesAway) {
    options.touch_noise_mm = 0.05;
    VirtualTool tool(ball, options);
    double before = 0;
    for (int i = 0; i < 100 && before < 0.02; ++i) {
        tool.place({10.5, 0, 0});
        tool.start_move(Point::Zero(), 1, Guard::until_contact);
        tool.finish();
        before = tool.position().x() - 10;
    }
    ASSERT_GE(before, 0.02);
    EXPECT_TRUE(tool.is_probe_closed());
    EXPECT_EQ(tool.audit().deepest_end_mm, 0.0) << "it is still outside";
    const Point rest = tool.position();
    tool.start_move({12, 0, 0}, 1, Guard::until_release);
    tool.finish();
    EXPECT_EQ(tool.trigger(), rest);
    EXPECT_FALSE(tool.is_probe_closed());
}

// Only touches are off: what leads out of the solid, or is not guarded, passes the surface where it is.
TEST_F(VirtualToolTest, ANoisyProbeTouchesGrazesAndTargetsNearTheSurface) {
    options.touch_noise_mm = 0.05;
    options.motion.resolution_mm = 1e-6;
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        options.touch_noise_seed = seed;
        VirtualTool ends(ball, options);
        ends.start_move({9.999, 0, 0}, 1, Guard::until_contact);
        ends.finish();
        ASSERT_TRUE(ends.trigger()) << "at the target at the latest";
        EXPECT_GE(ends.trigger()->x(), 9.999);
        VirtualTool grazes(ball, options);
        grazes.place({20, 9.99999, 0});
        grazes.start_move({-20, 9.99999, 0}, 1, Guard::until_contact);
        grazes.finish();
        ASSERT_TRUE(grazes.trigger());
        EXPECT_NEAR(grazes.trigger()->x(), 0, 0.07);
        VirtualTool unguarded(ball, options);
        unguarded.start_move({9.9, 0, 0}, 1, Guard::none);
        unguarded.finish();
        EXPECT_TRUE(unguarded.is_probe_closed());
        EXPECT_NEAR(unguarded.audit().deepest_end_mm, 0.1, 1e-6);
    }
}

TEST_F(VirtualToolTest, FastMovesInsideAreCountedWhateverTheirGuard) {
    options.probe_feed_mm_per_s = 5;
    VirtualTool tool(ball, options);
    const auto fast_after = [&](const Point& target, double feed) {
        tool.start_move(target, feed, Guard::until_contact);
        tool.finish();
        return tool.audit().fast_moves_inside;
    };
    EXPECT_EQ(fast_after(Point::Zero(), 20), 0U) << "it stopped within the overtravel";
    tool.place({20, 0, 0});
    tool.set_unplugged(true);
    EXPECT_EQ(fast_after({8.5, 0, 0}, 20), 0U);
    EXPECT_EQ(fast_after({7, 0, 0}, 5.004), 0U) << "deep, but no faster than probing may be";
    EXPECT_EQ(tool.audit().unsafe_moves, 1U);
    EXPECT_NEAR(tool.audit().deepest_end_mm, 3, 1e-9);
    EXPECT_EQ(fast_after({20, 0, 0}, 5.01), 1U) << "out of the depth";
    EXPECT_EQ(fast_after({-20, 0, 0}, 20), 2U) << "through it";
    EXPECT_NEAR(tool.audit().deepest_end_mm, 3, 1e-9) << "it ended outside";
    EXPECT_NEAR(tool.audit().deepest_mm, 10, 0.2);
}

TEST_F(VirtualToolTest, WithoutAProbeFeedNoMoveIsFast) {
    VirtualTool tool(ball, options);
    tool.set_unplugged(true);
    tool.start_move({-20, 0, 0}, 50, Guard::until_contact);
    tool.finish();
    EXPECT_EQ(tool.audit().fast_moves_inside, 0U);
}

TEST_F(VirtualToolTest, ABouncingProbeOpensAndClosesAroundATouch) {
    VirtualTool tool(ball, options);
    tool.bounce(3);
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    while (!tool.trigger()) tool.advance(Seconds(0.001));
    int changes = 0;
    bool last = true;
    for (int i = 0; i < 200; ++i) {
        tool.advance(Seconds(0.001));
        changes += tool.is_probe_closed() != last ? 1 : 0;
        last = tool.is_probe_closed();
    }
    EXPECT_EQ(changes, 6);
    EXPECT_TRUE(last);
    EXPECT_EQ(*tool.trigger(), Point(10, 0, 0));
}

TEST_F(VirtualToolTest, JumpingFromEventToEventEndsEveryMove) {
    VirtualTool tool(ball, options);
    EXPECT_FALSE(tool.time_to_event());
    tool.start_move(Point::Zero(), 10, Guard::until_contact);
    int events = 0;
    for (auto next = tool.time_to_event(); next && events < 100; next = tool.time_to_event(), ++events) tool.advance(*next);
    EXPECT_LT(events, 10);
    EXPECT_FALSE(tool.is_moving());
    EXPECT_EQ(*tool.trigger(), Point(10, 0, 0));
}

TEST_F(VirtualToolTest, AFeedThatChangesInMidMoveChangesTheSpeedNotTheWay) {
    for (const double feed : {2.0, 10.0, 40.0}) {
        SCOPED_TRACE(feed);
        VirtualTool tool(ball, options);
        tool.start_move({20, 30, 0}, 10, Guard::until_contact);
        tool.advance(Seconds(1.0));
        const double way = tool.position().y();
        tool.change_feed(feed);
        tool.advance(Seconds(0.01));
        EXPECT_LT(std::abs(tool.speed_mm_per_s() - 10), 200 * 0.01 + 1e-9) << "no harder than it can";
        EXPECT_NEAR(tool.position().y(), way + 0.1, 0.012);
        tool.advance(Seconds(0.2));
        EXPECT_NEAR(tool.speed_mm_per_s(), feed, 1e-9);
        tool.change_feed(10);
        tool.finish();
        EXPECT_EQ(tool.position(), Point(20, 30, 0));
        EXPECT_NEAR(tool.audit().distance_mm, 30, 1e-9);
    }
}

// Near the end, while it slows down, and on its way to a stop.
TEST_F(VirtualToolTest, AFeedThatChangesAtAnyMomentNeverLeadsPastTheTarget) {
    for (double moment = 0.0; moment < 3.2; moment += 0.01) {
        SCOPED_TRACE(moment);
        VirtualTool tool(ball, options);
        tool.start_move({20, 30, 0}, 10, Guard::until_contact);
        tool.advance(Seconds(moment));
        tool.change_feed(20);
        tool.advance(Seconds(0.013));
        tool.change_feed(7);
        tool.finish();
        EXPECT_NEAR((tool.true_position() - Point(20, 30, 0)).norm(), 0, 1e-9);
        EXPECT_LT((tool.true_position() - tool.position()).norm(), 1e-3);
    }
    VirtualTool stopping(ball, options);
    stopping.start_move({20, 30, 0}, 10, Guard::until_contact);
    stopping.advance(Seconds(1.0));
    stopping.decelerate();
    stopping.change_feed(40);
    stopping.finish();
    EXPECT_NEAR(stopping.position().y(), 9.75 + 100.0 / 400, 2e-3);
}

TEST_F(VirtualToolTest, ATouchIsWhereTheSurfaceIsWhateverTheFeedDid) {
    for (double moment = 0.0; moment < 1.2; moment += 0.05) {
        VirtualTool tool(ball, options);
        tool.start_move(Point::Zero(), 10, Guard::until_contact);
        tool.advance(Seconds(moment));
        tool.change_feed(20);
        tool.finish();
        ASSERT_TRUE(tool.trigger());
        EXPECT_EQ(*tool.trigger(), Point(10, 0, 0));
        EXPECT_LT(tool.audit().deepest_mm, stopping_distance(options.motion, 20) + 1e-3);
    }
}

}  // namespace
}  // namespace palpate::virtual_tool_test
