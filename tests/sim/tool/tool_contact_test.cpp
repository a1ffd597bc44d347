#include "sim/tool/tool_contact.h"

#include <gtest/gtest.h>

#include "tests/random.h"

namespace palpate::tool_contact_test {
namespace {

using Part = ToolContact::Part;
using Met = ToolContact::Met;

// A block from -1 to 1 in x and y, its top at z = 0; above it, from x = 0.5 on, a roof from z = 2 to 3.
std::vector<GrownTriangles> block_with_roof() {
    TriangleMesh mesh;
    const auto add = [&](const Point& min, const Point& max) {
        const auto first = static_cast<std::uint32_t>(mesh.points.size());
        for (unsigned k = 0; k < 8; ++k) {
            mesh.points.emplace_back((k & 1U ? max : min).x(), (k & 2U ? max : min).y(), (k & 4U ? max : min).z());
        }
        for (const auto& q :
             {std::array{0U, 2U, 3U, 1U}, {4U, 5U, 7U, 6U}, {0U, 1U, 5U, 4U}, {2U, 6U, 7U, 3U}, {0U, 4U, 6U, 2U}, {1U, 3U, 7U, 5U}}) {
            mesh.triangles.push_back({first + q[0], first + q[1], first + q[2]});
            mesh.triangles.push_back({first + q[0], first + q[2], first + q[3]});
        }
    };
    add({-1, -1, -1}, {1, 1, 0});
    add({0.5, -1, 2}, {1, 1, 3});
    return {{mesh, 0.0}};
}

ToolShape probe() {
    ToolShape tool;
    tool.ball_diameter = 0.4;
    tool.stylus = ToolShape::Shaft{0.2, 5};
    tool.holder = ToolShape::Shaft{2, 10};
    return tool;
}

TEST(ToolContact, TheBallTouchesARadiusAboveTheTop) {
    const ToolWorld world(block_with_roof(), {}, {});
    const auto met = world.first_contact(probe(), {{-0.5, 0, 1}, {-0.5, 0, -1}});
    ASSERT_TRUE(met);
    EXPECT_NEAR(1 - 2 * met->at, 0.2, 1e-12);
    EXPECT_EQ(met->part, Part::ball);
    EXPECT_EQ(met->met, Met::object);
}

TEST(ToolContact, UnderARoofTheStylusTouchesFirst) {
    const ToolWorld world(block_with_roof(), {}, {});
    // Between block and roof, towards the roof's side at x = 0.5.
    const auto met = world.first_contact(probe(), {{-0.5, 0, 1}, {1.5, 0, 1}});
    ASSERT_TRUE(met);
    EXPECT_NEAR(-0.5 + 2 * met->at, 0.5 - 0.1, 1e-12) << "the stylus' radius before it";
    EXPECT_EQ(met->part, Part::stylus);
    ToolShape floating = probe();
    floating.stylus.reset();
    floating.holder.reset();
    EXPECT_FALSE(world.first_contact(floating, {{-0.5, 0, 1}, {1.5, 0, 1}}));
}

TEST(ToolContact, AHolderThatIsTooLowTouchesFirst) {
    ToolShape stubby = probe();
    stubby.stylus->length = 1;
    const ToolWorld world(block_with_roof(), {}, {});
    // Beside the roof, where only the holder is wide enough to touch it.
    const auto met = world.first_contact(stubby, {{-0.2, 0, 3}, {-0.2, 0, 0.3}});
    ASSERT_TRUE(met);
    EXPECT_EQ(met->part, Part::holder);
    // Its round end begins at 1 above the ball, its centre a radius higher: 0.7 beside the roof's upper edge.
    EXPECT_NEAR(3 - 2.7 * met->at + 2, 3 + std::sqrt(1 - 0.7 * 0.7), 1e-9);
}

TEST(ToolContact, FixturesAreToldFromTheObject) {
    const ToolWorld world(block_with_roof(), {{{0, 0, -1}, Vector::UnitZ()}}, {{{2, -1, -1}, {3, 1, 0.5}}});
    const auto table = world.first_contact(probe(), {{-2, 0, 1}, {-2, 0, -2}});
    ASSERT_TRUE(table);
    EXPECT_EQ(table->met, Met::fixture);
    EXPECT_NEAR(1 - 3 * table->at, -0.8, 1e-12);
    const auto clamp = world.first_contact(probe(), {{1.5, 0, -0.3}, {3, 0, -0.3}});
    ASSERT_TRUE(clamp);
    EXPECT_EQ(clamp->met, Met::fixture);
    EXPECT_NEAR(1.5 + 1.5 * clamp->at, 1.8, 1e-12);
}

TEST(ToolContact, AToolThatIsNoneIsRefused) {
    const ToolWorld world(block_with_roof(), {}, {});
    ToolShape tool = probe();
    tool.ball_diameter = 0;
    EXPECT_THROW((void)world.first_contact(tool, {{0, 0, 5}, {0, 0, -5}}), std::invalid_argument);
    tool.ball_diameter = 0.1;
    EXPECT_THROW((void)world.first_contact(tool, {{0, 0, 5}, {0, 0, -5}}), std::invalid_argument);
}

// Tilted tools are upright ones in a tilted world.
TEST(ToolContact, TheAxisMayPointAnywhere) {
    Random random(3);
    for (int k = 0; k < 300; ++k) {
        const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(Vector::UnitZ(), random.direction()).toRotationMatrix();
        std::vector<GrownTriangles> turned = block_with_roof();
        for (Point& p : turned.front().triangles.points) p = turn * p;
        ToolShape tilted = probe();
        tilted.axis = turn * Vector::UnitZ();
        const Segment move{3 * random.direction() + Point(0, 0, 3), random.direction()};
        const auto upright = ToolWorld(block_with_roof(), {}, {}).first_contact(probe(), move);
        const auto met = ToolWorld(turned, {}, {}).first_contact(tilted, {turn * move.source, turn * move.target});
        ASSERT_EQ(met.has_value(), upright.has_value()) << k;
        if (met) {
            EXPECT_NEAR(met->at, upright->at, 1e-9) << k;
            EXPECT_EQ(met->part, upright->part) << k;
        }
    }
}

}  // namespace
}  // namespace palpate::tool_contact_test
