#include "sim/objects/parallelogram.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "sim/objects/mesh/mesh_file.h"
#include "sim/objects/triangle_tree.h"
#include "tests/random.h"
#include "tests/sim/objects/brute_distance.h"

namespace palpate::parallelogram_test {
namespace {

// The distance of its points is convex in both coordinates.
double searched(const Parallelogram& p, const Triangle& t) {
    constexpr int kRounds = 50;
    return least([&](double s) { return least([&](double r) { return point_distance(p.at(s, r), t); }, kRounds); }, kRounds);
}

Parallelogram random_one(Random& random) {
    Parallelogram p{random.in_box(Point::Constant(-1.5), Point::Constant(1.5)), 3 * random.direction(), 3 * random.direction()};
    if (random.chance(0.2)) p.u = Vector::Zero();
    if (random.chance(0.2)) p.v = Vector::Zero();
    if (random.chance(0.1)) p.v = -0.7 * p.u;
    return p;
}

TEST(Parallelogram, DistanceIsThatOfTheNearestPoints) {
    Random random(5);
    int meet = 0;
    for (int k = 0; k < 400; ++k) {
        Triangle t;
        for (Point& p : t) p = random.in_box(Point::Constant(-2), Point::Constant(2));
        Parallelogram p = random_one(random);
        if (random.chance(0.1)) p.u = t[1] - t[0];  // along an edge
        const double found = distance(p, t);
        EXPECT_NEAR(found, searched(p, t), 1e-6) << k;
        meet += found == 0 ? 1 : 0;
    }
    EXPECT_GT(meet, 40);
    EXPECT_LT(meet, 300);
}

TEST(TriangleTree, FindsTheNearestOfAllTrianglesWithinReach) {
    const TriangleMesh bunny = read_triangles(PALPATE_TEST_DATA "/bunny.off");
    const TriangleTree tree(bunny);
    Random random(17);
    int near = 0;
    for (int k = 0; k < 200; ++k) {
        Parallelogram p = random_one(random);
        p.corner = Point(0, 5, 0) + 6 * random.direction();
        const double within = random.uniform(0.01, 2);
        double least = std::numeric_limits<double>::infinity();
        for (const auto& [a, b, c] : bunny.triangles)
            least = std::min(least, distance(p, {bunny.points[a], bunny.points[b], bunny.points[c]}));
        const auto found = tree.distance(p, within);
        ASSERT_EQ(found.has_value(), least <= within) << k;
        if (found) {
            EXPECT_EQ(*found, least) << k;
        }
        near += found ? 1 : 0;
    }
    EXPECT_GT(near, 40);
}

}  // namespace
}  // namespace palpate::parallelogram_test
