#include "sim/probe/axis_play.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/random.h"

namespace palpate::axis_play_test {
namespace {

const Vector kBacklash(0.03, 0.02, 0.01);

TEST(AxisPlay, AnAxisThatGoesOnHasWhatItHad) {
    const auto up = play_along({1, 2, 3}, Vector::Zero(), kBacklash);
    ASSERT_EQ(up.size(), 2U);
    EXPECT_EQ(up.back().play, Vector::Zero());
    EXPECT_EQ(play_along({-1, -2, -3}, kBacklash, kBacklash).back().play, kBacklash);
    EXPECT_EQ(play_along(Vector::Zero(), {0.01, 0, 0}, kBacklash).back().play, Vector(0.01, 0, 0));
}

TEST(AxisPlay, AnAxisThatTurnsStandsUntilItsPlayIsTakenUp) {
    const auto plays = play_along({-1, 1, 0}, {0, 0.02, 0.005}, kBacklash);
    ASSERT_EQ(plays.size(), 4U);
    EXPECT_EQ(plays[1].share, 0.02);
    EXPECT_NEAR(plays[1].play.x(), 0.02, 1e-15) << "stands: as much too high as it was told to go down";
    EXPECT_EQ(plays[1].play.y(), 0.0);
    EXPECT_EQ(plays[2].share, 0.03);
    EXPECT_EQ(plays[3].play, Vector(0.03, 0, 0.005));
    EXPECT_NEAR(play_at(plays, 0.01).x(), 0.01, 1e-15);
    EXPECT_NEAR(play_at(plays, 0.01).y(), 0.01, 1e-15);
    EXPECT_EQ(play_at(plays, 0.7), plays[3].play);
}

// In small steps or in one, play is that of an axis which is pushed from one side or the other.
TEST(AxisPlay, IsTheSameInStepsAndAtOnce) {
    Random random(5);
    for (int i = 0; i < 300; ++i) {
        const Vector way = random.in_box(Vector::Constant(-0.05), Vector::Constant(0.05));
        const Vector begin = random.in_box(Vector::Zero(), kBacklash);
        const auto plays = play_along(way, begin, kBacklash);
        constexpr int kSteps = 50;
        Vector pushed = begin;
        for (int k = 1; k <= kSteps; ++k) {
            pushed = (pushed - way / kSteps).cwiseMax(0.0).cwiseMin(kBacklash);
            ASSERT_LT((play_at(plays, static_cast<double>(k) / kSteps) - pushed).norm(), 1e-12) << i;
        }
    }
}

}  // namespace
}  // namespace palpate::axis_play_test
