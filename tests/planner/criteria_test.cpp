#include "planner/criteria.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace palpate::criteria_test {
namespace {

const Point kHere = Point::Zero();

Criteria criteria(double epsilon, double floor) {
    Options options;
    options.epsilon = epsilon;
    options.refinement_floor = floor;
    return Criteria(options);
}

TEST(Criteria, ABallIsBadIfItIsLargerThanEpsilon) {
    const Criteria c = criteria(2, 0.125);
    EXPECT_FALSE(c.is_bad(0, kHere));
    EXPECT_FALSE(c.is_bad(2, kHere)) << "I3 allows equality";
    EXPECT_TRUE(c.is_bad(std::nextafter(2, 3), kHere));
}

TEST(Criteria, RepairGoesDownToTheFloor) {
    const Criteria c = criteria(2, 0.125);
    EXPECT_TRUE(c.may_repair(0.2501));
    EXPECT_FALSE(c.may_repair(0.25));
    EXPECT_FALSE(c.may_repair(0.1));
    EXPECT_FALSE(criteria(2, 1).may_repair(2)) << "a floor of 1: no extra refinement";
}

TEST(Criteria, WhateverIsRefinedKeepsItsSpacing) {
    const Criteria c = criteria(3, 0.25);
    EXPECT_LE(c.spacing(kHere), 3);
    EXPECT_NEAR(c.spacing(kHere), 3, 1e-8);
    EXPECT_LE(c.repair_spacing(), 0.75);
    EXPECT_NEAR(c.repair_spacing(), 0.75, 1e-8);
    // A ball that is refined is empty, so its centre is its radius away from all samples.
    for (const double radius : {std::nextafter(3, 4), 3.1, 100.0}) {
        ASSERT_TRUE(c.is_bad(radius, kHere));
        EXPECT_GE(radius, c.spacing(kHere));
    }
    EXPECT_TRUE(c.may_repair(std::nextafter(0.75, 1)));
    EXPECT_GE(std::nextafter(0.75, 1), c.repair_spacing());
}

TEST(Criteria, SizesGrowAwayFromRegionsUpToEpsilon) {
    Options options;
    options.epsilon = 2;
    options.sizing.regions = {{Box{{0, 0, 0}, {1, 1, 1}}, 0.5, 0.25}, {Box{{9, 0, 0}, {9, 0, 0}}, 1, 1}};
    const Criteria c(options);
    EXPECT_DOUBLE_EQ(c.size_at({0.5, 1, 0}), 0.5);
    EXPECT_DOUBLE_EQ(c.size_at({3, 0.5, 0.5}), 1.0);
    EXPECT_DOUBLE_EQ(c.size_at({4, 5, 1}), 0.5 + 0.25 * 5) << "by Euclid, to the nearest place of the box";
    EXPECT_DOUBLE_EQ(c.size_at({9, 0.5, 0}), 1.5);
    EXPECT_DOUBLE_EQ(c.size_at({100, 0, 0}), 2);
    EXPECT_TRUE(c.is_bad(1.1, {3, 0.5, 0.5}));
    EXPECT_FALSE(c.is_bad(1.1, {100, 0, 0}));
    EXPECT_LE(c.least_spacing(), 0.25);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-3, 12);
    for (int k = 0; k < 1000; ++k) {
        const Point p(coordinate(random), coordinate(random), coordinate(random));
        const Point q(coordinate(random), coordinate(random), coordinate(random));
        ASSERT_LE(std::abs(c.size_at(p) - c.size_at(q)), (p - q).norm() * (1 + 1e-12)) << "1-Lipschitz (thesis 5.4)";
    }
}

TEST(Criteria, SkinnyIsByTheSmallestAngle) {
    Options options;
    options.epsilon = 1;
    EXPECT_FALSE(Criteria(options).is_skinny({0, 0, 0}, {1, 0, 0}, {0.5, 1e-6, 0})) << "not asked for";
    options.min_angle = std::numbers::pi / 6;
    const Criteria c(options);
    EXPECT_FALSE(c.is_skinny({0, 0, 0}, {1, 0, 0}, {0.5, 0.87, 0}));
    EXPECT_TRUE(c.is_skinny({0, 0, 0}, {1, 0, 0}, {0.5, 0.2, 0}));
    EXPECT_TRUE(c.is_skinny({0, 0, 0}, {1, 0, 0}, {0, 0.57, 0})) << "29.7 degrees";
    EXPECT_FALSE(c.is_skinny({0, 0, 0}, {1, 0, 0}, {0, 0.58, 0})) << "30.1 degrees";
}

}  // namespace
}  // namespace palpate::criteria_test
