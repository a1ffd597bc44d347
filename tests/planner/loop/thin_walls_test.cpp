#include "planner/loop/thin_walls.h"

#include <gtest/gtest.h>

#include "tests/random.h"

namespace palpate::thin_walls_test {
namespace {

constexpr double kFinest = 0.125;

TEST(ThinWalls, AskForBallsOfTheirThickness) {
    ThinWalls walls(1.0, kFinest);
    EXPECT_EQ(walls.size_at({0, 0, 0}), 1.0);
    walls.note({0, 0, 0}, 0.5);
    EXPECT_DOUBLE_EQ(walls.size_at({0, 0, 0}), ThinWalls::kPerThickness * 0.5);
    EXPECT_DOUBLE_EQ(walls.size_at({0.4, 0, 0}), ThinWalls::kPerThickness * 0.5 + ThinWalls::kSlope * 0.4);
    EXPECT_EQ(walls.size_at({5, 0, 0}), 1.0);
}

TEST(ThinWalls, TheSmallestWallNearbyCountsAsBruteForceFindsIt) {
    SCOPED_TRACE(seed_text(7));
    Random random(7);
    ThinWalls walls(1.0, kFinest);
    std::vector<std::pair<Point, double>> noted;
    for (int k = 0; k < 300; ++k) {
        const Point middle = random.in_box(Point::Constant(-4), Point::Constant(4));
        const double thickness = random.uniform(0.25, 1.5);
        walls.note(middle, thickness);
        noted.emplace_back(middle, thickness);
    }
    for (int k = 0; k < 1000; ++k) {
        const Point p = random.in_box(Point::Constant(-4), Point::Constant(4));
        double size = 1.0;
        for (const auto& [middle, thickness] : noted) {
            size = std::min(size, ThinWalls::kPerThickness * thickness + ThinWalls::kSlope * (p - middle).norm());
        }
        // Walls that others almost imply are not kept: a fifth of the size at the wall is what that may cost.
        EXPECT_GE(walls.size_at(p), size * (1 - 1e-12));
        EXPECT_LE(walls.size_at(p), size / 0.8 + 1e-12);
    }
}

TEST(ThinWalls, AWallThatSamplesCannotShowIsOnlyFollowed) {
    ThinWalls walls(1.0, kFinest);
    EXPECT_FALSE(walls.can_show(0.2));
    walls.note({0, 0, 0}, 0.05);
    EXPECT_DOUBLE_EQ(walls.size_at({0, 0, 0}), ThinWalls::kSheet);
    EXPECT_TRUE(walls.is_hopeless({0.1, 0, 0}, 0.2));
    EXPECT_FALSE(walls.is_hopeless({0.3, 0, 0}, 0.2));
    // What looks thicker beside it makes no difference.
    walls.note({0.1, 0, 0}, 0.25);
    EXPECT_GE(walls.size_at({0.1, 0, 0}), ThinWalls::kSheet);
}

TEST(ThinWalls, TouchesFromBothSidesShowAWall) {
    ThinWalls walls(1.0, kFinest);
    walls.note_touch({0, 0, 0.4}, {0, 0, -1});
    EXPECT_EQ(walls.size_at({0, 0, 0.2}), 1.0);
    walls.note_touch({0.1, 0, 0}, {0, 0, 1});
    EXPECT_LT(walls.size_at({0, 0, 0.2}), 0.3);

    // A gap: touched away from each other.
    ThinWalls gap(1.0, kFinest);
    gap.note_touch({0, 0, 0.4}, {0, 0, 1});
    gap.note_touch({0.1, 0, 0}, {0, 0, -1});
    EXPECT_EQ(gap.size_at({0, 0, 0.2}), 1.0);

    // An edge of a box: not against each other.
    ThinWalls edge(1.0, kFinest);
    edge.note_touch({0.2, 0, 0}, {0, 0, -1});
    edge.note_touch({0, 0, -0.2}, {1, 0, 0});
    EXPECT_EQ(edge.size_at({0, 0, 0}), 1.0);
}

}  // namespace
}  // namespace palpate::thin_walls_test
