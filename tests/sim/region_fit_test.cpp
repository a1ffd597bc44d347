#include "sim/region_fit.h"

#include <gtest/gtest.h>

#include "sim/objects/errors.h"

namespace palpate::region_fit_test {
namespace {

TEST(WorkspaceFit, AutoContainsTheObject) {
    for (const ObjectSpec& spec :
         {ObjectSpec(MeshSpec{PALPATE_TEST_DATA "/bunny.off", 1.0}), ObjectSpec(ShapeSpec{TorusSpec{1, 0.4}, {3, -2, 5}})}) {
        const HiddenObject object(spec);
        EXPECT_FALSE(point_outside(object, fitting_workspace(object)));
    }
}

TEST(WorkspaceFit, ABallMayTouchTheBoundsCornersOnlyOutside) {
    const HiddenObject sphere{ObjectSpec(ShapeSpec{SphereSpec{1}})};
    EXPECT_FALSE(point_outside(sphere, Region(Ball{Point::Zero(), 1.001}))) << "the bounds stick out, the sphere does not";
    const auto outside = point_outside(sphere, Region(Ball{{0.1, 0, 0}, 1.05}));
    ASSERT_TRUE(outside);
    EXPECT_LT(outside->x(), -0.9);
    EXPECT_NEAR(outside->norm(), 1.0, 1e-9);
    EXPECT_TRUE(point_outside(sphere, Region(Box{{-2, -2, -2}, {2, 2, 0.99}})));
    // What touches the boundary is in the tool's way.
    EXPECT_TRUE(point_outside(sphere, Region(Box{{-1, -1, -1}, {1, 1, 1}})));
    EXPECT_TRUE(point_outside(sphere, Region(Ball{Point::Zero(), 1.0})));
    const HiddenObject cube{ObjectSpec(ShapeSpec{RoundedBoxSpec{{1, 1, 1}, 0}})};
    EXPECT_TRUE(point_outside(cube, Region(Ball{Point::Zero(), 0.8655}))) << "its corners stick out by 0.0005";
    EXPECT_FALSE(point_outside(cube, Region(Ball{Point::Zero(), 0.87})));
}

TEST(WorkspaceFit, TheBunnyIsNotInABallAroundTheOrigin) {
    const HiddenObject bunny{ObjectSpec(MeshSpec{PALPATE_TEST_DATA "/bunny.off", 1.0})};
    EXPECT_TRUE(point_outside(bunny, Region(Ball{Point::Zero(), 9.5})));
    EXPECT_FALSE(point_outside(bunny, Region(Ball{{0, 4.8, 0}, 7.5})));
}

// It was searched for ever: squares of such lengths are beyond any double, and no line met it.
TEST(WorkspaceFit, AnObjectThatNoLineMeetsIsRefused) {
    for (const ShapeSpec& spec : {ShapeSpec{SphereSpec{1e300}}, ShapeSpec{EllipsoidSpec{{1e-200, 1e-200, 50}}}}) {
        const HiddenObject object{ObjectSpec(spec)};
        EXPECT_THROW((void)point_outside(object, Region(Ball{Point::Zero(), 10})), ObjectError);
    }
}

}  // namespace
}  // namespace palpate::region_fit_test
