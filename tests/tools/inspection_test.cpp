#include "tools/inspection.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/random.h"

namespace palpate::inspection_test {
namespace {

// A box with nothing symmetric about it but itself, of many triangles, as a reference; the same as a part.
const ShapeSpec kBox{RoundedBoxSpec{{6, 4, 3}, 0.5}};

Inspected points_on(const HiddenObject& object, std::size_t count, Random& random) {
    Inspected part;
    while (part.samples.size() < count) {
        const Point from = 10 * random.direction();
        const Point p = object.closest_point(from);
        part.samples.push_back(p);
        part.normals.push_back((from - p).normalized());
    }
    return part;
}

TEST(Inspection, PointsOfTheReferenceDeviateByNothing) {
    Random random(1);
    const HiddenObject box(kBox);
    const Deviations found = deviations_from(box, points_on(box, 500, random), {}, 1000);
    for (const double d : found.at_samples) EXPECT_NEAR(d, 0, 1e-12);
}

TEST(Inspection, OutsideIsPositive) {
    const HiddenObject box(kBox);
    Inspected part;
    part.samples = {{0, 0, 1.7}, {0, 0, 1.4}, {3.25, 0, 0}};
    const Deviations found = deviations_from(box, part, {}, 1);
    EXPECT_NEAR(found.at_samples[0], 0.2, 1e-12);
    EXPECT_NEAR(found.at_samples[1], -0.1, 1e-12);
    EXPECT_NEAR(found.at_samples[2], 0.25, 1e-12);
}

TEST(Inspection, AKnownMotionIsFoundAndTakenBack) {
    Random random(2);
    const HiddenObject box(kBox);
    for (int k = 0; k < 20; ++k) {
        Inspected part = points_on(box, 300, random);
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(random.uniform(0, 0.15), random.direction()).toRotationMatrix();
        const Vector shift = random.uniform(0, 0.3) * random.direction();
        for (Point& p : part.samples) p = turn * p + shift;
        for (Vector& n : part.normals) n = turn * n;
        const auto fit = best_fit(box, part);
        ASSERT_TRUE(fit) << k;
        EXPECT_LT((fit->rotation * turn - Eigen::Matrix3d::Identity()).norm(), 1e-9) << k;
        EXPECT_LT((*fit)(shift).norm(), 1e-9) << k;
        const DeviationSummary sum = summarize(deviations_from(box, part, *fit, 1).at_samples);
        EXPECT_LT(sum.largest(), 1e-9);
        EXPECT_GT(summarize(deviations_from(box, part, {}, 1).at_samples).largest(), 0.001) << "as it was placed";
    }
}

// The fit is that of least squares: no motion near it is better.
TEST(Inspection, NoMotionNearTheFitIsBetter) {
    Random random(3);
    const HiddenObject box(kBox);
    Inspected part = points_on(box, 400, random);
    for (std::size_t k = 0; k < part.samples.size(); ++k) part.samples[k] += random.uniform(-0.05, 0.08) * part.normals[k];
    const auto fit = best_fit(box, part);
    ASSERT_TRUE(fit);
    const auto rms = [&](const RigidMotion& motion) { return summarize(deviations_from(box, part, motion, 1).at_samples).rms; };
    const double best = rms(*fit);
    for (int k = 0; k < 200; ++k) {
        RigidMotion other = *fit;
        other.rotation = Eigen::AngleAxisd(1e-3 * random.uniform(-1, 1), random.direction()).toRotationMatrix() * fit->rotation;
        other.translation += 2e-3 * random.uniform(0, 1) * random.direction();
        EXPECT_GE(rms(other), best - 1e-9);
    }
}

// A ball is held by no turn.
TEST(Inspection, WhatNothingHoldsIsHardlyTurned) {
    Random random(4);
    const HiddenObject ball(ShapeSpec{SphereSpec{5}});
    Inspected part = points_on(ball, 200, random);
    for (Point& p : part.samples) p += Vector(0.2, -0.1, 0.3);
    const auto fit = best_fit(ball, part);
    ASSERT_TRUE(fit);
    EXPECT_LT(summarize(deviations_from(ball, part, *fit, 1).at_samples).largest(), 1e-9);
    EXPECT_LT(fit->degrees(), 1) << "any turn would do";
    part.samples.resize(5);
    EXPECT_FALSE(best_fit(ball, part));
}

TEST(Inspection, FacetsCountByTheirArea) {
    const HiddenObject ball(ShapeSpec{SphereSpec{1}});
    Inspected part;
    part.facets.points = {{0, 0, 2}, {3, 0, 2}, {0, 3, 2}, {0, 0, 1.5}, {0.03, 0, 1.5}, {0, 0.03, 1.5}};
    part.facets.triangles = {{0, 1, 2}, {3, 4, 5}};
    const Deviations found = deviations_from(ball, part, {}, 10'000);
    const auto of_small = std::ranges::count_if(found.at_facets, [](double d) { return d < 0.6; });
    EXPECT_EQ(of_small, 1);
    EXPECT_NEAR(static_cast<double>(found.at_facets.size()), 10'000, 200);
    EXPECT_TRUE(std::ranges::is_sorted(found.at_facets));
}

TEST(Inspection, HistogramsLoseNothing) {
    Random random(5);
    std::vector<double> values;
    for (int k = 0; k < 1000; ++k) values.push_back(random.uniform(-1, 1));
    values.insert(values.end(), {-1, 1, 0});
    const auto counts = histogram(values, 1, 15);
    std::size_t sum = 0;
    for (const std::size_t c : counts) sum += c;
    EXPECT_EQ(sum, values.size());
    EXPECT_EQ(histogram(std::vector<double>{0, 0}, 0, 3), (std::vector<std::size_t>{0, 2, 0}));
}

}  // namespace
}  // namespace palpate::inspection_test
