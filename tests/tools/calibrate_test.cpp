// `palpate calibrate` as a user runs it: on a virtual machine before a sphere, and what is left of it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>

#include "config/reader.h"
#include "tests/tools/session_rig.h"
#include "tests/tools/terminal_rig.h"
#include "tools/calibration_file.h"

namespace palpate::calibrate_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kBall = 2.0;
// What the ball's centre meets is the sphere of the rig: of 5 mm, ball and all.
constexpr double kSphere = 2 * kRadius - kBall;
constexpr const char* kFile = "part.calibration.json";

VirtualToolOptions noisy_axes() {
    VirtualToolOptions options = axes();
    options.touch_noise_mm = 0.002;
    options.probe_feed_mm_per_s = options.motion.feeds.probe_mm_per_s;
    return options;
}

class Calibrate : public SessionRig {
protected:
    Calibrate() { write_part("ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}"); }

    void write_part(const std::string& tool, const std::string& machine = "") const {
        write("part.yaml", "grbl: {port: " + port().string() + "}\n  homing: run\n  noise: 0.01\n  probe_proof: first_touch" + machine);
        std::ofstream(folder_ / "part.yaml", std::ios::app) << "# the ruby one\ntool: {" << tool << "}  # bought in May\n";
    }
    [[nodiscard]] std::vector<std::string> calibrate(const std::vector<std::string>& more = {"--yes"}) const {
        std::vector<std::string> words = {"calibrate", "part.yaml", "--sphere", "0.2,-0.1,0.1", "--diameter", fmt::format("{}", kSphere),
                                          "--touches", "25"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    [[nodiscard]] ProbeCalibration result() const { return parse_calibration(read(kFile), kFile); }
    void write_calibration(const std::string& date, const ToolShape& tool, double feed = 5.0) const {
        ProbeCalibration calibration;
        calibration.date = date;
        calibration.tool = tool;
        calibration.feed_mm_per_s = feed;
        calibration.sphere_diameter_mm = 25;
        calibration.touches = 50;
        calibration.effective_radius_mm = tool.ball_diameter / 2 - 0.05;
        calibration.raw_form_error_mm = 0.01;
        std::ofstream(folder_ / "probe.json") << to_json(calibration);
    }
    [[nodiscard]] static ToolShape tool() { return {kBall, ToolShape::Shaft{1.5, 30}, {}, Vector::UnitZ()}; }
};

TEST_F(Calibrate, AProbeIsQualifiedAndItsCalibrationWritten) {
    PortMachine machine(port(), {}, noisy_axes());
    ASSERT_EQ(run(calibrate()), 0) << read("out.txt");
    const ProbeCalibration calibration = result();
    EXPECT_NEAR(calibration.effective_radius_mm, kBall / 2, 0.005);
    EXPECT_NEAR(calibration.sphere_diameter_mm, kSphere, 1e-9);
    EXPECT_EQ(calibration.touches, 25U);
    EXPECT_EQ(calibration.feed_mm_per_s, 5.0);
    EXPECT_LT(calibration.rms_mm, 0.005);
    EXPECT_EQ(calibration.date.substr(0, 10), date_text(std::chrono::system_clock::now()).substr(0, 10));
    const std::string said = read("out.txt");
    for (const char* shown :
         {"effective radius  ", "lobing            ", "repeatability     ", "form error        ", "residuals         ",
          "touch error       ", "first move to ", "50 touches in about ", "tool.calibration", "  calibration: \"part.calibration.json\""}) {
        EXPECT_THAT(said, HasSubstr(shown));
    }
    EXPECT_THAT(read("part.yaml"), Not(HasSubstr("calibration")));
    expect_safe(machine);
}

TEST_F(Calibrate, TheConfigurationNamesItOnRequestAndKeepsItsComments) {
    PortMachine machine(port(), {}, noisy_axes());
    const std::string before = read("part.yaml");
    ASSERT_EQ(run(calibrate({"--yes", "--write", "-o", "cal.json"})), 0) << read("out.txt");
    EXPECT_THAT(read("part.yaml"),
                HasSubstr("# the ruby one\ntool: {ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}, calibration: "
                          "\"cal.json\"}  # bought in May\n"));
    EXPECT_EQ(read("part.yaml.bak"), before);
    EXPECT_TRUE(with_calibration(read_config(folder_ / "part.yaml")).probe_calibration);
    // Once more, in place of the old one.
    ASSERT_EQ(run(calibrate({"--yes", "--write", "-o", "cal.json"})), 0) << read("out.txt");
}

TEST_F(Calibrate, TheOperatorIsAskedAndSeesWhatWillMove) {
    PortMachine machine(port(), {}, noisy_axes());
    TypedAt terminal(folder_, calibrate({}));
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    EXPECT_THAT(terminal.said,
                AllOf(HasSubstr("machine    Grbl"), HasSubstr("limits     "), HasSubstr("first move to "), HasSubstr("50 touches")));
    EXPECT_EQ(machine.audit().moves, 0U);
    terminal.type("no\n");
    EXPECT_EQ(terminal.wait(), 2);
    EXPECT_THAT(terminal.said, HasSubstr("not confirmed; nothing has moved"));
    EXPECT_EQ(machine.audit().moves, 0U);
    EXPECT_EQ(run(calibrate({})), 2) << "nobody sits there";
    EXPECT_THAT(read("out.txt"), HasSubstr("--yes"));
    EXPECT_FALSE(fs::exists(folder_ / kFile));
}

TEST_F(Calibrate, AProbeThatIsToBePressedIsBeforeAnythingMoves) {
    write_part("ball: {diameter: 2}");
    PortMachine machine(port(), {}, noisy_axes());
    TypedAt terminal(folder_, calibrate({"--set", "machine.probe_proof=hand"}));
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.type("yes\n");
    ASSERT_TRUE(terminal.wait_for("(Enter: stop): ")) << terminal.said;
    terminal.type("\n");
    EXPECT_EQ(terminal.wait(), 3);
    EXPECT_THAT(terminal.said, HasSubstr("the probe was not seen to close and to open; nothing has moved"));
    EXPECT_EQ(machine.audit().moves, 0U);
}

TEST_F(Calibrate, CtrlCStopsTheToolAndWritesNothing) {
    PortMachine machine(port(), {}, noisy_axes());
    TypedAt terminal(folder_, calibrate());
    wait_for_probes(machine, 60);
    terminal.type(TypedAt::kCtrlC);
    EXPECT_EQ(terminal.wait(), 3) << terminal.said;
    EXPECT_THAT(terminal.said, HasSubstr("stopped"));
    EXPECT_FALSE(fs::exists(folder_ / kFile));
    const std::uint64_t moves = machine.audit().moves;
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(machine.audit().moves, moves) << "it stands";
    bool rests = false;
    machine.host().with([&](VirtualGrbl& grbl) { rests = !grbl.is_busy(); });
    EXPECT_TRUE(rests);
    expect_safe(machine);
}

TEST_F(Calibrate, ADeadProbeIsToldAndPressedNoDeeperThanItGivesWay) {
    for (const double at : {1.0, 40.0}) {
        VirtualGrblOptions options;
        options.faults = {{VirtualFault::Kind::dead_probe, VirtualFault::When::probe, at, 0, {}}};
        PortMachine machine(port(), options, noisy_axes());
        EXPECT_EQ(run(calibrate()), 3) << read("out.txt");
        EXPECT_THAT(read("out.txt"), AllOf(HasSubstr("nothing was touched"), HasSubstr("the probe is dead")));
        EXPECT_FALSE(fs::exists(folder_ / kFile));
        expect_safe(machine);
    }
}

TEST_F(Calibrate, ASphereElsewhereOrOfAnotherSizeIsRefusedOnceItIsTouched) {
    {
        PortMachine machine(port(), {}, noisy_axes());
        auto words = calibrate();
        words[3] = "0.7,0.5,-0.6";
        EXPECT_EQ(run(words), 3) << read("out.txt");
        EXPECT_THAT(read("out.txt"), HasSubstr("from where it was said to be"));
        expect_safe(machine);
    }
    PortMachine machine(port(), {}, noisy_axes());
    auto words = calibrate();
    words[5] = "8.8";
    EXPECT_EQ(run(words), 3) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("give those that they have"));
    expect_safe(machine);
    EXPECT_FALSE(fs::exists(folder_ / kFile));
}

TEST_F(Calibrate, WhatCannotBeginMovesNothing) {
    PortMachine machine(port(), {}, noisy_axes());
    const auto expect = [&](std::vector<std::string> words, const std::string& said) {
        EXPECT_EQ(run(words), 2) << said << '\n' << read("out.txt");
        EXPECT_THAT(read("out.txt"), HasSubstr(said));
        EXPECT_EQ(machine.audit().moves, 0U);
    };
    auto words = calibrate();
    words[3] = "8,0,0";
    expect(words, "machine.limits: the tool goes around the sphere");
    words = calibrate();
    words[3] = "0,0,25";
    expect(words, "above the sphere's equator");
    expect(calibrate({"--yes", "-o", "part.yaml"}), "is read by this run");
    std::ofstream(folder_ / "notes.txt") << "mine";
    expect(calibrate({"--yes", "-o", "notes.txt"}), "is there and no calibration");
    EXPECT_EQ(read("notes.txt"), "mine");
    expect(calibrate({"--yes", "-o", "nowhere/cal.json"}), "cannot be written");
    expect(calibrate({"--yes", "--touches", "12"}), "--touches");
    write_part("ball: {diameter: 2}, stylus: {diameter: 1.5, length: 3}, holder: {diameter: 30, length: 30}");
    expect(calibrate(), "the holder");
    write("part.yaml", "grbl: {port: " + port().string() + "}");
    expect(calibrate(), "tool: missing");
    EXPECT_FALSE(fs::exists(folder_ / kFile));
}

// What sessions make of it.
TEST_F(Calibrate, CheckTellsOfACalibrationAndWarnsOfAnOldOneAndAnotherFeed) {
    const auto check = [&](const std::string& more = "") {
        write_part("ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}, calibration: probe.json" + more);
        return run({"check", "part.yaml", "--offline"});
    };
    const auto now = std::chrono::system_clock::now();
    write_calibration(date_text(now), tool());
    EXPECT_EQ(check(), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), AllOf(HasSubstr("calibration    effective radius 0.95 mm"), Not(HasSubstr("warning"))));
    write_calibration(date_text(now - std::chrono::days(9)), tool());
    EXPECT_EQ(check(), 0);
    EXPECT_THAT(read("out.txt"), HasSubstr("is 9 days old, more than tool.calibration_max_age, 7"));
    EXPECT_EQ(check(", calibration_max_age: 30"), 0);
    EXPECT_THAT(read("out.txt"), Not(HasSubstr("days old")));
    write_calibration(date_text(now), tool(), 3.0);
    EXPECT_EQ(check(), 0);
    EXPECT_THAT(read("out.txt"), HasSubstr("was made at 3 mm/s, and touches count at 5 mm/s"));
}

TEST_F(Calibrate, ACalibrationThatCannotBeUsedIsOneMessage) {
    write_part("ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}, calibration: probe.json");
    const auto expect = [&](const std::string& said) {
        for (const std::vector<std::string>& words : {std::vector<std::string>{"check", "part.yaml", "--offline"}, probe("s")}) {
            EXPECT_EQ(run(words), 2) << said;
            EXPECT_THAT(read("out.txt"), AllOf(HasSubstr("probe.json"), HasSubstr(said), Not(HasSubstr("bug"))));
        }
    };
    expect("does not exist");
    std::ofstream(folder_ / "probe.json") << "{\"palpate\":";
    expect("damaged");
    ToolShape other = tool();
    other.ball_diameter = 3;
    write_calibration("2026-01-31", other);
    expect("belongs to another tool");
    EXPECT_FALSE(fs::exists(folder_ / "s"));
}

// Days that no calendar has are read, as nothing depends on them but a warning.
TEST(CalibrationFile, AgesAreReckonedFromTheDateInTheFile) {
    SessionConfig config;
    config.tool = ToolShape{2, {}, {}, Vector::UnitZ()};
    config.calibration.file = "/probe.json";
    config.probe_calibration.emplace();
    const CalendarTime now = std::chrono::sys_days(std::chrono::year(2026) / 2 / 8) + 12h;
    EXPECT_EQ(date_text(now), "2026-02-08T12:00:00Z");
    const auto warned = [&](const std::string& date) {
        config.probe_calibration->date = date;
        return calibration_warnings(config, now);
    };
    EXPECT_TRUE(warned("2026-02-01T12:00:00Z").empty());
    EXPECT_TRUE(warned("2026-02-02").empty());
    EXPECT_EQ(warned("2026-02-01T11:00:00Z").size(), 1U);
    EXPECT_EQ(warned("2025-02-08").size(), 1U);
    EXPECT_THAT(warned("2026-02-31").at(0), HasSubstr("in no calendar"));
    EXPECT_THAT(warned("2026-03-01").at(0), HasSubstr("yet to come"));
}

}  // namespace
}  // namespace palpate::calibrate_test
