#include "planner/loop/fold.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::fold_test {
namespace {

// The first plane is z = 0; the second goes down (convex) or up (concave) from x = 1, at that angle to it.
Fold crease(double degrees) {
    const double angle = degrees * std::acos(-1.0) / 180;
    const Vector beyond(std::cos(angle), 0, -std::sin(angle));
    const Vector normal(std::sin(angle), 0, std::cos(angle));
    return *Fold::between({0.2, 0, 0}, Vector::UnitZ(), Point(1, 0.3, 0) + 0.5 * beyond, normal);
}

TEST(Fold, TurnsWhatIsPastTheCreaseOntoTheSecondPlane) {
    for (const double degrees : {30.0, 90.0, 150.0, -30.0, -90.0, -150.0}) {
        const Fold fold = crease(degrees);
        const double angle = degrees * std::acos(-1.0) / 180;
        EXPECT_NEAR(fold.past({0.4, 5, 0}), -0.6, 1e-12);
        EXPECT_NEAR(fold.past({1.7, -2, 0}), 0.7, 1e-12);
        const Point on = fold.fold({1.7, -2, 0});
        EXPECT_LT((on - Point(1 + 0.7 * std::cos(angle), -2, -0.7 * std::sin(angle))).norm(), 1e-12) << degrees;
        EXPECT_LT((fold.unfold(on) - Point(1.7, -2, 0)).norm(), 1e-12);
    }
}

TEST(Fold, KeepsDistancesOnTheSecondPlane) {
    const Fold fold = crease(70);
    const Point a(1.3, 0.5, 0);
    const Point b(2, -1, 0);
    EXPECT_NEAR((fold.fold(a) - fold.fold(b)).norm(), (a - b).norm(), 1e-12);
}

TEST(Fold, ThereIsNoneWithoutACrease) {
    EXPECT_FALSE(Fold::between({0, 0, 0}, Vector::UnitZ(), {1, 0, 0}, Vector(0.1, 0, 1).normalized())) << "nearly one plane";
    // The second sample is above the first plane, the first below the second's: an S, not a crease.
    EXPECT_FALSE(Fold::between({0, 0, 0}, Vector::UnitZ(), {1, 0, 0.1}, Vector(1, 0, 0)));
}

}  // namespace
}  // namespace palpate::fold_test
