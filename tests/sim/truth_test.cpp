#include "sim/truth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "planner/random.h"
#include "sim/objects/crofton.h"
#include "sim/objects/errors.h"
#include "tests/sim/support.h"

namespace palpate::truth_test {
namespace {

constexpr std::uint64_t kSeed = 99;

TEST(TruthTest, CroftonAreaMatchesClosedForms) {
    constexpr double kPi = std::numbers::pi;
    const std::vector<std::pair<NamedShape, double>> cases{
        {{"sphere", {SphereSpec{1.5}}}, 4.0 * kPi * 1.5 * 1.5},
        {{"torus", {TorusSpec{1.0, 0.4}}}, 4.0 * kPi * kPi * 0.4},
        {{"sharp box", {RoundedBoxSpec{{1.0, 2.0, 3.0}, 0.0}}}, 22.0},
        {{"capsule", {CapsuleSpec{0.5, 1.0}}}, 2.0 * kPi},
        {{"spheroid", {EllipsoidSpec{{1.0, 1.0, 0.5}}}}, 2.0 * kPi * (1.0 + 0.25 / std::sqrt(0.75) * std::atanh(std::sqrt(0.75)))}};
    for (const auto& [shape, area] : cases) {
        SCOPED_TRACE(shape.name + ", seed " + std::to_string(kSeed));
        const HiddenObject object(placed(shape.spec, {2.0, 1.0, -3.0}, {0.4, 0.5, 0.6}));
        std::mt19937_64 random(kSeed);
        EXPECT_NEAR(sample_surface(object, 100'000, random).area / area, 1.0, 0.015);
    }
}

TEST(TruthTest, CroftonPointsAreUniformByArea) {
    // On a sphere equal slabs have equal areas (Archimedes); on a torus the outer half has π r + 2 r of every 2 π r.
    std::mt19937_64 random(kSeed);
    const SurfaceSample ball = sample_surface(HiddenObject(ShapeSpec{SphereSpec{1.0}}), 100'000, random);
    std::array<double, 10> slabs{};
    for (const Point& p : ball.points) slabs.at(static_cast<std::size_t>(std::clamp(5.0 * (p.z() + 1.0), 0.0, 9.0))) += 10.0 / 100'000;
    for (double share : slabs) EXPECT_NEAR(share, 1.0, 0.05);
    const SurfaceSample torus = sample_surface(HiddenObject(ShapeSpec{TorusSpec{1.0, 0.4}}), 100'000, random);
    double outer = 0.0;
    for (const Point& p : torus.points) outer += p.head<2>().norm() > 1.0 ? 1.0 / static_cast<double>(torus.points.size()) : 0.0;
    EXPECT_NEAR(outer, 0.5 + 0.4 / std::numbers::pi, 0.01);
}

// The centre of a flat triangle with circumradius ρ on a sphere of radius R is R - √(R² - ρ²) below it, the farthest point of both.
TEST(TruthTest, HausdorffOfAnInscribedMeshIsItsSagitta) {
    const double radius = 2.0;
    const TriangleMesh mesh = sphere_mesh(radius, 3);
    double sagitta = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vector u = mesh.points[b] - mesh.points[a];
        const Vector v = mesh.points[c] - mesh.points[a];
        const double rho = u.norm() * v.norm() * (u - v).norm() / (2.0 * u.cross(v).norm());
        sagitta = std::max(sagitta, radius - std::sqrt(radius * radius - rho * rho));
    }
    const HiddenObject ball(ShapeSpec{SphereSpec{radius}});
    const Truth truth = measure_truth(ball, mesh, {}, kSeed);
    EXPECT_NEAR(truth.hausdorff / sagitta, 1.0, 0.02);
    EXPECT_LE(truth.hausdorff, sagitta * (1.0 + 1e-12));
    EXPECT_GT(truth.mean_distance, 0.2 * sagitta);
    EXPECT_LT(truth.mean_distance, 0.7 * sagitta);
    EXPECT_EQ(truth.euler_characteristic, 2);
    EXPECT_EQ(truth.components, 1);
    EXPECT_EQ(truth.reach, radius);
    EXPECT_NEAR(truth.area / (4.0 * std::numbers::pi * radius * radius), 1.0, 0.015);
}

TEST(TruthTest, SeesWhatTheResultMissesAndWhatItMadeUp) {
    const ShapeSpec ball{SphereSpec{1.0}};
    const ShapeSpec other = placed(ball, {5.0, 0.0, 0.0});
    const HiddenObject one(ball);
    const HiddenObject two(ShapeSpec{std::vector<ShapeSpec>{ball, other}});
    TriangleMesh mesh = sphere_mesh(1.0, 4);
    // The other ball is missing: its far point is 6 from the origin, 5 from the mesh.
    EXPECT_NEAR(measure_truth(two, mesh, {}, kSeed).hausdorff, 5.0, 0.01);
    // A vertex that is 0.7 out.
    TriangleMesh spiked = mesh;
    spiked.points[0] *= 1.7;
    EXPECT_NEAR(measure_truth(one, spiked, {}, kSeed).hausdorff, 0.7, 1e-12);
    // Without the octant around (1, 1, 1), whose middle is farthest from the rim.
    TriangleMesh open = mesh;
    std::erase_if(open.triangles,
                  [&](const auto& t) { return (open.points[t[0]] + open.points[t[1]] + open.points[t[2]]).minCoeff() > 0.0; });
    const Point middle = Point::Ones().normalized();
    const double expected = (middle - Vector(1.0, 1.0, 0.0).normalized()).norm();
    EXPECT_NEAR(measure_truth(one, open, {}, kSeed).hausdorff, expected, 0.01);
    EXPECT_LT(measure_truth(one, mesh, {}, kSeed).hausdorff, 0.01);
}

TEST(TruthTest, AMeshMatchesItselfAndAnEmptyResultIsInfinitelyFar) {
    const HiddenObject bunny(MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"});
    const MeshObject mesh({std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"});
    const Truth same = measure_truth(bunny, mesh.mesh(), {}, kSeed);
    EXPECT_LE(same.hausdorff, 1e-13 * bunny.scale());
    EXPECT_EQ(same.area, mesh.area());
    EXPECT_FALSE(same.reach);
    std::mt19937_64 random(kSeed);
    EXPECT_NEAR(sample_surface(bunny, 100'000, random).area / mesh.area(), 1.0, 0.015);
    const Truth none = measure_truth(bunny, {}, {}, kSeed);
    EXPECT_TRUE(std::isinf(none.hausdorff));
    EXPECT_TRUE(std::isinf(none.mean_distance));
    EXPECT_EQ(none.area, mesh.area());
}

TEST(TruthTest, SameSeedSameTruthAndBrokenMeshesAreRefused) {
    const HiddenObject torus(ShapeSpec{TorusSpec{1.0, 0.4}});
    const TriangleMesh mesh = sphere_mesh(1.2, 2);
    const TruthSampling few{2000, 2000};
    EXPECT_EQ(measure_truth(torus, mesh, few, 1).mean_distance, measure_truth(torus, mesh, few, 1).mean_distance);
    EXPECT_NE(measure_truth(torus, mesh, few, 1).mean_distance, measure_truth(torus, mesh, few, 2).mean_distance);
    TriangleMesh broken = mesh;
    broken.triangles[0][1] = 9999;
    EXPECT_THROW((void)measure_truth(torus, broken, few, 1), ObjectError);
    broken = mesh;
    broken.points[0].x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)measure_truth(torus, broken, few, 1), ObjectError);
}

TEST(TruthTest, UniformNumbersAreTheSameEverywhere) {
    std::mt19937_64 random(5489);  // its first number is set down in the C++ standard's family of engines
    const double first = uniform(random);
    EXPECT_EQ(first, static_cast<double>(14514284786278117030ULL >> 11U) * 0x1p-53);
}

}  // namespace
}  // namespace palpate::truth_test
