// Lines against shapes: sim/objects/internal/line_trace.h through Shape.
#include <gtest/gtest.h>

#include "sim/objects/shapes.h"
#include "tests/sim/support.h"

namespace palpate::line_trace_test {
namespace {

constexpr std::uint64_t kSeed = 987654321;

// Parameters of sign changes of the signed distance along the segment, by fine marching and bisection.
std::vector<double> marched(const Shape& shape, const Segment& s, int steps) {
    const auto value = [&](double t) { return shape.signed_distance(s.source + t * (s.target - s.source)); };
    std::vector<double> result;
    double before = value(0.0);
    for (int i = 1; i <= steps; ++i) {
        const double end = static_cast<double>(i) / steps;
        const double after = value(end);
        if ((before < 0.0) != (after < 0.0)) {
            double low = static_cast<double>(i - 1) / steps;
            double high = end;
            for (int k = 0; k < 60; ++k) ((value(0.5 * (low + high)) < 0.0) == (before < 0.0) ? low : high) = 0.5 * (low + high);
            result.push_back(0.5 * (low + high));
        }
        before = after;
    }
    return result;
}

TEST(LineTrace, HitsAndCrossingsAgreeWithFineMarching) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name + ", seed " + std::to_string(kSeed));
        const Shape shape(spec);
        Random random(kSeed);
        const double size = shape.bounds().diagonal();
        for (int i = 0; i < 400; ++i) {
            const Segment s{random.around(shape.bounds(), 0.2), random.around(shape.bounds(), 0.2)};
            const Vector way = s.target - s.source;
            const auto expected = marched(shape, s, 2000);
            const auto crossings = shape.crossings(s);
            const auto hit = shape.first_hit(s);
            ASSERT_GE(crossings.size(), expected.size());  // marching can miss slivers, in pairs
            ASSERT_EQ(crossings.size() % 2, expected.size() % 2);
            ASSERT_EQ(hit.has_value(), !crossings.empty());
            if (hit) {
                ASSERT_LE((*hit - crossings.front()).norm(), 1e-10 * size);
            }
            if (crossings.size() != expected.size()) continue;
            for (std::size_t k = 0; k < expected.size(); ++k) {
                ASSERT_LE((crossings[k] - s.source - expected[k] * way).norm(), 1e-9 * size);
            }
        }
    }
}

TEST(LineTrace, HitsLieOnTheSurfaceAndOnTheSegmentWithNothingBefore) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name + ", seed " + std::to_string(kSeed));
        const Shape shape(spec);
        Random random(kSeed + 1);
        const double size = shape.bounds().diagonal() + shape.bounds().center().norm();
        int hits = 0;
        for (int i = 0; i < 20000; ++i) {
            const Segment s{random.around(shape.bounds(), 0.3), random.around(shape.bounds(), 0.3)};
            const auto hit = shape.first_hit(s);
            const bool parity = shape.crossings(s).size() % 2 == 1;
            ASSERT_EQ(parity, shape.contains(s.source) != shape.contains(s.target)) << i;
            if (!hit) continue;
            ++hits;
            ASSERT_LE(std::abs(shape.signed_distance(*hit)), 1e-13 * size);
            const Vector way = s.target - s.source;
            ASSERT_LE((*hit - s.source).cross(way.normalized()).norm(), 1e-14 * size);
            for (int k = 1; k < 8; ++k) {
                const Point before = s.source + (k / 8.0) * (*hit - s.source);
                ASSERT_TRUE(shape.contains(before) == shape.contains(s.source) || std::abs(shape.signed_distance(before)) < 1e-13 * size);
            }
        }
        EXPECT_GT(hits, 500);
    }
}

TEST(LineTrace, HitsOfASphereAreExactToRoundingFromFarAway) {
    const Shape shape({SphereSpec{1.0}, Point(3.0, 0.0, 0.0)});
    for (double far : {10.0, 1e3, 1e6}) {
        const auto hit = shape.first_hit({{-far, 0.6, 0.0}, {far, 0.6, 0.0}});
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->x(), 3.0 - 0.8, 1e-15 * far + 1e-14);
    }
}

// Chords at depth δ below the outer rim; as thin as rounding allows.
TEST(LineTrace, SeesSlivers) {
    const std::vector<NamedShape> shapes{
        {"sphere", {SphereSpec{1.4}}},        {"ellipsoid", {EllipsoidSpec{{1.4, 0.7, 0.3}}}},         {"torus", {TorusSpec{1.0, 0.4}}},
        {"capsule", {CapsuleSpec{1.4, 1.0}}}, {"rounded box", {RoundedBoxSpec{{2.8, 2.0, 1.0}, 0.4}}}, {"genus2", {Genus2Spec{1.0}}}};
    for (const auto& [name, spec] : shapes) {  // all have their farthest point at (1.4, 0, 0)
        for (double depth : {1e-2, 1e-6, 1e-9, 1e-12}) {
            SCOPED_TRACE(name + " at depth " + std::to_string(depth));
            const Shape shape(spec);
            const Segment inside{{1.4 - depth, 0.1, -5.0}, {1.4 - depth, -0.1, 5.0}};
            ASSERT_TRUE(shape.first_hit(inside));
            const auto crossings = shape.crossings(inside);
            ASSERT_EQ(crossings.size(), 2U);
            EXPECT_LT(crossings[0].z(), crossings[1].z());
            EXPECT_NEAR(shape.signed_distance(crossings[0]), 0.0, 1e-13);
            const Segment outside{{1.4 + depth, 0.1, -5.0}, {1.4 + depth, -0.1, 5.0}};
            EXPECT_FALSE(shape.first_hit(outside));
            EXPECT_TRUE(shape.crossings(outside).empty());
        }
    }
}

TEST(LineTrace, SeesAllFourCrossingsOfATorusAndTheHoleBetween) {
    const Shape torus({TorusSpec{1.0, 0.4}});
    const auto points = torus.crossings({{-3.0, 0.0, 0.0}, {3.0, 0.0, 0.0}});
    ASSERT_EQ(points.size(), 4U);
    const std::array expected{-1.4, -0.6, 0.6, 1.4};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(points[i].x(), expected[i], 1e-14);
    EXPECT_FALSE(torus.first_hit({{0.0, 0.0, -3.0}, {0.0, 0.0, 3.0}}));
    EXPECT_FALSE(torus.first_hit({{0.6 - 1e-9, 0.0, -3.0}, {0.6 - 1e-9, 0.0, 3.0}}));
    EXPECT_TRUE(torus.first_hit({{0.6 + 1e-9, 0.0, -3.0}, {0.6 + 1e-9, 0.0, 3.0}}));
    // Touching the top circle along its tangent: no passing.
    EXPECT_TRUE(torus.crossings({{1.0, -3.0, 0.4}, {1.0, 3.0, 0.4}}).size() % 2 == 0);
}

TEST(LineTrace, SourceOnTheSurfaceIsTheHitAndInsideSourceFindsTheExit) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name);
        const Shape shape(spec);
        Random random(kSeed);
        const double size = shape.bounds().diagonal();
        for (int i = 0; i < 200; ++i) {
            const Point s = shape.closest_point(random.around(shape.bounds(), 0.2));
            const auto hit = shape.first_hit({s, s + size * random.direction()});
            ASSERT_TRUE(hit);
            ASSERT_LE((*hit - s).norm(), 1e-13 * size);
            const Point p = random.around(shape.bounds(), 0.0);
            if (shape.contains(p)) {
                ASSERT_TRUE(shape.first_hit({p, p + 2.0 * size * random.direction()}));
            }
        }
    }
}

TEST(LineTrace, EmptySegmentsHitNothingAndBoxCornersAreHit) {
    const Shape box({RoundedBoxSpec{{2.0, 2.0, 2.0}, 0.0}});
    EXPECT_FALSE(box.first_hit({{3, 3, 3}, {3, 3, 3}}));
    EXPECT_TRUE(box.crossings({{3, 3, 3}, {3, 3, 3}}).empty());
    const auto corner = box.first_hit({{3, 3, 3}, {0, 0, 0}});
    ASSERT_TRUE(corner);
    EXPECT_LE((*corner - Point(1, 1, 1)).norm(), 1e-14);
    EXPECT_EQ(box.crossings({{3, 3, 3}, {-3, -3, -3}}).size(), 2U);
    EXPECT_FALSE(box.first_hit({{1.0 + 1e-12, -5, 0.3}, {1.0 + 1e-12, 5, 0.3}}));
    EXPECT_TRUE(box.first_hit({{1.0 - 1e-12, -5, 0.3}, {1.0 - 1e-12, 5, 0.3}}));
}

}  // namespace
}  // namespace palpate::line_trace_test
