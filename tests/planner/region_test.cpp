#include "planner/region.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "tests/planner/some_regions.h"

namespace palpate::region_test {
namespace {

constexpr std::uint64_t kSeed = 20240611;

TEST(Region, ClipAgreesWithSamplesOfTheLine) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Region& workspace : some_regions()) {
        const double r = workspace.radius();
        const double tolerance = tolerance_of(workspace);
        int met = 0;
        for (int i = 0; i < 500; ++i) {
            Vector direction = random.direction();
            if (i % 5 == 0) direction = Vector::Unit(static_cast<int>(random.below(3)));  // along a face of a box
            const Point origin =
                workspace.center() + random.uniform(0, 1.2) * r * random.direction() + random.uniform(-3, 3) * r * direction;
            const auto inside = workspace.clip(origin, direction);
            if (inside) {
                ++met;
                ASSERT_LT(inside->low, inside->high);
                // A line that grazes makes the end of its chord ill-defined along the line, never across it.
                ASSERT_NEAR(depth(workspace, origin + inside->low * direction), 0, 4 * tolerance);
                ASSERT_NEAR(depth(workspace, origin + inside->high * direction), 0, 4 * tolerance);
            }
            for (int k = -200; k <= 200; ++k) {
                const double t = 5.0 * r * k / 200;
                const Point x = origin + t * direction;
                if (std::abs(depth(workspace, x)) < 4 * tolerance) continue;
                ASSERT_EQ(workspace.contains(x), inside && inside->low < t && t < inside->high) << "line " << i << " at " << t;
            }
        }
        EXPECT_GT(met, 50);
        EXPECT_LT(met, 500);
    }
}

TEST(Region, ClipOfALineBesideOrInAFaceIsNothing) {
    const Region box(Box{{-1, -2, -3}, {1, 2, 3}});
    EXPECT_FALSE(box.clip({1.5, 0, 0}, Vector::UnitY()));
    EXPECT_FALSE(box.clip({1, 0, 0}, Vector::UnitY())) << "a line in a face has no part in the interior";
    const auto middle = box.clip({0.5, 7, 0}, -Vector::UnitY());
    ASSERT_TRUE(middle);
    EXPECT_EQ(middle->low, 5);
    EXPECT_EQ(middle->high, 9);
    EXPECT_FALSE(Region(Ball{{0, 0, 0}, 2}).clip({0, 2.0001, 0}, Vector::UnitX()));
    const auto chord = Region(Ball{{0, 0, 0}, 5}).clip({-10, 3, 0}, Vector::UnitX());
    ASSERT_TRUE(chord);
    EXPECT_DOUBLE_EQ(chord->low, 6);
    EXPECT_DOUBLE_EQ(chord->high, 14);
}

TEST(Region, ContainsItsBoundaryAndKnowsItsSize) {
    const Region ball(Ball{{1, 0, 0}, 2});
    EXPECT_TRUE(ball.contains({3, 0, 0}));
    EXPECT_FALSE(ball.contains({3.0000001, 0, 0}));
    EXPECT_EQ(ball.center(), Point(1, 0, 0));
    EXPECT_EQ(ball.radius(), 2);
    EXPECT_NEAR(ball.volume(), 32 * std::numbers::pi / 3, 1e-12);
    const Region box(Box{{0, 0, 0}, {2, 3, 6}});
    EXPECT_TRUE(box.contains({0, 3, 6}));
    EXPECT_FALSE(box.contains({1, 1, 6.0000001}));
    EXPECT_FALSE(box.contains({1, -1e-9, 1}));
    EXPECT_EQ(box.center(), Point(1, 1.5, 3));
    EXPECT_EQ(box.radius(), 3.5);
    EXPECT_EQ(box.volume(), 36);
}

TEST(Box, ContainsWhatEveryCoordinateSays) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Box box{{-1, 0, 2}, {1, 3, 4}};
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < 5000; ++i) {
        Point p = random.in_box({-1.5, -0.5, 1.5}, {1.5, 3.5, 4.5});
        if (i % 3 == 0) p[i % 9 / 3] = i % 2 == 0 ? box.min[i % 9 / 3] : box.max[i % 9 / 3];  // in a face
        const double slack = i % 2 == 0 ? 0.0 : 0.25;
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) inside = inside && p[axis] >= box.min[axis] - slack && p[axis] <= box.max[axis] + slack;
        EXPECT_EQ(box.contains(p, slack), inside) << p.transpose();
        p[i % 3] = kNan;
        EXPECT_FALSE(box.contains(p, slack));
    }
    EXPECT_TRUE(box.contains(box));
    EXPECT_TRUE(box.contains(Box{{0, 1, 3}, {1, 2, 4}}));
    EXPECT_FALSE(box.contains(Box{{0, 1, 3}, {1, 2, 4.1}}));
    EXPECT_FALSE(box.contains(Box{{-1.1, 1, 3}, {1, 2, 4}}));
    EXPECT_TRUE(box.is_valid());
    EXPECT_FALSE((Box{{0, 0, 0}, {1, 0, 1}}.is_valid()));
    EXPECT_FALSE((Box{{0, 0, 0}, {1, std::numeric_limits<double>::infinity(), 1}}.is_valid()));
    EXPECT_FALSE((Box{{0, kNan, 0}, {1, 1, 1}}.is_valid()));
}

TEST(Region, NearestBoundaryIsOnTheBoundaryAndNothingIsNearer) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Region& workspace : some_regions()) {
        for (int i = 0; i < 200; ++i) {
            const Point p = workspace.center() + random.uniform(0, 2) * workspace.radius() * random.direction();
            const Point nearest = workspace.nearest_boundary(p);
            ASSERT_NEAR(depth(workspace, nearest), 0, tolerance_of(workspace));
            for (int k = 0; k < 200; ++k) {
                ASSERT_GE((random.on_boundary(workspace) - p).norm(), (nearest - p).norm() - tolerance_of(workspace));
            }
        }
        EXPECT_NEAR(depth(workspace, workspace.nearest_boundary(workspace.center())), 0, tolerance_of(workspace));
    }
    EXPECT_EQ(Region(Box{{0, 0, 0}, {4, 4, 4}}).nearest_boundary({1, 3.5, 2}), Point(1, 4, 2));
    EXPECT_EQ(Region(Box{{0, 0, 0}, {4, 4, 4}}).nearest_boundary({0.25, 3.5, 2}), Point(0, 3.5, 2));
}

TEST(Region, RefusesSizesThatMakeNoSense) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (const double radius : {0.0, -1.0, kInfinity, kNan}) EXPECT_THROW(Region(Ball{{0, 0, 0}, radius}), std::invalid_argument) << radius;
    EXPECT_THROW(Region(Ball{{0, kNan, 0}, 1}), std::invalid_argument);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {0.0, -1.0, kInfinity, kNan}) {
            Box box{{0, 0, 0}, {1, 1, 1}};
            box.max[axis] = side;
            EXPECT_THROW(Region{box}, std::invalid_argument) << "axis " << axis << ", side " << side;
        }
    }
}

}  // namespace
}  // namespace palpate::region_test
