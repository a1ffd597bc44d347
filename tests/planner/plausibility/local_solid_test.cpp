#include "planner/plausibility/local_solid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/random.h"

namespace palpate::local_solid_test {
namespace {

struct Tangent {
    Point sample;
    Vector normal;
};

LocalSolid solid_of(const std::vector<Tangent>& tangents) {
    LocalSolid solid;
    for (const auto& [sample, normal] : tangents) solid.add(sample, normal);
    return solid;
}

const Vector kX = Vector::UnitX();
const Vector kY = Vector::UnitY();
const Vector kZ = Vector::UnitZ();

TEST(LocalSolid, OnePlaneIsAHalfSpace) {
    const LocalSolid solid = solid_of({{{1, 2, 3}, kZ}});
    EXPECT_DOUBLE_EQ(*solid.height({7, 7, 5}), 2);
    EXPECT_DOUBLE_EQ(*solid.height({7, 7, 1}), -2);
}

// A wedge about the z axis, its faces `angle` apart within the solid.
TEST(LocalSolid, ACreaseIsRightOnBothSidesAtEveryAngle) {
    for (const double degrees : {20.0, 60.0, 90.0, 150.0, 210.0, 270.0, 340.0}) {
        const double angle = degrees * std::acos(-1.0) / 180;
        const auto at = [](double phi, double r) { return Point(r * std::cos(phi), r * std::sin(phi), 0); };
        const LocalSolid solid = solid_of({{at(0, 1), -kY}, {at(angle, 1.3), Vector(-std::sin(angle), std::cos(angle), 0)}});
        for (double phi = 0.03; phi < 6.25; phi += 0.1) {
            if (std::abs(phi - angle) < 0.02) continue;
            const auto height = solid.height(at(phi, 0.8));
            ASSERT_TRUE(height);
            EXPECT_EQ(*height < 0, phi < angle) << degrees << " degrees, at " << phi;
        }
    }
}

// Eight corners where three axis-parallel planes meet, each filled with any of the octants that make a solid whose three faces all end at
// the corner: convex, concave, and the saddles between.
TEST(LocalSolid, CornersOfThreeFacesAreRight) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> along(-1, 1);
    const auto expect = [&](const LocalSolid& solid, auto&& contains) {
        for (int k = 0; k < 500; ++k) {
            const Point x(along(random), along(random), along(random));
            ASSERT_TRUE(solid.height(x));
            EXPECT_EQ(*solid.height(x) < 0, contains(x)) << x.transpose();
        }
    };
    expect(solid_of({{{0, -0.5, -0.5}, kX}, {{-0.5, 0, -0.4}, kY}, {{-0.5, -0.3, 0}, kZ}}),
           [](const Point& x) { return x.x() < 0 && x.y() < 0 && x.z() < 0; });
    expect(solid_of({{{0, 0.5, 0.5}, kX}, {{0.5, 0, 0.4}, kY}, {{0.5, 0.3, 0}, kZ}}),
           [](const Point& x) { return x.x() < 0 || x.y() < 0 || x.z() < 0; });
    // A step on a plate: below z = 0, or in the quarter x < 0, y < 0. Its top is not here.
    expect(solid_of({{{0, -0.5, 0.5}, kX}, {{-0.5, 0, 0.5}, kY}, {{0.5, 0.5, 0}, kZ}}),
           [](const Point& x) { return x.z() < 0 || (x.x() < 0 && x.y() < 0); });
    // A groove along a box's edge: below z = 0, but not where both x and y are positive.
    expect(solid_of({{{0, 0.5, -0.5}, kX}, {{0.5, 0, -0.5}, kY}, {{-0.5, -0.5, 0}, kZ}}),
           [](const Point& x) { return x.z() < 0 && (x.x() < 0 || x.y() < 0); });
}

TEST(LocalSolid, SaysNothingWhereItCannotTellHowPlanesAreJoined) {
    // Two samples on the crease itself: it may go either way.
    const LocalSolid solid = solid_of({{{0, 0, 0}, kX}, {{0, 0, 1}, kY}});
    EXPECT_FALSE(solid.height({0.5, -0.5, 0}));
    // Where both ways agree it does.
    EXPECT_GT(*solid.height({0.5, 0.6, 0}), 0);
    EXPECT_LT(*solid.height({-0.5, -0.6, 0}), 0);
}

// Planes that touch a sphere: wherever samples lie on it, the solid is what all are above.
TEST(LocalSolid, ASmoothPlaceIsTheIntersectionOfItsHalfSpaces) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    int told = 0;
    for (int k = 0; k < 200; ++k) {
        LocalSolid solid;
        std::vector<Vector> normals;
        for (int i = 0; i < 4; ++i) {
            normals.push_back(Vector(0.3 * normal(random), 0.3 * normal(random), 1).normalized());
            solid.add(normals.back(), normals.back());
        }
        const Point x(0.3 * normal(random), 0.3 * normal(random), 1 + 0.2 * normal(random));
        double highest = -1e9;
        for (const Vector& n : normals) highest = std::max(highest, n.dot(x) - 1);
        const auto height = solid.height(x);
        told += height.has_value();
        if (height) {
            EXPECT_NEAR(*height, highest, 1e-12);
        }
    }
    EXPECT_GT(told, 100);
}

TEST(LocalSolid, ALineCrossesTheBoundaryWhereTheHeightIsZero) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> along(-1, 1);
    const LocalSolid step = solid_of({{{0, -0.5, 0.5}, kX}, {{-0.5, 0, 0.5}, kY}, {{0.5, 0.5, 0}, kZ}});
    int crossed = 0;
    for (int k = 0; k < 500; ++k) {
        const Point origin(along(random), along(random), along(random));
        const Vector direction = Vector(along(random), along(random), along(random)).normalized();
        const auto crossing = step.crossing(origin, direction);
        // Brute force: the nearest change of sign.
        std::optional<double> nearest;
        for (int i = 0; i < 4000; ++i) {
            for (const double t : {i * 1e-3, -i * 1e-3}) {
                if (nearest) break;
                const double before = *step.height(origin + (t - 5e-4) * direction);
                const double after = *step.height(origin + (t + 5e-4) * direction);
                if ((before > 0) != (after > 0)) nearest = t;
            }
        }
        if (!nearest) continue;
        ++crossed;
        ASSERT_TRUE(crossing);
        EXPECT_NEAR(std::abs(crossing->at), std::abs(*nearest), 2e-3);
        EXPECT_NEAR(*step.height(origin + crossing->at * direction), 0, 1e-9);
    }
    EXPECT_GT(crossed, 300);
}

}  // namespace
}  // namespace palpate::local_solid_test
