// `palpate setup` as a user runs it: on a virtual machine with a part on a table, and the session that comes after it.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <chrono>
#include <numbers>

#include "config/reader.h"
#include "sim/tool/tool_obstacle.h"
#include "tests/tools/session_rig.h"
#include "tests/tools/terminal_rig.h"

namespace palpate::setup_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kTable = 1.25;      // mm
const Point kCorner(-60, -50, -60);  // machine coordinates of the configuration's origin

// A block of 24 x 16 x 10 on a table, before a ball of 2.
class TableMachine {
public:
    explicit TableMachine(const fs::path& link, const Fixture& table = Table{kTable}, VirtualGrblOptions options = {})
        : object_(block()),
          obstacle_(object_, tool(), {table}),
          tool_(obstacle_, axes()),
          grbl_(tool_, homed(std::move(options))),
          host_(grbl_, {link, GrblHostOptions::Time::fast, false}) {}

    [[nodiscard]] VirtualToolAudit audit() {
        VirtualToolAudit audit;
        host_.with([&](VirtualGrbl&) { audit = tool_.audit(); });
        return audit;
    }
    void expect_safe() {
        const VirtualToolAudit seen = audit();
        EXPECT_EQ(seen.unguarded_moves + seen.outside_limits + seen.unsafe_moves + seen.fast_moves_inside, 0U);
    }

private:
    static ObjectSpec block() { return ShapeSpec{RoundedBoxSpec{{24, 16, 10}, 0}, {0, 0, kTable + 5}}; }
    static ToolShape tool() { return {2, ToolShape::Shaft{1.5, 30}, {}, Vector::UnitZ()}; }
    static VirtualToolOptions axes() {
        VirtualToolOptions options;
        options.motion.retract_mm = 0.2;
        options.origin = kCorner;
        options.start = kCorner + Point(3, 4, 30);
        options.limits = {kCorner + Point(-41, -31, -3), Point::Zero()};
        options.probe_feed_mm_per_s = options.motion.feeds.probe_mm_per_s;
        return options;
    }
    static VirtualGrblOptions homed(VirtualGrblOptions options) {
        options.homed_position = axes().start;
        options.soft_limits = true;
        return options;
    }

    HiddenObject object_;
    ToolObstacle obstacle_;
    VirtualTool tool_;
    VirtualGrbl grbl_;
    GrblHost host_;
};

class Setup : public SessionRig {
protected:
    Setup() { write_part("{ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}}"); }

    [[nodiscard]] static std::string text(const std::string& port, const std::string& tool) {
        return "# Of the workshop.\nmachine:\n  grbl: {port: " + port +
               "}   # the blue lead\n  homing: run\n  origin: [-60, -50, -60]\n  limits: {min: [-40, -30, -2], max: [40, 30, 40]}\n"
               "  retract: 0.2\n  probe_proof: first_touch\ntool: " +
               tool + "\nprobing:\n  epsilon: 1.5   # mm\n";
    }
    void write_part(const std::string& tool) const { std::ofstream(folder_ / "part.yaml") << text(port().string(), tool); }
    [[nodiscard]] static std::vector<std::string> setup(const std::vector<std::string>& more) {
        std::vector<std::string> words = {"setup", "part.yaml"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    void expect_unchanged(const std::string& before) const {
        EXPECT_EQ(read("part.yaml"), before);
        EXPECT_FALSE(fs::exists(folder_ / "part.yaml.bak"));
    }
};

TEST_F(Setup, ThePartIsTouchedAroundAndASessionBegins) {
    TableMachine machine(port());
    const std::string before = read("part.yaml");
    ASSERT_EQ(run(setup({"--around", "6", "--yes"})), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), AllOf(HasSubstr("tool        at (3, 4, 30) mm"), HasSubstr("table       z = 1.250 mm"),
                                       HasSubstr("part        (-12, -8, 1.25) mm to (12, 8, 11.25) mm"), HasSubstr("seed rays   5")));
    const std::string after = read("part.yaml");
    EXPECT_EQ(read("part.yaml.bak"), before);
    for (const char* kept :
         {"# Of the workshop.\n", "   # the blue lead\n", "  epsilon: 1.5   # mm\n",
          "  box: {min: [-22, -18, 1.25], max: [22, 18, 21.3]}  # ", "    - table: {z: 1.25}\n", "  seed_rays:  # each has met"}) {
        EXPECT_THAT(after, HasSubstr(kept));
    }
    machine.expect_safe();
    ASSERT_EQ(run({"check", "part.yaml"}), 0) << read("out.txt");
    ASSERT_EQ(run(probe("s")), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("certificate"));
    machine.expect_safe();
    // Again, with what stands in the file replaced.
    ASSERT_EQ(run(setup({"--around", "6", "--margin", "7", "--yes"})), 0) << read("out.txt");
    EXPECT_THAT(read("part.yaml"), AllOf(HasSubstr("  box: {min: [-20, -16, 1.25], max: [20, 16, 19.3]}"), HasSubstr("# the blue lead")));
    EXPECT_EQ(read("part.yaml.bak2"), after);
}

TEST_F(Setup, APartWhoseBoxIsGivenIsTouchedFromAboveAlone) {
    TableMachine machine(port());
    ASSERT_EQ(run(setup({"--box", "-12,-8,1.25,12,8,12", "--table", "-30,-20,30,-20,0,25", "--yes"})), 0) << read("out.txt");
    const SessionConfig config = read_config(folder_ / "part.yaml");
    EXPECT_EQ(config.probing.seed_rays.size(), 1U);
    EXPECT_EQ(std::get<Box>(config.workspace).max.z(), 22.0);
    machine.expect_safe();
}

TEST_F(Setup, TheTableLiesAnEffectiveRadiusBelowTheBallsCentre) {
    TableMachine machine(port());
    ProbeCalibration calibration;
    calibration.date = "2026-01-31";
    calibration.tool = {2, ToolShape::Shaft{1.5, 30}, {}, Vector::UnitZ()};
    calibration.feed_mm_per_s = 5;
    calibration.sphere_diameter_mm = 25;
    calibration.effective_radius_mm = 0.95;
    std::ofstream(folder_ / "probe.json") << to_json(calibration);
    write_part("{ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}, calibration: probe.json}");
    ASSERT_EQ(run(setup({"--around", "6", "--yes"})), 0) << read("out.txt");
    EXPECT_THAT(read("part.yaml"), HasSubstr("- table: {z: 1.3}\n"));
}

TEST_F(Setup, EachMoveIsAskedForAndSoIsTheChange) {
    TableMachine machine(port());
    const std::string before = read("part.yaml");
    TypedAt terminal(folder_, setup({"--around", "6"}), 200);
    const auto answer = [&](const std::string& question, const std::string& text) {
        ASSERT_TRUE(terminal.wait_for(question)) << terminal.said;
        terminal.watch(100ms);
        terminal.said.clear();
        terminal.type(text + "\n");
    };
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    EXPECT_THAT(terminal.said, AllOf(HasSubstr("limits     (-40, -30, -2) mm"), HasSubstr("three places"), HasSubstr("four sides")));
    EXPECT_EQ(machine.audit().moves, 0U);
    answer("let the machine move: ", "yes");
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    EXPECT_THAT(terminal.said,
                AllOf(HasSubstr("touch 1 of 3"), HasSubstr("from (3, 4, 30) mm to (-32, -24, 30) mm, towards (-32, -24, -2) mm")));
    EXPECT_EQ(machine.audit().moves, 0U);
    for (int touch = 0; touch < 8; ++touch) answer("let the machine move: ", "yes");
    ASSERT_TRUE(terminal.wait_for("Type yes to have it changed: ")) << terminal.said;
    EXPECT_THAT(terminal.said, HasSubstr("workspace"));
    expect_unchanged(before);
    terminal.type(TypedAt::kCtrlC);
    EXPECT_EQ(terminal.wait(), 3);
    EXPECT_THAT(terminal.said, HasSubstr("stopped at the question; nothing has changed"));
    expect_unchanged(before);
    machine.expect_safe();
}

TEST_F(Setup, ANoBetweenTouchesEndsItWhereTheToolStands) {
    TableMachine machine(port());
    const std::string before = read("part.yaml");
    TypedAt terminal(folder_, setup({"--around", "6"}));
    for (const char* typed : {"yes\n", "yes\n", "no\n"}) {
        ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
        terminal.watch(100ms);
        terminal.said.clear();
        terminal.type(typed);
    }
    EXPECT_EQ(terminal.wait(), 2);
    EXPECT_THAT(terminal.said, HasSubstr("nothing has moved since"));
    expect_unchanged(before);
    EXPECT_EQ(run(setup({"--around", "6"})), 2) << "nobody sits there";
    EXPECT_THAT(read("out.txt"), HasSubstr("--yes"));
}

TEST_F(Setup, CtrlCStopsTheToolAndChangesNothing) {
    VirtualGrblOptions options;
    TableMachine machine(port(), Table{kTable}, options);
    const std::string before = read("part.yaml");
    TypedAt terminal(folder_, setup({"--around", "6", "--yes"}));
    for (int k = 0; k < 20'000 && machine.audit().moves < 12; ++k) std::this_thread::sleep_for(1ms);
    terminal.type(TypedAt::kCtrlC);
    EXPECT_EQ(terminal.wait(), 3) << terminal.said;
    const std::uint64_t moves = machine.audit().moves;
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(machine.audit().moves, moves);
    expect_unchanged(before);
    machine.expect_safe();
}

TEST_F(Setup, ATiltedTableIsAHalfSpace) {
    const double tilt = 1 * std::numbers::pi / 180;
    const HalfSpace table{{0, 0, kTable}, {std::sin(tilt), 0, std::cos(tilt)}};
    TableMachine machine(port(), table);
    ASSERT_EQ(run(setup({"--around", "7", "--yes"})), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("tilted by 1.000 degrees"));
    const SessionConfig config = read_config(folder_ / "part.yaml");
    const auto* half = std::get_if<HalfSpace>(&config.fixtures.solids.at(0));
    ASSERT_NE(half, nullptr) << read("part.yaml");
    EXPECT_LT((half->normal - table.normal).norm(), 1e-4);
    EXPECT_NEAR(half->normal.dot(half->point - table.point), 0.0, 0.002);
    machine.expect_safe();
}

TEST_F(Setup, AWorkspaceOfAnotherKindAndClampsAreDealtWith) {
    TableMachine machine(port());
    std::ofstream(folder_ / "part.yaml", std::ios::app)
        << "workspace:\n  box: {min: [-9, -9, 0], max: [9, 9, 9]}   # a guess\n  fixtures:\n    - table: {z: -5}\n"
           "    - box: {min: [-35, -29, 0], max: [-30, -25, 5]}\n";
    ASSERT_EQ(run(setup({"--around", "6", "--table", "-30,-20,30,-20,0,25", "--yes"})), 0) << read("out.txt");
    EXPECT_THAT(
        read("part.yaml"),
        HasSubstr(
            "max: [22, 18, 21.3]}   # a guess\n  fixtures:  # the first as touched\n    - table: {z: 1.25}\n    - box: {min: [-35, "));
    std::ofstream(folder_ / "part.yaml") << text(port().string(), "{ball: {diameter: 2}}")
                                         << "workspace: {ball: {center: [0, 0, 0], radius: 9}}\n";
    ASSERT_EQ(run(setup({"--around", "6", "--yes"})), 0) << read("out.txt");
    EXPECT_TRUE(std::holds_alternative<Box>(read_config(folder_ / "part.yaml").workspace));
}

TEST_F(Setup, WhatIsNotAsItShouldBeIsToldAndChangesNothing) {
    const std::string before = read("part.yaml");
    const auto expect = [&](int code, const std::vector<std::string>& more, const std::string& said, VirtualGrblOptions options = {}) {
        TableMachine machine(port(), Table{kTable}, std::move(options));
        auto words = setup(more);
        words.push_back("--yes");
        EXPECT_EQ(run(words), code) << said << '\n' << read("out.txt");
        EXPECT_THAT(read("out.txt"), AllOf(HasSubstr(said), Not(HasSubstr("bug"))));
        expect_unchanged(before);
        return machine.audit().moves;
    };
    EXPECT_EQ(expect(2, {}, "give --around Z"), 0U);
    EXPECT_EQ(expect(2, {"--box", "0,0,0,1,1,0"}, "--box: each coordinate"), 0U);
    EXPECT_EQ(expect(2, {"--around", "60"}, "is outside machine.limits"), 0U);
    EXPECT_EQ(expect(2, {"--around", "6", "--table", "-90,0,0,0,1,1"}, "is outside machine.limits"), 0U);
    EXPECT_GT(expect(2, {"--around", "6", "--table", "-30,-20,0,-20,30,-20"}, "about on a line"), 0U);
    EXPECT_GT(expect(2, {"--around", "6", "--table", "-30,-20,30,-20,0,0"}, "that is no table"), 0U);
    EXPECT_GT(expect(2, {"--around", "2"}, "the ball would meet the table"), 0U);
    EXPECT_GT(expect(3, {"--around", "6", "--center", "25,0"}, "give --center a place on it"), 0U);
    EXPECT_GT(expect(3, {"--around", "15"}, "no part is there at that height"), 0U);
    EXPECT_GT(expect(2, {"--around", "6", "--margin", "25"}, "machine.limits"), 0U);
    EXPECT_GT(expect(2, {"--box", "-12,-8,1,12,8,9"}, "higher than it says"), 0U);
    EXPECT_EQ(expect(2, {"--around", "6", "--set", "machine.limits={min: [-40, -30, -2], max: [40, 30, 25]}"},
                     "the tool is at (3, 4, 30) mm, outside machine.limits"),
              0U);
    VirtualGrblOptions dead;
    dead.faults = {{VirtualFault::Kind::dead_probe, VirtualFault::When::probe, 1, 0, {}}};
    EXPECT_GT(expect(3, {"--around", "6"}, "nothing was touched down to (-32, -24, -2) mm", dead), 0U);
    write_part("{ball: {diameter: 2}, calibration: none.json}");
    EXPECT_EQ(run(setup({"--around", "6", "--yes"})), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("none.json: does not exist"));
}

// As in the README: three commands, one after the other.
TEST_F(Setup, AVirtualMachineIsSetUpAndProbed) {
    const fs::path link = folder_ / "vm.tty";
    const std::string machine = text(link.string(), "{ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}}");
    std::ofstream(folder_ / "part.yaml") << machine;
    std::ofstream(folder_ / "vm.yaml") << machine
                                       << "workspace: {box: {min: [-25, -20, 1], max: [25, 20, 25]}, fixtures: [{table: {z: 1.25}}]}\n"
                                          "object: {shape: {rounded_box: {size: [24, 16, 10], fillet: 0}, at: [0, 0, 6.25]}}\n";
    fs::create_directory(folder_ / "vm");
    const Process vm(folder_ / "vm", {"vm", "../vm.yaml", "--grbl", link.string(), "--fast", "--audit", "audit.json"});
    for (int k = 0; k < 2000 && !fs::exists(link); ++k) std::this_thread::sleep_for(5ms);
    ASSERT_EQ(run(setup({"--around", "6", "--yes"})), 0) << read("out.txt") << read("vm/out.txt");
    ASSERT_EQ(run(probe("s")), 0) << read("out.txt");
    vm.send(SIGINT);
    Process ended = vm;
    EXPECT_EQ(ended.wait(), 0);
    EXPECT_THAT(read("vm/audit.json"), AllOf(HasSubstr("\"unsafe_moves\": 0"), HasSubstr("\"unguarded_moves\": 0")));
}

}  // namespace
}  // namespace palpate::setup_test
