#include "planner/workspace.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "tests/planner/support.h"

namespace palpate {
namespace {

constexpr std::uint64_t kSeed = 20240611;
constexpr double kTolerance = 1e-12;  // of the workspace's radius and distance from the origin

std::vector<Workspace> some_workspaces() {
    return {Workspace(Ball{{0, 0, 0}, 1}),           Workspace(Ball{{300, -20, 7}, 0.01}),
            Workspace(Ball{{1, 2, 3}, 500}),         Workspace(Box{{-1, -1, -1}, {1, 1, 1}}),
            Workspace(Box{{0, 0, 0}, {1, 20, 300}}), Workspace(Box{{40, 50, 60}, {40.1, 50.01, 60.2}})};
}

double tolerance_of(const Workspace& workspace) { return kTolerance * (workspace.radius() + workspace.center().norm()); }

TEST(Workspace, ClipAgreesWithSamplesOfTheLine) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Workspace& workspace : some_workspaces()) {
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

TEST(Workspace, ClipOfALineBesideOrInAFaceIsNothing) {
    const Workspace box(Box{{-1, -2, -3}, {1, 2, 3}});
    EXPECT_FALSE(box.clip({1.5, 0, 0}, Vector::UnitY()));
    EXPECT_FALSE(box.clip({1, 0, 0}, Vector::UnitY())) << "a line in a face has no part in the interior";
    const auto middle = box.clip({0.5, 7, 0}, -Vector::UnitY());
    ASSERT_TRUE(middle);
    EXPECT_EQ(middle->low, 5);
    EXPECT_EQ(middle->high, 9);
    EXPECT_FALSE(Workspace(Ball{{0, 0, 0}, 2}).clip({0, 2.0001, 0}, Vector::UnitX()));
    const auto chord = Workspace(Ball{{0, 0, 0}, 5}).clip({-10, 3, 0}, Vector::UnitX());
    ASSERT_TRUE(chord);
    EXPECT_DOUBLE_EQ(chord->low, 6);
    EXPECT_DOUBLE_EQ(chord->high, 14);
}

TEST(Workspace, ContainsItsBoundaryAndKnowsItsSize) {
    const Workspace ball(Ball{{1, 0, 0}, 2});
    EXPECT_TRUE(ball.contains({3, 0, 0}));
    EXPECT_FALSE(ball.contains({3.0000001, 0, 0}));
    EXPECT_EQ(ball.center(), Point(1, 0, 0));
    EXPECT_EQ(ball.radius(), 2);
    EXPECT_NEAR(ball.volume(), 32 * std::numbers::pi / 3, 1e-12);
    const Workspace box(Box{{0, 0, 0}, {2, 3, 6}});
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

TEST(Workspace, NearestBoundaryIsOnTheBoundaryAndNothingIsNearer) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Workspace& workspace : some_workspaces()) {
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
    EXPECT_EQ(Workspace(Box{{0, 0, 0}, {4, 4, 4}}).nearest_boundary({1, 3.5, 2}), Point(1, 4, 2));
    EXPECT_EQ(Workspace(Box{{0, 0, 0}, {4, 4, 4}}).nearest_boundary({0.25, 3.5, 2}), Point(0, 3.5, 2));
}

// The contract of outer_path for one pair of points.
void expect_good_outer_path(const Workspace& workspace, const Point& from, const Point& to) {
    const std::vector<Point> path = workspace.outer_path(from, to);
    const Box bounds = workspace.outer_bounds();
    for (const Point& p : path) {
        ASSERT_TRUE(((p - bounds.min).array() >= -tolerance_of(workspace)).all() &&
                    ((bounds.max - p).array() >= -tolerance_of(workspace)).all());
    }
    const double length = path_length(from, path);
    const double tolerance = 10 * tolerance_of(workspace);
    ASSERT_FALSE(path.empty());
    ASSERT_EQ(path.back(), to);
    ASSERT_NEAR(workspace.outer_distance(from, to), length, tolerance);
    ASSERT_NEAR(workspace.outer_distance(to, from), length, tolerance);
    ASSERT_GE(length, (to - from).norm() - tolerance);
    Point last = from;
    for (const Point& p : path) {
        for (int k = 0; k <= 32; ++k)
            ASSERT_LE(depth(workspace, last + k / 32.0 * (p - last)), tolerance) << "the path enters the workspace";
        last = p;
    }
    if (std::holds_alternative<Ball>(workspace.shape())) {
        const Vector u = from - workspace.center();
        const Vector v = to - workspace.center();
        const double arc = workspace.radius() * std::atan2(u.cross(v).norm(), u.dot(v));
        ASSERT_GE(length, arc - tolerance);
        ASSERT_LE(length, arc * 1.01 + tolerance);
    }
}

TEST(Workspace, OuterPathStaysOutsideAndIsAsLongAsTheOuterDistance) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Workspace& workspace : some_workspaces()) {
        for (int i = 0; i < 1000; ++i) {
            const Point from = random.on_boundary(workspace);
            const Point far = random.on_boundary(workspace);
            // Some of them close together, down to rounding.
            const double share = i % 2 == 0 ? 1 : std::pow(10, random.uniform(-14, 0));
            const Point to = workspace.nearest_boundary(from + share * (far - from));
            expect_good_outer_path(workspace, from, i % 2 == 0 ? far : to);
            if (HasFatalFailure()) return;
        }
        const Point p = random.on_boundary(workspace);
        EXPECT_NEAR(workspace.outer_distance(p, p), 0, tolerance_of(workspace));
    }
}

TEST(Workspace, OuterPathBetweenAntipodalPoints) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Ball ball{{3, 4, 5}, 7};
    const Workspace workspace(ball);
    for (int i = 0; i < 300; ++i) {
        Vector u = random.direction();
        if (i < 3) u = Vector::Unit(i);
        const Vector nearly = (-u + std::pow(10, random.uniform(-18, -6)) * random.direction()).normalized();
        const Point from = ball.center + ball.radius * u;
        expect_good_outer_path(workspace, from, ball.center - ball.radius * u);
        expect_good_outer_path(workspace, from, ball.center + ball.radius * nearly);
        if (HasFatalFailure()) return;
        ASSERT_NEAR(workspace.outer_distance(from, ball.center - ball.radius * u), std::numbers::pi * ball.radius,
                    0.01 * std::numbers::pi * ball.radius);
    }
}

TEST(Workspace, OuterPathBetweenCornersAndEdgesOfABox) {
    const Box cube{{0, 0, 0}, {1, 1, 1}};
    const Workspace workspace(cube);
    for (int a = 0; a < 27; ++a) {
        for (int b = 0; b < 27; ++b) {
            if (a == 13 || b == 13) continue;  // the middle of the cube
            const auto lattice = [](int k) { return Point(0.5 * (k % 3), 0.5 * (k / 3 % 3), 0.5 * (k / 9)); };
            expect_good_outer_path(workspace, lattice(a), lattice(b));
            if (HasFatalFailure()) return;
        }
    }
    EXPECT_NEAR(workspace.outer_distance({0, 0, 0}, {1, 1, 1}), std::sqrt(5.0), 1e-12);
    EXPECT_NEAR(workspace.outer_distance({0, 0, 0}, {1, 1, 0}), std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(workspace.outer_distance({0.5, 0.5, 0}, {0.5, 0.5, 1}), 2, 1e-12);
    EXPECT_NEAR(workspace.outer_distance({0.5, 0.5, 0}, {1, 0.5, 0.5}), 1, 1e-12);
}

// Brute force over where the way crosses the two edges of one of the four faces between.
double best_over_one_side(const Box& box, int axis, const Point& from, const Point& to, int steps) {
    double best = std::numeric_limits<double>::infinity();
    for (int side = 0; side < 3; ++side) {
        if (side == axis) continue;
        const int along = 3 - axis - side;
        for (const double border : {box.min[side], box.max[side]}) {
            for (int i = 0; i <= steps; ++i) {
                for (int j = 0; j <= steps; ++j) {
                    Point p = from;
                    Point q = to;
                    p[side] = q[side] = border;
                    p[along] = box.min[along] + i * (box.max[along] - box.min[along]) / steps;
                    q[along] = box.min[along] + j * (box.max[along] - box.min[along]) / steps;
                    best = std::min(best, (p - from).norm() + (q - p).norm() + (to - q).norm());
                }
            }
        }
    }
    return best;
}

TEST(Workspace, OuterPathBetweenOppositeFacesIsTheShortestOverOneFace) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Box box{{-1, 0, 2}, {1, 3, 7}};
    const Workspace workspace(box);
    constexpr int kSteps = 100;
    for (int i = 0; i < 30; ++i) {
        const int axis = i % 3;
        Point from = random.in_box(box.min, box.max);
        Point to = random.in_box(box.min, box.max);
        from[axis] = box.min[axis];
        to[axis] = box.max[axis];
        const double brute = best_over_one_side(box, axis, from, to, kSteps);
        const double length = workspace.outer_distance(from, to);
        ASSERT_LE(length, brute + 1e-12);
        // A grid of that step misses the best crossing points by half a step each, along an edge.
        ASSERT_GE(length, brute - 2 * (box.max - box.min).maxCoeff() / kSteps);
    }
}

TEST(Workspace, OuterPathFromInsideABoxIsRefused) {
    const Workspace workspace(Box{{0, 0, 0}, {1, 1, 1}});
    EXPECT_THROW((void)workspace.outer_path({0.5, 0.5, 0.5}, {0, 0.5, 0.5}), std::invalid_argument);
    EXPECT_THROW((void)workspace.outer_distance({0, 0.5, 0.5}, {0.5, 0.5, 0.5}), std::invalid_argument);
}

TEST(Workspace, RefusesSizesThatMakeNoSense) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (const double radius : {0.0, -1.0, kInfinity, kNan})
        EXPECT_THROW(Workspace(Ball{{0, 0, 0}, radius}), std::invalid_argument) << radius;
    EXPECT_THROW(Workspace(Ball{{0, kNan, 0}, 1}), std::invalid_argument);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {0.0, -1.0, kInfinity, kNan}) {
            Box box{{0, 0, 0}, {1, 1, 1}};
            box.max[axis] = side;
            EXPECT_THROW(Workspace{box}, std::invalid_argument) << "axis " << axis << ", side " << side;
        }
    }
}

}  // namespace
}  // namespace palpate
