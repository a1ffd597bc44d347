// A tool with a body on a virtual machine.
#include <gtest/gtest.h>

#include "sim/machines/grbl/loopback_stream.h"
#include "sim/machines/grbl/virtual_grbl.h"
#include "sim/tool/tool_audit.h"
#include "sim/tool/tool_obstacle.h"
#include "tests/sim/tool/tool_worlds.h"

namespace palpate::virtual_tool_body_test {
namespace {

using Guard = VirtualTool::Guard;
using Part = ToolContact::Part;
using Met = ToolContact::Met;

class ToolBody : public testing::Test {
protected:
    ToolBody() {
        options.start = Point(-3, 0, 4);
        options.limits = {Point::Constant(-50), Point::Constant(50)};
        options.motion.overtravel_mm = 0.3;
        options.motion.resolution_mm = 1e-6;
        options.on_move = [this](const Segment& way, bool touched) { audit.record(way, touched); };
    }

    HiddenObject object{block_with_roof()};
    std::vector<Fixture> fixtures{Table{-1}};
    ToolObstacle obstacle{object, slim_probe(), fixtures};
    ToolDepths depths{object, slim_probe(), fixtures};
    ToolAudit audit{depths, 0.3};
    VirtualToolOptions options;
};

TEST_F(ToolBody, ClosesWhereAnyPartTouchesAndOpensOnTheWayBack) {
    VirtualTool tool(obstacle, options);
    tool.start_move({-3, 0, -5}, 5, Guard::until_contact);
    tool.finish();
    ASSERT_TRUE(tool.trigger());
    EXPECT_NEAR(tool.trigger()->z(), -0.8, 1e-6);
    EXPECT_LT(tool.position().z(), -0.8) << "it needs a way to stop";
    EXPECT_TRUE(tool.is_probe_closed());
    tool.start_move({-3, 0, 4}, 5, Guard::until_release);
    tool.finish();
    EXPECT_NEAR(tool.trigger().value().z(), -0.8, 1e-6) << "where it closed";
    EXPECT_FALSE(tool.is_probe_closed());
    tool.start_move({-3, 0, 1}, 5, Guard::until_contact);
    tool.finish();
    tool.start_move({5, 0, 1}, 5, Guard::until_contact);
    tool.finish();
    EXPECT_NEAR(tool.trigger().value().x(), 0.4, 1e-6) << "the stylus at the roof";
    tool.start_move({-3, 0, 1}, 5, Guard::until_release);
    tool.finish();
    EXPECT_NEAR(tool.trigger().value().x(), 0.4, 1e-6);
    EXPECT_EQ(tool.audit().unsafe_moves, 0U);
    EXPECT_EQ(audit.account().unsafe_moves, 0U);
    EXPECT_EQ(audit.account().touches(Part::ball, Met::fixture), 1U);
    EXPECT_EQ(audit.account().touches(Part::stylus, Met::object), 1U);
    EXPECT_NEAR(tool.audit().deepest_mm, audit.account().deepest.deepest(), 0.02);
}

TEST_F(ToolBody, AProbeThatIsDeadIsSeenByBothAccounts) {
    VirtualTool tool(obstacle, options);
    tool.set_unplugged(true);
    tool.start_move({-3, 0, 1}, 5, Guard::until_contact);
    tool.finish();
    tool.start_move({5, 0, 1}, 5, Guard::until_contact);
    tool.finish();
    EXPECT_FALSE(tool.trigger());
    EXPECT_EQ(tool.audit().unsafe_moves, 1U);
    EXPECT_EQ(audit.account().moves_into_object, 1U);
    EXPECT_EQ(audit.account().moves_into_fixtures, 0U);
}

TEST_F(ToolBody, BehindGrblTheBallMeetsTheTableAndTheShankTheOverhang) {
    options.motion.resolution_mm = 1e-3;
    VirtualTool tool(obstacle, options);
    VirtualGrbl grbl(tool, VirtualGrblOptions{});
    LoopbackStream stream(grbl);
    const auto ask = [&](const std::string& line) {
        stream.write(line + "\n");
        std::string answer;
        while (answer.find("ok") == std::string::npos) {
            const std::string more = stream.read(std::chrono::seconds(30));
            if (more.empty()) break;
            answer += more;
        }
        return answer;
    };
    EXPECT_NE(ask("G38.2 Z-5 F120").find("[PRB:-3.000,0.000,-0.800:1]"), std::string::npos);
    (void)ask("G0 Z1");
    EXPECT_NE(ask("G38.2 X5 F120").find("[PRB:0.400,0.000,1.000:1]"), std::string::npos);
    (void)ask("G0 X-3");
    (void)ask("G4 P0.1");
    EXPECT_EQ(tool.audit().unsafe_moves, 0U);
    EXPECT_EQ(audit.account().unsafe_moves, 0U);
    EXPECT_EQ(audit.account().touches(Part::ball, Met::fixture), 1U);
    EXPECT_EQ(audit.account().touches(Part::stylus, Met::object), 1U);
}

}  // namespace
}  // namespace palpate::virtual_tool_body_test
