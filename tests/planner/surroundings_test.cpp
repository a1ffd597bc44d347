#include "planner/surroundings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "tests/planner/some_regions.h"

namespace palpate::surroundings_test {
namespace {

constexpr std::uint64_t kSeed = 20240611;

TEST(Surroundings, ExactlyWhatIsOutsideTheRegionIsFree) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Region& workspace : some_regions()) {
        const Surroundings around(workspace);
        for (int i = 0; i < 200; ++i) {
            const Point origin = workspace.center() + random.uniform(0, 2) * workspace.radius() * random.direction();
            const Vector direction = random.direction();
            ASSERT_EQ(around.is_free(origin), !workspace.contains(origin));
            const auto unknown = around.unknown_part(origin, direction);
            for (int k = -50; k <= 50; ++k) {
                const double t = 0.08 * k * workspace.radius();
                const Point x = origin + t * direction;
                if (std::abs(depth(workspace, x)) <= tolerance_of(workspace)) continue;
                ASSERT_EQ(around.is_free(x), !unknown || t < unknown->low || t > unknown->high);
            }
            ASSERT_NEAR(depth(workspace, around.nearest_entry(origin)), 0, tolerance_of(workspace));
        }
    }
}

// The contract of path for one pair of points.
void expect_good_path(const Region& workspace, const Point& from, const Point& to) {
    const Surroundings around(workspace);
    const std::vector<Point> path = around.path(from, to);
    const Box bounds = around.bounds();
    for (const Point& p : path) {
        ASSERT_TRUE(((p - bounds.min).array() >= -tolerance_of(workspace)).all() &&
                    ((bounds.max - p).array() >= -tolerance_of(workspace)).all());
    }
    const double length = path_length(from, path);
    const double tolerance = 10 * tolerance_of(workspace);
    ASSERT_FALSE(path.empty());
    ASSERT_EQ(path.back(), to);
    ASSERT_NEAR(around.distance(from, to), length, tolerance);
    ASSERT_NEAR(around.distance(to, from), length, tolerance);
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

TEST(Surroundings, PathStaysOutsideAndIsAsLongAsTheDistance) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Region& workspace : some_regions()) {
        for (int i = 0; i < 1000; ++i) {
            const Point from = random.on_boundary(workspace);
            const Point far = random.on_boundary(workspace);
            // Some of them close together, down to rounding.
            const double share = i % 2 == 0 ? 1 : std::pow(10, random.uniform(-14, 0));
            const Point to = workspace.nearest_boundary(from + share * (far - from));
            expect_good_path(workspace, from, i % 2 == 0 ? far : to);
            if (HasFatalFailure()) return;
        }
        const Point p = random.on_boundary(workspace);
        EXPECT_NEAR(Surroundings(workspace).distance(p, p), 0, tolerance_of(workspace));
    }
}

TEST(Surroundings, PathBetweenAntipodalPoints) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Ball ball{{3, 4, 5}, 7};
    const Region workspace(ball);
    for (int i = 0; i < 300; ++i) {
        Vector u = random.direction();
        if (i < 3) u = Vector::Unit(i);
        const Vector nearly = (-u + std::pow(10, random.uniform(-18, -6)) * random.direction()).normalized();
        const Point from = ball.center + ball.radius * u;
        expect_good_path(workspace, from, ball.center - ball.radius * u);
        expect_good_path(workspace, from, ball.center + ball.radius * nearly);
        if (HasFatalFailure()) return;
        ASSERT_NEAR(Surroundings(workspace).distance(from, ball.center - ball.radius * u), std::numbers::pi * ball.radius,
                    0.01 * std::numbers::pi * ball.radius);
    }
}

TEST(Surroundings, PathBetweenCornersAndEdgesOfABox) {
    const Box cube{{0, 0, 0}, {1, 1, 1}};
    const Region workspace(cube);
    for (int a = 0; a < 27; ++a) {
        for (int b = 0; b < 27; ++b) {
            if (a == 13 || b == 13) continue;  // the middle of the cube
            const auto lattice = [](int k) { return Point(0.5 * (k % 3), 0.5 * (k / 3 % 3), 0.5 * (k / 9)); };
            expect_good_path(workspace, lattice(a), lattice(b));
            if (HasFatalFailure()) return;
        }
    }
    EXPECT_NEAR(Surroundings(workspace).distance({0, 0, 0}, {1, 1, 1}), std::sqrt(5.0), 1e-12);
    EXPECT_NEAR(Surroundings(workspace).distance({0, 0, 0}, {1, 1, 0}), std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(Surroundings(workspace).distance({0.5, 0.5, 0}, {0.5, 0.5, 1}), 2, 1e-12);
    EXPECT_NEAR(Surroundings(workspace).distance({0.5, 0.5, 0}, {1, 0.5, 0.5}), 1, 1e-12);
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

TEST(Surroundings, PathBetweenOppositeFacesIsTheShortestOverOneFace) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Box box{{-1, 0, 2}, {1, 3, 7}};
    const Region workspace(box);
    constexpr int kSteps = 100;
    for (int i = 0; i < 30; ++i) {
        const int axis = i % 3;
        Point from = random.in_box(box.min, box.max);
        Point to = random.in_box(box.min, box.max);
        from[axis] = box.min[axis];
        to[axis] = box.max[axis];
        const double brute = best_over_one_side(box, axis, from, to, kSteps);
        const double length = Surroundings(workspace).distance(from, to);
        ASSERT_LE(length, brute + 1e-12);
        // A grid of that step misses the best crossing points by half a step each, along an edge.
        ASSERT_GE(length, brute - 2 * (box.max - box.min).maxCoeff() / kSteps);
    }
}

TEST(Surroundings, PathFromInsideABoxIsRefused) {
    const Region workspace(Box{{0, 0, 0}, {1, 1, 1}});
    EXPECT_THROW((void)Surroundings(workspace).path({0.5, 0.5, 0.5}, {0, 0.5, 0.5}), std::invalid_argument);
    EXPECT_THROW((void)Surroundings(workspace).distance({0, 0.5, 0.5}, {0.5, 0.5, 0.5}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::surroundings_test
