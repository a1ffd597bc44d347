#include "sim/objects/shapes.h"

#include <gtest/gtest.h>

#include <limits>

#include "sim/objects/errors.h"
#include "tests/sim/support.h"

namespace palpate::shapes_test {
namespace {

constexpr std::uint64_t kSeed = 20240501;

// Numerical gradient of the signed distance.
Vector gradient(const Shape& shape, const Point& p, double h) {
    Vector g;
    for (int axis = 0; axis < 3; ++axis) {
        const Vector step = h * Vector::Unit(axis);
        g[axis] = (shape.signed_distance(p + step) - shape.signed_distance(p - step)) / (2.0 * h);
    }
    return g;
}

TEST(Shapes, DistanceIsZeroAtClosestPointAndAsFarAsItSays) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name + ", seed " + std::to_string(kSeed));
        const Shape shape(spec);
        Random random(kSeed);
        const double size = shape.bounds().diagonal() + shape.bounds().center().norm();
        for (int i = 0; i < 2000; ++i) {
            const Point p = random.around(shape.bounds(), 0.3);
            const double d = shape.signed_distance(p);
            const Point foot = shape.closest_point(p);
            ASSERT_NEAR((p - foot).norm(), std::abs(d), 1e-14 * size);
            ASSERT_NEAR(shape.signed_distance(foot), 0.0, 1e-14 * size);
            ASSERT_EQ(shape.contains(p), d < 0.0);
        }
    }
}

// An independent oracle: no point of S that rays find is nearer than the distance, and some is about as near.
TEST(Shapes, DistanceAgreesWithBruteForceOverSurfacePoints) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name + ", seed " + std::to_string(kSeed));
        const Shape shape(spec);
        Random random(kSeed);
        const double size = shape.bounds().diagonal();
        std::vector<Point> surface;
        while (surface.size() < 20000) {
            const Point middle = random.around(shape.bounds(), 0.0);
            const Vector half = 2.0 * size * random.direction();
            for (const Point& p : shape.crossings({middle - half, middle + half})) surface.push_back(p);
        }
        for (int i = 0; i < 60; ++i) {
            const Point p = random.around(shape.bounds(), 0.2);
            double least = std::numeric_limits<double>::infinity();
            for (const Point& s : surface) least = std::min(least, (s - p).norm());
            const double d = std::abs(shape.signed_distance(p));
            ASSERT_GE(least, d - 1e-12 * size);
            ASSERT_LE(least, d + 0.05 * size);  // spacing of the samples
        }
    }
}

TEST(Shapes, GradientHasLengthOneAndContainsMatchesTheClosedForm) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name + ", seed " + std::to_string(kSeed));
        const Shape shape(spec);
        Random random(kSeed);
        const double size = shape.bounds().diagonal();
        int off = 0;
        constexpr int kPoints = 2000;
        for (int i = 0; i < kPoints; ++i) {
            const double length = gradient(shape, random.around(shape.bounds(), 0.3), 1e-6 * size).norm();
            ASSERT_LE(length, 1.0 + 1e-6);
            if (length < 1.0 - 1e-6) ++off;  // on the medial axis, by chance
        }
        EXPECT_LE(off, kPoints / 200);
    }
}

TEST(Shapes, EllipsoidDistanceAtItsHardPlaces) {
    const Shape shape({EllipsoidSpec{{3.0, 2.0, 1.0}}});
    EXPECT_DOUBLE_EQ(shape.signed_distance(Point::Zero()), -1.0);
    EXPECT_DOUBLE_EQ(shape.signed_distance({0.0, 0.0, 2.5}), 1.5);
    EXPECT_DOUBLE_EQ(shape.signed_distance({4.0, 0.0, 0.0}), 1.0);
    EXPECT_NEAR(shape.signed_distance({0.0, 0.0, 1e-300}), -1.0, 1e-15);
    // On the long axis, beyond and before the centre of curvature at its tip, 3 - 1/3.
    EXPECT_NEAR(shape.signed_distance({2.9, 0.0, 0.0}), -0.1, 1e-15);
    EXPECT_NEAR(shape.signed_distance({3.0 - 1.0 / 3.0 + 1e-9, 0.0, 0.0}), -1.0 / 3.0, 1e-8);
    EXPECT_GT(shape.signed_distance({1.0, 0.0, 0.0}), -1.0);
    for (double tiny : {0.0, 1e-300, 1e-100, 1e-17, 1e-9}) {
        const double d = shape.signed_distance({1.0, 0.5, tiny});
        EXPECT_NEAR(d, shape.signed_distance({1.0, 0.5, -tiny}), 1e-15);
        EXPECT_NEAR(d, shape.signed_distance({1.0, 0.5, 0.0}), 1e-8);
    }
    // Very flat: from above its middle the nearest point is straight below.
    EXPECT_NEAR(Shape({EllipsoidSpec{{1.0, 1.0, 1e-6}}}).signed_distance({0.0, 0.0, 0.3}), 0.3 - 1e-6, 1e-15);
}

TEST(Shapes, BoundsAreTight) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name);
        const Shape shape(spec);
        const double size = shape.bounds().diagonal();
        Random random(kSeed);
        Box seen{Point::Constant(1e9), Point::Constant(-1e9)};
        for (int i = 0; i < 20000; ++i) {
            const Point p = shape.closest_point(random.around(shape.bounds(), 0.2));
            seen = {seen.min.cwiseMin(p), seen.max.cwiseMax(p)};
        }
        EXPECT_GE((seen.min - shape.bounds().min).minCoeff(), -1e-12 * size);
        EXPECT_GE((shape.bounds().max - seen.max).minCoeff(), -1e-12 * size);
        EXPECT_LE((seen.min - shape.bounds().min).maxCoeff(), 0.02 * size);
        EXPECT_LE((shape.bounds().max - seen.max).maxCoeff(), 0.02 * size);
    }
}

// Whether some surface sample has a tangent ball of this radius, on the side of `sign`, that reaches over S.
bool some_tangent_ball_fails(const Shape& shape, double radius, double sign, Random& random) {
    const double size = shape.bounds().diagonal();
    for (int i = 0; i < 20000; ++i) {
        const Point s = shape.closest_point(random.around(shape.bounds(), 0.1));
        const Vector n = gradient(shape, s, 1e-6 * size);
        if (std::abs(n.norm() - 1.0) > 1e-5) continue;  // an edge
        if (sign * shape.signed_distance(s + sign * radius * n.normalized()) < radius - 1e-7 * size) return true;
    }
    return false;
}

TEST(Shapes, TangentBallsOfTheReachFitOnBothSidesAndLargerOnesDoNot) {
    for (const auto& [name, spec] : all_shapes()) {
        SCOPED_TRACE(name + ", seed " + std::to_string(kSeed));
        const Shape shape(spec);
        const double reach = shape.reach();
        if (name == "sharp box") {
            EXPECT_EQ(reach, 0.0);
            continue;
        }
        Random random(kSeed);
        EXPECT_FALSE(some_tangent_ball_fails(shape, reach * (1.0 - 1e-9), 1.0, random));
        EXPECT_FALSE(some_tangent_ball_fails(shape, reach * (1.0 - 1e-9), -1.0, random));
        EXPECT_TRUE(some_tangent_ball_fails(shape, 1.05 * reach, 1.0, random) ||
                    some_tangent_ball_fails(shape, 1.05 * reach, -1.0, random));
    }
}

TEST(Shapes, ReachOfUnionsIsTheLeastOfPartsAndHalfTheGap) {
    const ShapeSpec ball{SphereSpec{1.0}};
    const auto pair = [&](double gap) { return Shape({std::vector<ShapeSpec>{ball, placed(ball, {0.0, 2.0 + gap, 0.0})}}).reach(); };
    EXPECT_NEAR(pair(0.5), 0.25, 1e-12);
    EXPECT_NEAR(pair(1e-3), 0.5e-3, 1e-9);
    EXPECT_NEAR(pair(3.0), 1.0, 1e-12);
    // A ball in a torus' hole: the gap is found inside the hole. 1 - 0.3 - 0.4 is left.
    EXPECT_NEAR(Shape({std::vector<ShapeSpec>{{TorusSpec{1.0, 0.3}}, {SphereSpec{0.4}}}}).reach(), 0.15, 1e-9);
    // Linked rings: the tube of each runs through the middle of the other's hole, 0.8 from its core circle.
    const ShapeSpec ring{TorusSpec{0.8, 0.2}};
    const Shape chain({std::vector<ShapeSpec>{ring, placed(ring, {0.8, 0.0, 0.0}, {0.5 * std::numbers::pi, 0.0, 0.0})}});
    EXPECT_NEAR(chain.reach(), 0.2, 1e-9);
    EXPECT_EQ(chain.euler_characteristic(), 0);
    EXPECT_EQ(chain.components(), 2);
    // Two sharp boxes are 0; parts far apart leave the parts' own.
    EXPECT_EQ(Shape({std::vector<ShapeSpec>{{RoundedBoxSpec{{1, 1, 1}, 0.0}}, placed(ball, {9, 0, 0})}}).reach(), 0.0);
}

TEST(Shapes, MeasuresAreThoseOfTheClosedForms) {
    EXPECT_DOUBLE_EQ(Shape({EllipsoidSpec{{0.5, 2.0, 1.0}}}).reach(), 0.125);
    EXPECT_DOUBLE_EQ(Shape({TorusSpec{1.0, 0.4}}).reach(), 0.4);
    EXPECT_NEAR(Shape({TorusSpec{1.0, 0.9}}).reach(), 0.1, 1e-15);
    EXPECT_NEAR(Shape({Genus2Spec{2.0}}).reach(), 0.4, 1e-15);
    EXPECT_EQ(Shape({Genus2Spec{2.0}}).euler_characteristic(), -2);
    EXPECT_EQ(Shape({TorusSpec{1.0, 0.4}}).euler_characteristic(), 0);
    EXPECT_EQ(Shape({CapsuleSpec{1.0, 0.0}}).euler_characteristic(), 2);
    EXPECT_EQ(Shape(all_shapes().back().spec).components(), 3);
    EXPECT_EQ(Shape(all_shapes().back().spec).euler_characteristic(), 4);
}

TEST(Shapes, RotationIsAboutXThenYThenZBeforeTheShift) {
    const double quarter = 0.5 * std::numbers::pi;
    // A bar along z; a quarter about x lays it along -y, then a quarter about z along x.
    const ShapeSpec bar = placed({CapsuleSpec{0.1, 2.0}}, {10.0, 0.0, 0.0}, {quarter, 0.0, quarter});
    EXPECT_TRUE(Shape(bar).contains({10.9, 0.0, 0.0}));
    EXPECT_FALSE(Shape(bar).contains({10.0, 0.9, 0.0}));
    EXPECT_FALSE(Shape(bar).contains({10.0, 0.0, 0.9}));
    const Shape moved({std::vector<ShapeSpec>{bar}, Point(0.0, 0.0, 1.0), Vector(0.0, 0.0, quarter)});
    EXPECT_TRUE(moved.contains({0.0, 10.9, 1.0}));
}

std::string message_of(const ShapeSpec& spec) {
    try {
        const Shape shape(spec);
    } catch (const ObjectError& error) {
        return error.what();
    }
    return "";
}

TEST(Shapes, RefusesParametersThatDescribeNoSolid) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(message_of({SphereSpec{0.0}}).find("radius must be a positive"), std::string::npos);
    EXPECT_NE(message_of({SphereSpec{nan}}).find("radius"), std::string::npos);
    EXPECT_NE(message_of({EllipsoidSpec{{1.0, -1.0, 1.0}}}).find("semi-axis"), std::string::npos);
    EXPECT_NE(message_of({TorusSpec{1.0, 1.0}}).find("major must exceed minor"), std::string::npos);
    EXPECT_NE(message_of({TorusSpec{nan, 1.0}}).find("major"), std::string::npos);
    EXPECT_NE(message_of({CapsuleSpec{1.0, -1.0}}).find("length"), std::string::npos);
    EXPECT_NE(message_of({RoundedBoxSpec{{1.0, 2.0, 3.0}, 0.51}}).find("fillet must lie between"), std::string::npos);
    EXPECT_NE(message_of({RoundedBoxSpec{{1.0, 2.0, 3.0}, nan}}).find("fillet"), std::string::npos);
    EXPECT_NE(message_of({Genus2Spec{-1.0}}).find("scale"), std::string::npos);
    EXPECT_NE(message_of({std::vector<ShapeSpec>{}}).find("at least one part"), std::string::npos);
    EXPECT_NE(message_of({SphereSpec{}, Point(nan, 0, 0)}).find("finite"), std::string::npos);
    EXPECT_EQ(message_of({RoundedBoxSpec{{1.0, 2.0, 3.0}, 0.5}}), "");
}

TEST(Shapes, RefusesPartsThatOverlapTouchOrContainOneAnotherAndNamesThem) {
    const ShapeSpec ball{SphereSpec{1.0}};
    const ShapeSpec speck{SphereSpec{0.1}};
    const auto both = [](const ShapeSpec& a, const ShapeSpec& b) { return message_of({std::vector<ShapeSpec>{a, b}}); };
    EXPECT_NE(both(ball, placed(ball, {1.9, 0, 0})).find("part 1 (sphere) and part 2 (sphere) overlap or touch"), std::string::npos);
    EXPECT_NE(both(ball, placed(ball, {2.0, 0, 0})), "");
    EXPECT_NE(both(ball, speck), "");
    EXPECT_NE(both(speck, ball), "");
    EXPECT_NE(both(placed(speck, {0.5, 0.3, 0}), ball), "");
    EXPECT_NE(both({TorusSpec{1.0, 0.4}}, placed({CapsuleSpec{0.3, 4.0}}, {0.35, 0, 0})), "");
    EXPECT_EQ(both({TorusSpec{1.0, 0.4}}, {CapsuleSpec{0.3, 4.0}}), "");
    const ShapeSpec inner{std::vector<ShapeSpec>{ball, placed({TorusSpec{1.0, 0.4}}, {4, 0, 0})}};
    EXPECT_NE(both(placed(ball, {4.9, 0, 0}), inner).find("part 1 (sphere) and part 2.2 (torus)"), std::string::npos);
}

}  // namespace
}  // namespace palpate::shapes_test
