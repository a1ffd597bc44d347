#include "planner/part/internal/facet_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/random.h"

namespace palpate::facet_tree_test {
namespace {

constexpr std::uint64_t kSeed = 3;

TriangleMesh random_triangles(Random& random, std::size_t count) {
    TriangleMesh mesh;
    for (std::uint32_t f = 0; f < count; ++f) {
        const Point middle = random.in_box(Point::Constant(-5), Point::Constant(5));
        for (int k = 0; k < 3; ++k) mesh.points.push_back(middle + random.direction());
        mesh.triangles.push_back({3 * f, 3 * f + 1, 3 * f + 2});
    }
    return mesh;
}

// mm: the least distance over a grid of the triangle's places, and how far that is from the truth at most.
double sampled_distance(const Corners& triangle, const Segment& segment) {
    constexpr int kSteps = 60;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
            const double a = static_cast<double>(i) / kSteps;
            const double b = static_cast<double>(j) / kSteps;
            least = std::min(least, distance_to(segment, a * triangle[0] + b * triangle[1] + (1 - a - b) * triangle[2]));
        }
    }
    return least;
}

TEST(FacetTree, TheNearestPlaceIsThatOfAllFacets) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const TriangleMesh mesh = random_triangles(random, 200);
    const FacetTree tree(mesh);
    for (int k = 0; k < 200; ++k) {
        const Point p = random.in_box(Point::Constant(-7), Point::Constant(7));
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) least = std::min(least, nearest_on_triangle(tree.corners(f), p).distance);
        const FacetPlace found = tree.nearest(p);
        EXPECT_EQ(found.distance, least);
        EXPECT_NEAR((found.point - p).norm(), least, 1e-12);
        EXPECT_NEAR(found.share.sum(), 1, 1e-12);
        EXPECT_GE(found.share.minCoeff(), -1e-12);
    }
}

TEST(FacetTree, DistancesAreThoseOfManyPlacesOnTheTriangle) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int k = 0; k < 60; ++k) {
        const Corners triangle{random.direction(), random.direction(), random.direction()};
        const Point p = 2 * random.direction();
        const Segment segment{2 * random.direction(), 2 * random.direction()};
        for (const Segment& from : {segment, Segment{p, p}}) {
            const double sampled = sampled_distance(triangle, from);
            const double exact = nearest_on_triangle(triangle, from).distance;
            EXPECT_LE(exact, sampled + 1e-12);
            EXPECT_GE(exact, sampled - 0.03);
        }
        EXPECT_NEAR(nearest_on_triangle(triangle, p).distance, nearest_on_triangle(triangle, Segment{p, p}).distance, 1e-12);
    }
}

TEST(FacetTree, ASegmentFindsEveryFacetThatIsNear) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const TriangleMesh mesh = random_triangles(random, 200);
    const FacetTree tree(mesh);
    for (int k = 0; k < 50; ++k) {
        const Point p = random.in_box(Point::Constant(-6), Point::Constant(6));
        const Segment segment{p, p + 8 * random.direction()};
        std::vector<std::uint32_t> found;
        tree.near(segment, 1.5, [&](const FacetPlace& place) { found.push_back(place.facet); });
        std::ranges::sort(found);
        std::vector<std::uint32_t> expected;
        for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
            if (nearest_on_triangle(tree.corners(f), segment).distance < 1.5) expected.push_back(f);
        }
        EXPECT_EQ(found, expected);
    }
}

}  // namespace
}  // namespace palpate::facet_tree_test
