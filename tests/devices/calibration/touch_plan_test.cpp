#include "devices/calibration/touch_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/devices/calibration/sphere_device.h"
#include "tests/devices/message_of.h"

namespace palpate::touch_plan_test {
namespace {

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

TEST(TouchPlan, DirectionsAreIso10360sPattern) {
    const std::vector<Vector> directions = iso_directions(Vector::UnitZ());
    ASSERT_EQ(directions.size(), 25U);
    const auto check_ring = [&](std::size_t first, std::size_t count, double elevation, double turn) {
        for (std::size_t k = 0; k < count; ++k) {
            const Vector& n = directions[first + k];
            EXPECT_NEAR(n.norm(), 1, 1e-12);
            EXPECT_NEAR(degrees(std::asin(n.z())), elevation, 1e-9);
            const double azimuth = turn + 360.0 * static_cast<double>(k) / static_cast<double>(count);
            EXPECT_NEAR(std::remainder(degrees(std::atan2(n.y(), n.x())) - azimuth, 360), 0, 1e-9);
        }
    };
    EXPECT_EQ(directions[0], Vector::UnitZ());
    check_ring(1, 4, 67.5, 0);
    check_ring(5, 8, 45, 22.5);
    check_ring(13, 4, 22.5, 45);
    check_ring(17, 8, 0, 67.5);
}

TEST(TouchPlan, DirectionsAreAroundAnyAxisAndApart) {
    for (const Vector& axis : {Vector(0, 0, 1), Vector(1, 0, 0), Vector(0.6, 0, -0.8), Vector(0, -1, 0)}) {
        for (const std::size_t count : {25U, 26U, 37U, 50U}) {
            const std::vector<Vector> directions = qualification_directions(axis, count);
            ASSERT_EQ(directions.size(), count);
            for (const Vector& n : directions) {
                EXPECT_NEAR(n.norm(), 1, 1e-12);
                EXPECT_GE(n.dot(axis), -1e-12);
            }
        }
    }
}

// mm: of the way from the sphere's centre.
double least_distance(const Point& from, const Point& to, const Point& center) { return distance_to({from, to}, center); }

TEST(TouchPlan, WaysGoAroundTheSphereAboveItsEquator) {
    constexpr std::uint64_t kSeed = 21;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int turn = 0; turn < 50; ++turn) {
        ToolShape tool = test_tool();
        tool.axis = random.direction();
        const ReferenceSphere sphere{random.in_box(Point::Constant(-50), Point::Constant(50)), random.uniform(10, 40)};
        const TouchMargins margins{random.uniform(0.1, 1), random.uniform(1, 5)};
        Vector start = random.direction();
        if (start.dot(tool.axis) < 0) start = -start;
        Point at = sphere.center + random.uniform(25, 60) * start;
        std::vector<Vector> directions = qualification_directions(tool.axis, 40);
        // From one end to the other, too.
        directions.push_back(directions[17]);
        directions.emplace_back(-directions[17] + 2 * directions[17].dot(tool.axis) * tool.axis);
        const TouchPlan plan = plan_touches(sphere, tool, margins, at, directions);
        ASSERT_EQ(plan.touches.size(), directions.size());
        const double free = farthest_touch(sphere, tool, margins) + margins.clearance_mm - 1e-9;
        const auto check = [&](const Point& to) {
            EXPECT_GE(least_distance(at, to, sphere.center), free);
            EXPECT_GE((to - sphere.center).dot(tool.axis), -1e-6);
            at = to;
        };
        for (std::size_t k = 0; k < plan.touches.size(); ++k) {
            const PlannedTouch& touch = plan.touches[k];
            ASSERT_FALSE(touch.way.empty());
            for (const Point& p : touch.way) check(p);
            EXPECT_NEAR(((at - sphere.center).normalized() - directions[k]).norm(), 0, 1e-9) << "begins on the normal";
            EXPECT_NEAR(((touch.target - sphere.center).normalized() - directions[k]).norm(), 0, 1e-9) << "goes to the centre";
            EXPECT_NEAR((touch.target - sphere.center).norm(), touched_distance(sphere, tool) - margins.center_error_mm - kMostPretravel_mm,
                        1e-9);
        }
        for (const Point& p : plan.leave) check(p);
        EXPECT_NEAR(((at - sphere.center).normalized() - tool.axis).norm(), 0, 1e-6) << "ends above the pole";
    }
}

TEST(TouchPlan, RefusesWhatMakesNoSense) {
    const auto message = [](const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins, const Point& from,
                            const std::vector<Vector>& directions) {
        return message_of<QualificationError>([&] { static_cast<void>(plan_touches(sphere, tool, margins, from, directions)); });
    };
    const ReferenceSphere sphere{Point::Zero(), kSphere};
    const Point above(0, 0, 40);
    const std::vector<Vector> iso = iso_directions(Vector::UnitZ());
    expect_says(message({Point::Zero(), 0}, test_tool(), {}, above, iso), "the sphere's diameter is 0 mm, it has to be positive");
    expect_says(message(sphere, {}, {}, above, iso), "the ball's diameter is 0 mm");
    expect_says(message(sphere, test_tool(), {0, 2}, above, iso), "the error of the sphere's centre is 0 mm");
    expect_says(message(sphere, test_tool(), {0.5, -1}, above, iso), "the clearance around the sphere is -1 mm");
    expect_says(message(sphere, test_tool(), {}, Point(0, 0, 13), iso), "the tool has to stand above the sphere's equator");
    expect_says(message(sphere, test_tool(), {}, Point(0, 30, -1), iso), "the tool has to stand above the sphere's equator");
    expect_says(message(sphere, test_tool(), {}, above, {Vector(0, 0.8, -0.6)}), "below the equator");
    expect_says(message(sphere, test_tool(), {}, above, {Vector(0, 0, 2)}), "no unit vector");
    ToolShape short_tool = test_tool();
    short_tool.stylus->length = 30;
    expect_says(message(sphere, short_tool, {}, above, iso), "the holder (40 mm) would touch the sphere (25 mm)");
}

}  // namespace
}  // namespace palpate::touch_plan_test
