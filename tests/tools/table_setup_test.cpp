#include "tools/table_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "config/reader.h"
#include "devices/errors.h"
#include "tests/random.h"

namespace palpate::table_setup_test {
namespace {

SessionConfig config_with(const std::string& tool, const std::string& more = "") {
    return read_config_text("machine: {grbl: {port: /dev/x}, limits: {min: [-90, -90, -9], max: [90, 90, 90]}, noise: 0.01}\ntool: " +
                                tool + "\nprobing: {epsilon: 2}\n" + more,
                            "part.yaml");
}

TEST(TableSetup, APlaneIsFoundFromWhatABallTouches) {
    constexpr std::uint64_t kSeed = 5;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int k = 0; k < 100; ++k) {
        const Vector normal = Vector(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 1).normalized();
        const double height = random.uniform(-5, 5);
        const double radius = random.uniform(0.5, 4);
        std::array<Point, 3> touched;
        for (std::size_t i = 0; i < 3; ++i) {
            const double x = 40 * std::cos(2.1 * static_cast<double>(i));
            const double y = 40 * std::sin(2.1 * static_cast<double>(i));
            touched.at(i) = {x, y, height + (radius - normal.x() * x - normal.y() * y) / normal.z()};
        }
        std::swap(touched[0], touched[static_cast<std::size_t>(k % 3)]);  // in any order
        const TablePlane table = table_through(touched, radius);
        EXPECT_LT((table.normal - normal).norm(), 1e-12);
        EXPECT_NEAR(table.height(0, 0), height, 1e-12);
        for (const Point& p : touched) EXPECT_NEAR(table.touched_height(p.x(), p.y(), radius), p.z(), 1e-12);
    }
}

TEST(TableSetup, PlacesThatTellNoPlaneAreRefused) {
    EXPECT_THROW((void)table_through({Point(0, 0, 0), Point(50, 0, 0), Point(100, 5, 0)}, 1), SetupError);
    EXPECT_THROW((void)table_through({Point(0, 0, 0), Point(0, 0, 0), Point(0, 0, 0)}, 1), SetupError);
    EXPECT_THROW((void)table_through({Point(0, 0, 0), Point(50, 0, 0), Point(0, 50, 5)}, 1), SetupError);
    EXPECT_NO_THROW((void)table_through({Point(0, 0, 0), Point(50, 0, 0), Point(0, 50, 4)}, 1));
}

TEST(TableSetup, ATableIsAHalfSpaceOnceItsTiltShowsInTouches) {
    const SessionConfig config = config_with("{ball: {diameter: 2}}");  // touches are off by 0.012 mm
    const Box part{{-10, -10, 0}, {10, 10, 20}};
    for (const double rise : {0.0, 0.008, 0.016}) {  // over the workspace, 34 mm wide
        const TablePlane table{Vector(-rise, 0, 34).normalized(), Point::Zero()};
        const TableSetup setup = propose_setup(config, table, part, {}, 1, 6);
        EXPECT_NEAR(table.rise_over(setup.workspace), rise, 1e-6);
        EXPECT_EQ(setup.is_tilted, rise > 0.012);
        EXPECT_EQ(std::holds_alternative<Table>(setup.solids.at(0)), rise < 0.012);
        EXPECT_LE(setup.workspace.min.z(), -rise / 2);
    }
}

TEST(TableSetup, TheWorkspaceHoldsWhatBallAndHolderTouch) {
    const TablePlane table;
    const Box part{{-10, -10, 0}, {10, 10, 20}};
    const auto workspace = [&](const std::string& tool) { return propose_setup(config_with(tool), table, part, {}, 1, 6).workspace; };
    EXPECT_EQ(workspace("{ball: {diameter: 2}}").max, Point(17, 17, 27));
    const std::string stylus = "{ball: {diameter: 2}, stylus: {diameter: 1, length: ";
    EXPECT_EQ(workspace(stylus + "40}, holder: {diameter: 30, length: 50}}").max, Point(17, 17, 27));
    EXPECT_EQ(workspace(stylus + "20}, holder: {diameter: 30, length: 50}}").max, Point(31, 31, 27)) << "the holder comes beside the part";
}

TEST(TableSetup, RaysStartOutsideMeetThePartAndAreApart) {
    const SessionConfig config = config_with("{ball: {diameter: 2}}");
    const Box part{{-10, -10, 0}, {10, 10, 20}};
    const std::vector<PartTouch> touches = {{-Vector::UnitZ(), {0, 0, 21}},
                                            {Vector::UnitX(), {-11, 0, 8}},
                                            {-Vector::UnitX(), {11, 0, 8}},
                                            {Vector::UnitY(), {0, -11, 8}},
                                            {-Vector::UnitZ(), {1, 1, 21}}};
    const TableSetup setup = propose_setup(config, TablePlane{}, part, touches, 1, 6);
    ASSERT_EQ(setup.seed_rays.size(), 4U) << "the last is beside the first";
    for (std::size_t k = 0; k < 4; ++k) {
        const Segment& ray = setup.seed_rays[k];
        EXPECT_FALSE(setup.workspace.contains(ray.source));
        EXPECT_TRUE(setup.workspace.contains(ray.target));
        const Vector way = (ray.target - ray.source).normalized();
        EXPECT_LT((way - touches[k].approach).norm(), 1e-9);
        EXPECT_GT(way.dot(ray.target - touches[k].position), 0.5);
    }
    // A thin part: a ray ends in it, not in the table.
    const TableSetup thin = propose_setup(config, TablePlane{}, {{-10, -10, 0}, {10, 10, 0.5}}, {{-Vector::UnitZ(), {0, 0, 1.5}}}, 1, 6);
    EXPECT_NEAR(thin.seed_rays.at(0).target.z(), 1.25, 1e-12);
}

TEST(TableSetup, ClampsStay) {
    const SessionConfig config = config_with(
        "{ball: {diameter: 2}}",
        "workspace:\n  box: {min: [-9, -9, -9], max: [9, 9, 9]}\n  fixtures: [{table: {z: -3}}, {box: {min: [5, 5, 0], max: "
        "[6, 6, 1]}}, {half_space: {point: [-8, 0, 0], normal: [1, 0, 0]}}, {half_space: {point: [0, 0, -2], normal: [0, 0, 1]}}]\n");
    const TableSetup setup = propose_setup(config, TablePlane{}, {{-1, -1, 0}, {1, 1, 1}}, {}, 1, 6);
    ASSERT_EQ(setup.solids.size(), 3U);
    EXPECT_TRUE(std::holds_alternative<Table>(setup.solids[0]));
    EXPECT_TRUE(std::holds_alternative<Box>(setup.solids[1]));
    EXPECT_TRUE(std::holds_alternative<HalfSpace>(setup.solids[2]));
}

}  // namespace
}  // namespace palpate::table_setup_test
