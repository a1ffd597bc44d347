#include "planner/criteria.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate {
namespace {

Criteria criteria(double epsilon, double floor) {
    Options options;
    options.epsilon = epsilon;
    options.refinement_floor = floor;
    return Criteria(options);
}

TEST(Criteria, ABallIsBadIfItIsLargerThanEpsilon) {
    const Criteria c = criteria(2, 0.125);
    EXPECT_FALSE(c.is_bad(0));
    EXPECT_FALSE(c.is_bad(2)) << "I3 allows equality";
    EXPECT_TRUE(c.is_bad(std::nextafter(2, 3)));
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
    EXPECT_LE(c.spacing(false), 3);
    EXPECT_NEAR(c.spacing(false), 3, 1e-8);
    EXPECT_LE(c.spacing(true), 0.75);
    EXPECT_NEAR(c.spacing(true), 0.75, 1e-8);
    // A ball that is refined is empty, so its centre is its radius away from all samples.
    for (const double radius : {std::nextafter(3, 4), 3.1, 100.0}) {
        ASSERT_TRUE(c.is_bad(radius));
        EXPECT_GE(radius, c.spacing(false));
    }
    EXPECT_TRUE(c.may_repair(std::nextafter(0.75, 1)));
    EXPECT_GE(std::nextafter(0.75, 1), c.spacing(true));
}

}  // namespace
}  // namespace palpate
