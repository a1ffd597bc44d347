// One test for every row of devices/FACTS.md, "GRBL".
#include "sim/machines/grbl/virtual_grbl.h"

#include "tests/sim/machines/grbl/virtual_grbl_support.h"

namespace palpate::virtual_grbl_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

INSTANTIATE_TEST_SUITE_P(Both, EveryGrblTest, testing::Values(GrblDialect::grbl, GrblDialect::grblhal), dialect_name);

// "banner"
TEST_P(EveryGrblTest, BannerAndLockMessage) {
    EXPECT_THAT(start(), ElementsAre(banner()));
    options.locked = true;
    EXPECT_THAT(start(), ElementsAre(banner(), kLockMessage));
}

// "banner": fresh EEPROM
TEST_F(VirtualGrblTest, FreshEepromSaysErrorSevenAndAllSettingsBeforeTheBanner) {
    options.fresh_eeprom = true;
    const Lines lines = start();
    ASSERT_GT(lines.size(), 30U);
    EXPECT_EQ(lines.front(), "error:7");
    EXPECT_EQ(lines[1], "$0=10");
    EXPECT_EQ(lines.back(), "Grbl 1.1h ['$' for help]");
    EXPECT_THAT(send(std::string(1, kReset)), IsEmpty());
    EXPECT_THAT(rest(), ElementsAre("Grbl 1.1h ['$' for help]")) << "only the first time";
}

// "`?` (real time, no newline)"
TEST_F(VirtualGrblTest, StatusTellsOffsetsAndOverridesOnlyInSomeReports) {
    options.work_offset = Point(1, 2, 3);
    start();
    EXPECT_EQ(status(), "<Idle|MPos:20.000,0.000,0.000|FS:0,0|WCO:1.000,2.000,3.000>");
    EXPECT_EQ(status(), "<Idle|MPos:20.000,0.000,0.000|FS:0,0|Ov:100,100,100>");
    for (int i = 0; i < 8; ++i) EXPECT_EQ(status(), "<Idle|MPos:20.000,0.000,0.000|FS:0,0>");
    EXPECT_THAT(status(), HasSubstr("|WCO:"));
}

TEST_F(VirtualGrblTest, StatusTellsWorkCoordinatesWhenItsMaskIsZero) {
    options.work_offset = Point(1, 2, 3);
    options.status_mask = 0;
    start();
    EXPECT_THAT(status(), StartsWith("<Idle|WPos:19.000,-2.000,-3.000|FS:0,0"));
    EXPECT_THAT(command("$10=1"), ElementsAre("ok"));
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:20.000,0.000,0.000|"));
}

TEST_P(EveryGrblTest, StatusTellsAClosedProbe) {
    start();
    EXPECT_THAT(status(), Not(HasSubstr("Pn:")));
    command("G38.2 X0 F300");
    EXPECT_THAT(status(), HasSubstr("|Pn:P"));
}

TEST_P(EveryGrblTest, OnlyGrblHalTellsBuffersHomingAndReference) {
    start();
    const std::string first = status();
    const std::string second = status();
    EXPECT_EQ(first.find("|Bf:") != std::string::npos, is_hal());
    EXPECT_EQ(first.find("|H:1") != std::string::npos, is_hal());
    EXPECT_EQ(first.find("|TLR:") != std::string::npos, is_hal());
    EXPECT_EQ(second.find("|A:") != std::string::npos, is_hal());
}

TEST_P(EveryGrblTest, StatusComesWhileALineWaitsForItsMotion) {
    start();
    EXPECT_THAT(send("G38.2 X0 F300\n"), IsEmpty());
    EXPECT_THAT(after(1.0), IsEmpty());
    EXPECT_THAT(status(), testing::AllOf(StartsWith("<Run|MPos:15.0"), HasSubstr("FS:300,0")));
}

// "G38.2/3 contact"
TEST_P(EveryGrblTest, ContactSaysPrbThenOkAfterTheMoveHasEnded) {
    for (const std::string code : {"G38.2", "G38.3"}) {
        start();
        EXPECT_THAT(send(code + " X0 F600\n"), IsEmpty());
        while (!tool->trigger()) EXPECT_THAT(after(0.001), IsEmpty());
        EXPECT_TRUE(tool->is_moving());
        EXPECT_THAT(after(0.02), IsEmpty()) << "it still runs on";
        EXPECT_THAT(rest(), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok"));
        const double overrun = 10.0 - tool->position().x();
        EXPECT_NEAR(overrun, stopping_distance(tool_options.motion, 10), 1e-3);
        EXPECT_THAT(status(), StartsWith("<Idle|MPos:9.73")) << "only PRB is the contact";
    }
}

TEST_P(EveryGrblTest, AfterAContactItRetractsFromWhereItIs) {
    start();
    command("G38.2 X0 F600");
    EXPECT_THAT(command("G91 G1 X1 F600"), ElementsAre("ok"));
    EXPECT_NEAR(tool->position().x(), 11 - stopping_distance(tool_options.motion, 10), 2e-3);
    EXPECT_THAT(status(), Not(HasSubstr("Pn:P")));
}

TEST_P(EveryGrblTest, G38Point4And5EndWhereTheProbeOpens) {
    for (const std::string code : {"G38.4", "G38.5"}) {
        start();
        command("G38.2 X0 F600");
        EXPECT_THAT(command(code + " X20"), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok"));
    }
}

// "no contact, `G38.3`"
TEST_P(EveryGrblTest, NoContactOfG38Point3IsNeitherContactNorError) {
    start();
    EXPECT_THAT(command("G38.3 X20 Y30 F600"), ElementsAre("[PRB:20.000,30.000,0.000:0]", "ok"));
    EXPECT_THAT(status(), StartsWith("<Idle"));
}

// "no contact, `G38.2`"
TEST_P(EveryGrblTest, NoContactOfG38Point2IsAnAlarmThenPrbThenOk) {
    start();
    command("G38.2 X0 F600");
    command("G0 X20");
    EXPECT_THAT(send("G38.2 Y30 F6000\n"), IsEmpty());
    EXPECT_THAT(after(1.0), ElementsAre("ALARM:5"));
    const std::string prb = is_hal() ? "[PRB:20.000,30.000,0.000:0]" : "[PRB:10.000,0.000,0.000:0]";
    EXPECT_THAT(after(0.5), ElementsAre(prb, "ok")) << "Grbl tells the previous contact";
    EXPECT_THAT(status(), StartsWith("<Alarm|"));
    EXPECT_THAT(command("G0 X0"), ElementsAre("error:9"));
    EXPECT_THAT(command("$X"), ElementsAre("[MSG:Caution: Unlocked]", "ok"));
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:20.000,30.000,0.000|"));
}

// "already closed at start"
TEST_P(EveryGrblTest, AProbeClosedAtStartIsAnAlarmThenOkWithoutPrb) {
    for (const std::string code : {"G38.2", "G38.3"}) {
        start();
        command("G38.2 X0 F600");
        const Point before = tool->position();
        EXPECT_THAT(command(code + " X0"), ElementsAre("ALARM:4", "ok"));
        EXPECT_EQ(tool->position(), before);
        EXPECT_THAT(status(), StartsWith("<Alarm|"));
    }
}

TEST_P(EveryGrblTest, ACutLeadIsSeenOnlyByGrblHal) {
    options.faults = {{VirtualFault::Kind::cut_probe}};
    start();
    if (is_hal()) {
        EXPECT_THAT(command("G38.2 X0 F600"), ElementsAre("ALARM:4", "ok"));
        EXPECT_THAT(status(), HasSubstr("|Pn:O"));
    } else {
        EXPECT_THAT(command("G38.2 X0 F600"), ElementsAre("ALARM:5", "[PRB:0.000,0.000,0.000:0]", "ok"));
        EXPECT_EQ(tool->audit().unsafe_moves, 1U);
    }
}

TEST_P(EveryGrblTest, AProbeThatDiedIsSeenByNoFirmware) {
    options.faults = {{VirtualFault::Kind::dead_probe}, {VirtualFault::Kind::mend_probe, VirtualFault::When::probe, 3}};
    start();
    EXPECT_THAT(command("G38.3 X5 F600"), ElementsAre("[PRB:5.000,0.000,0.000:0]", "ok"));
    EXPECT_THAT(status(), AllOf(StartsWith("<Idle|"), Not(HasSubstr("|Pn:"))));
    EXPECT_THAT(command("G38.3 X20 F600"), ElementsAre("[PRB:20.000,0.000,0.000:0]", "ok"));
    EXPECT_THAT(command("G38.3 X5 F600"), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok"));
}

// "check mode"
TEST_P(EveryGrblTest, CheckModeSaysOkWithoutPrbAndDoesNotMove) {
    start();
    EXPECT_THAT(command("$C"), ElementsAre("[MSG:Enabled]", "ok"));
    EXPECT_THAT(status(), StartsWith("<Check|"));
    EXPECT_THAT(command("G38.2 X0 F600"), ElementsAre("ok"));
    EXPECT_THAT(command("G1 X30"), ElementsAre("ok"));
    EXPECT_EQ(tool->audit().moves, 0U);
    EXPECT_THAT(command("$C"), ElementsAre("[MSG:Disabled]", "ok", banner()));
}

// "locked"
TEST_P(EveryGrblTest, LockedMachineRefusesCodeUntilItIsUnlocked) {
    options.locked = true;
    start();
    EXPECT_THAT(status(), StartsWith("<Alarm|"));
    EXPECT_THAT(command("G0 X0"), ElementsAre("error:9"));
    EXPECT_THAT(command("$X"), ElementsAre("[MSG:Caution: Unlocked]", "ok"));
    EXPECT_THAT(command("G0 X21"), ElementsAre("ok"));
    EXPECT_EQ(tool->audit().moves, 1U);
}

// "Ctrl-X while moving"
TEST_P(EveryGrblTest, ResetWhileProbingLosesThePositionAndAnswersLate) {
    start();
    command("G38.2 X0 F600");
    command("G0 X20");
    send("G38.2 Y40 F600\n");
    after(1.0);
    EXPECT_THAT(send(std::string(1, kReset)), ElementsAre("ALARM:3"));
    EXPECT_THAT(rest(), ElementsAre("ok", banner(), kLockMessage));
    EXPECT_GT((tool->true_position() - tool->position()).norm(), 0.2);
    EXPECT_THAT(command("$#"), Contains("[PRB:0.000,0.000,0.000:0]"));
    EXPECT_THAT(command("G0 X20"), ElementsAre("error:9"));
    EXPECT_THAT(command("$H"), ElementsAre("ok"));
    EXPECT_EQ(tool->true_position(), Point(50, 50, 50));
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:50.000,50.000,50.000|"));
}

TEST_P(EveryGrblTest, ResetWhileALineOfG1RunsHasNoStaleOk) {
    start();
    EXPECT_THAT(send("G1 Y40 F600\n"), ElementsAre("ok"));
    after(1.0);
    EXPECT_THAT(send(std::string(1, kReset)), ElementsAre("ALARM:3"));
    EXPECT_THAT(rest(), ElementsAre(banner(), kLockMessage));
}

TEST_P(EveryGrblTest, WhatIsSentBetweenResetAndBannerIsLost) {
    start();
    EXPECT_THAT(send(std::string(1, kReset) + "G0 X21\n?"), IsEmpty());
    EXPECT_THAT(rest(), ElementsAre(banner()));
    EXPECT_EQ(tool->audit().moves, 0U);
    EXPECT_THAT(status(), StartsWith("<Idle|"));
}

// "`!`, wait for `Hold:0`, Ctrl-X"
TEST_P(EveryGrblTest, HoldThenResetStopsAndKeepsThePosition) {
    start();
    send("G1 Y40 F600\n");
    after(1.0);
    send("!");
    EXPECT_THAT(status(), StartsWith("<Hold:1|"));
    after(0.2);
    EXPECT_THAT(status(), StartsWith("<Hold:0|"));
    const Point held = tool->position();
    EXPECT_THAT(send(std::string(1, kReset)), IsEmpty());
    EXPECT_THAT(rest(), ElementsAre(banner()));
    EXPECT_THAT(status(), StartsWith("<Idle|"));
    EXPECT_EQ(tool->position(), held);
    EXPECT_LT((tool->true_position() - held).norm(), 1e-3);
}

TEST_P(EveryGrblTest, ResetBeforeTheHoldIsCompleteLosesThePosition) {
    start();
    send("G1 Y40 F600\n");
    after(1.0);
    send("!");
    EXPECT_THAT(send(std::string(1, kReset)), ElementsAre("ALARM:3"));
}

TEST_P(EveryGrblTest, HoldThenResetOfAProbeAnswersTheLineBeforeTheBanner) {
    start();
    send("G38.3 Y40 F600\n");
    after(1.0);
    send("!");
    after(0.2);
    EXPECT_THAT(send(std::string(1, kReset)), ElementsAre("ok"));
    EXPECT_THAT(rest(), ElementsAre(banner()));
    EXPECT_LT((tool->true_position() - tool->position()).norm(), 1e-3);
}

TEST_P(EveryGrblTest, AHeldMoveGoesOn) {
    start();
    send("G38.2 X0 F600\n");
    after(0.5);
    send("!");
    after(0.5);
    EXPECT_THAT(send("G0 X30\n"), IsEmpty()) << "lines wait";
    send("~");
    EXPECT_THAT(status(), StartsWith("<Run|"));
    EXPECT_THAT(rest(), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok", "ok"));
    EXPECT_EQ(tool->position(), Point(30, 0, 0));
}

// "soft limit"
TEST_F(VirtualGrblTest, AfterASoftLimitGrblHearsOnlyAReset) {
    options.soft_limits = true;
    start();
    EXPECT_THAT(send("G1 Y60 F600\n"), ElementsAre("ALARM:2"));
    EXPECT_THAT(rest(), ElementsAre("[MSG:Reset to continue]"));
    EXPECT_THAT(send("?"), IsEmpty());
    EXPECT_THAT(command("$X"), IsEmpty());
    EXPECT_THAT(send(std::string(1, kReset)), ElementsAre("ok")) << "of the line that ran into it";
    EXPECT_THAT(rest(), ElementsAre("Grbl 1.1h ['$' for help]", kLockMessage));
    EXPECT_EQ(tool->audit().moves, 0U);
    EXPECT_THAT(command("$X"), ElementsAre("[MSG:Caution: Unlocked]", "ok"));
}

TEST_P(EveryGrblTest, AResetBetweenTheAlarmAndItsMessageIsSwallowed) {
    options.soft_limits = true;
    start();
    EXPECT_THAT(send("G38.3 Y60 F600\n"), ElementsAre("ALARM:2"));
    after(0.1);
    EXPECT_THAT(send(std::string(1, kReset)), IsEmpty());
    EXPECT_THAT(rest(), ElementsAre("[MSG:Reset to continue]"));
    send(std::string(1, kReset));
    EXPECT_THAT(rest(), Contains(banner()));
}

TEST_F(VirtualGrblTest, AfterASoftLimitGrblHalAnswersButDoesNotUnlock) {
    options.soft_limits = true;
    options.dialect = GrblDialect::grblhal;
    start();
    command("G1 Y60 F600");
    EXPECT_THAT(status(), StartsWith("<Alarm|"));
    EXPECT_THAT(command("$X"), ElementsAre("error:79"));
    EXPECT_THAT(command("$H"), ElementsAre("error:79"));
    send(std::string(1, kReset));
    EXPECT_THAT(rest(), Contains(kLockMessage));
    EXPECT_THAT(command("$X"), ElementsAre("[MSG:Caution: Unlocked]", "ok"));
}

TEST_P(EveryGrblTest, ASoftLimitWhileMovingKeepsThePosition) {
    options.soft_limits = true;
    start();
    send("G1 Y40 F600\n");
    after(1.0);
    EXPECT_THAT(send("G1 Y60\n"), IsEmpty());
    EXPECT_THAT(after(0.2), ElementsAre("ALARM:2"));
    EXPECT_LT((tool->true_position() - tool->position()).norm(), 1e-3);
}

// "hard limit"
TEST_P(EveryGrblTest, AHardLimitStopsDeadAndLosesThePosition) {
    options.faults = {{VirtualFault::Kind::alarm, VirtualFault::When::time, 1.0, 1.0}};
    start();
    send("G1 Y40 F600\n");
    EXPECT_THAT(after(1.0), ElementsAre("ALARM:1"));
    EXPECT_THAT(rest(), ElementsAre("[MSG:Reset to continue]"));
    EXPECT_GT((tool->true_position() - tool->position()).norm(), 0.2);
    send(std::string(1, kReset));
    EXPECT_THAT(rest(), ElementsAre(banner(), kLockMessage));
}

// "homing failed"
TEST_P(EveryGrblTest, FailedHomingSaysAlarmThenOkThenTheBanner) {
    options.locked = true;
    options.faults = {{VirtualFault::Kind::alarm, VirtualFault::When::line, 1, 9}};
    start();
    EXPECT_THAT(command("$H"), ElementsAre("ALARM:9", "ok", banner(), kLockMessage));
    EXPECT_THAT(command("$H"), ElementsAre("ok"));
}

TEST_P(EveryGrblTest, HomingTakesTimeAndMakesThePositionKnown) {
    options.locked = true;
    options.knows_position = false;
    start();
    EXPECT_THAT(status(), StartsWith("<Alarm|MPos:0.000,0.000,0.000|"));
    EXPECT_THAT(send("$H\n"), IsEmpty());
    EXPECT_THAT(status(), StartsWith("<Home|"));
    EXPECT_THAT(rest(), ElementsAre("ok"));
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:50.000,50.000,50.000|"));
    EXPECT_EQ(tool->true_position(), Point(50, 50, 50));
    options.homing = false;
    start();
    EXPECT_THAT(command("$H"), ElementsAre("error:5"));
}

// "jog"
TEST_P(EveryGrblTest, AJogAnswersAtOnceAndCanBeCancelled) {
    start();
    EXPECT_THAT(send("$J=G91 G21 X5 F600\n"), ElementsAre("ok"));
    EXPECT_THAT(status(), StartsWith("<Jog|"));
    after(0.2);
    send("\x85");
    rest();
    EXPECT_THAT(status(), StartsWith("<Idle|"));
    EXPECT_LT(tool->position().x(), 23);
    EXPECT_LT((tool->true_position() - tool->position()).norm(), 1e-3);
    EXPECT_THAT(command("G38.3 X20 Y1 F600"), Contains("ok")) << "the parser knows where it stopped";
    EXPECT_EQ(tool->position(), Point(20, 1, 0));
}

TEST_P(EveryGrblTest, AJogBeyondTheLimitsIsAnErrorAndNoAlarm) {
    options.soft_limits = true;
    start();
    EXPECT_THAT(command("$J=G91 G21 X50 F600"), ElementsAre("error:15"));
    EXPECT_THAT(status(), StartsWith("<Idle|"));
    EXPECT_THAT(command("$J=G91 G21 X5"), ElementsAre("error:22"));
    EXPECT_THAT(command("$J=G1 X5 F600"), ElementsAre("error:16"));
}

// "errors"
TEST_P(EveryGrblTest, Errors) {
    const auto error_of = [&](const std::string& line) {
        start();
        const Lines lines = command(line);
        return lines.size() == 1 ? lines[0] : "not one line";
    };
    EXPECT_EQ(error_of("G2 X1 Y1 R5"), "error:20");
    EXPECT_EQ(error_of("G5"), "error:20");
    EXPECT_EQ(error_of("G0 A1"), "error:20");
    EXPECT_EQ(error_of("G0 Xtwo"), "error:2");
    EXPECT_EQ(error_of("G0 X-"), "error:2");
    EXPECT_EQ(error_of("5"), "error:1");
    EXPECT_EQ(error_of("G38.2 F600"), "error:26");
    EXPECT_EQ(error_of("G38.2 X20 Y0 F600"), "error:33");
    EXPECT_EQ(error_of("G1 X" + std::string(80, '1') + " F600"), "error:11");
    EXPECT_EQ(error_of("G1 X5"), "error:22");
    EXPECT_EQ(error_of("G38.2 X5"), "error:22");
    EXPECT_EQ(error_of("G0 G1 X5 F100"), "error:24");
    EXPECT_EQ(error_of("G20 G21"), "error:21");
    EXPECT_EQ(error_of("G0 X1 X2"), "error:25");
    EXPECT_EQ(error_of("G1.5 X1"), "error:23");
    EXPECT_EQ(error_of("$Q"), "error:3");
    EXPECT_EQ(error_of("$999=1"), "error:3");
    EXPECT_EQ(tool->audit().moves, 0U);
}

// As the firmware reads numbers: no exponent, no "nan"; and codes that are too great for an int.
TEST_P(EveryGrblTest, NumbersThatAreNone) {
    const auto error_of = [&](const std::string& line) {
        start();
        const Lines lines = command(line);
        return lines.size() == 1 ? lines[0] : "not one line";
    };
    EXPECT_EQ(error_of("$10=nan"), "error:2");
    EXPECT_EQ(error_of("$10=inf"), "error:2");
    EXPECT_EQ(error_of("$10="), "error:2");
    EXPECT_EQ(error_of("$=1"), "error:2");
    EXPECT_EQ(error_of("$110=1e3"), "error:3");
    EXPECT_EQ(error_of("$10"), "error:3");
    EXPECT_EQ(error_of("$99999999999=1"), "error:3");
    EXPECT_EQ(error_of("$-10=1"), "error:3");
    EXPECT_EQ(error_of("$110=-1"), "error:4");
    EXPECT_EQ(error_of("G99999999999"), "error:20");
    EXPECT_EQ(error_of("G100"), "error:20");
    EXPECT_EQ(error_of("G10 L2 P7 X1"), "error:29");
    EXPECT_EQ(error_of("G10 L2 P99999999999 X1"), "error:29");
    EXPECT_EQ(error_of("G10 L2 P-1 X1"), "error:4");
}

// The number of a work system is cut off, and 0 is the one that is in use.
TEST_P(EveryGrblTest, AFractionOfAWorkSystemIsCutOff) {
    start();
    command("G55");
    EXPECT_THAT(command("G10 L2 P0.5 X1"), ElementsAre("ok"));
    EXPECT_THAT(command("G10 L2 P6.5 X3"), ElementsAre("ok"));
    const Lines parameters = command("$#");
    EXPECT_THAT(parameters, Contains("[G54:0.000,0.000,0.000]"));
    EXPECT_THAT(parameters, Contains("[G55:1.000,0.000,0.000]"));
    EXPECT_THAT(parameters, Contains("[G59:3.000,0.000,0.000]"));
}

// MINIMUM_FEED_RATE: 1 mm/min, whatever the line and the setting say.
TEST_P(EveryGrblTest, NothingMovesSlowerThanTheFirmwareCan) {
    for (const std::string line : {"G0 Y0.1", "G1 Y0.1 F600", "$J=Y0.1 F600", "G38.3 Y0.1 F600"}) {
        start();
        EXPECT_THAT(command("$110=0"), ElementsAre("ok"));
        send(line + "\n");
        after(3.0);
        EXPECT_NEAR(tool->position().y(), 0.05, 0.0015) << line;
    }
    start();
    send("G1 Y0.1 F0.000001\n");
    after(3.0);
    EXPECT_NEAR(tool->position().y(), 0.05, 0.0015);
}

TEST_P(EveryGrblTest, AMaskBeyondAByteIsCutOff) {
    start();
    EXPECT_THAT(command("$10=99999999999999999999999999999999999999999999999999999999999999"), ElementsAre("ok"));
    EXPECT_THAT(status(), StartsWith("<Idle|"));
    EXPECT_THAT(command("$$"), Contains("$11=0.010")) << "a line of its own";
    EXPECT_THAT(command("$10=257"), ElementsAre("ok"));
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:"));
}

TEST_P(EveryGrblTest, SystemCommandsWaitForIdle) {
    start();
    send("G1 Y40 F600\n");
    EXPECT_THAT(send("$#\n"), ElementsAre("error:8"));
    EXPECT_THAT(send("$H\n"), ElementsAre("error:8"));
}

// "H sticky error"
TEST_P(EveryGrblTest, AfterAnErrorGrblHalRepeatsItUntilAnEmptyLine) {
    for (const std::string cure : {"", "$G"}) {
        start();
        command("G2 X1");
        EXPECT_THAT(command("G0 X21"), ElementsAre(is_hal() ? "error:20" : "ok"));
        EXPECT_EQ(tool->audit().moves, is_hal() ? 0U : 1U);
        EXPECT_THAT(command(cure), Contains("ok"));
        EXPECT_THAT(command("G0 X22"), ElementsAre("ok"));
    }
    start();
    command("G2 X1");
    send(std::string(1, kReset));
    rest();
    EXPECT_THAT(command("G0 X22"), ElementsAre("ok"));
}

// "`$13=1`"
TEST_P(EveryGrblTest, InchesAreReportedWhateverTheCodeSays) {
    options.report_inches = true;
    options.work_offset = Point(1, 2, 3);
    start();
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:0.7874,0.0000,0.0000|"));
    EXPECT_THAT(command("G21 G90 G53 G0 X25.4"), ElementsAre("ok"));
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:1.0000,0.0000,0.0000|"));
    EXPECT_THAT(command("G38.2 X-1 Y-2 Z-3 F600"), ElementsAre("[PRB:0.3937,0.0000,0.0000:1]", "ok")) << "machine coordinates";
}

TEST_P(EveryGrblTest, UnitsDistancesAndOffsetsOfTheCode) {
    start();
    command("G20 G0 X1");
    EXPECT_EQ(tool->position(), Point(25.4, 0, 0));
    command("G21 G91 G0 X4.6 Y-1");
    EXPECT_EQ(tool->position(), Point(30, -1, 0));
    command("G10 L2 P1 X10");
    command("G90 G0 X15");
    EXPECT_EQ(tool->position(), Point(25, -1, 0));
    EXPECT_THAT(status(), HasSubstr("WCO:10.000,0.000,0.000"));
    command("G10 L20 P1 X0 Y0 Z0");
    EXPECT_THAT(command("$#"), Contains("[G54:25.000,-1.000,0.000]"));
    command("G92 X5");
    EXPECT_THAT(command("$#"), Contains("[G92:-5.000,0.000,0.000]"));
    EXPECT_THAT(command("$G"), ElementsAre("[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]", "ok"));
    command("G92.1");
    command("G55 G0 X30 Y0");
    EXPECT_EQ(tool->position(), Point(30, 0, 0));
}

TEST_P(EveryGrblTest, SettingsAndVersion) {
    start();
    const Lines settings = command("$$");
    EXPECT_THAT(settings, Contains(is_hal() ? "$10=511" : "$10=1"));
    EXPECT_THAT(settings, Contains("$22=1"));
    EXPECT_THAT(settings, Contains("$120=200.000"));
    EXPECT_THAT(settings, Contains("$130=100.000"));
    EXPECT_EQ(settings.back(), "ok");
    EXPECT_THAT(command("$I")[0], StartsWith(is_hal() ? "[VER:1.1f" : "[VER:1.1h"));
    EXPECT_THAT(command("$20=1"), ElementsAre("ok"));
    EXPECT_THAT(command("G1 X60 F100"), Contains("ALARM:2"));
}

TEST_P(EveryGrblTest, ADwellAnswersAfterItsTime) {
    start();
    EXPECT_THAT(send("G4 P0.5\n"), IsEmpty());
    EXPECT_THAT(after(0.4), IsEmpty());
    EXPECT_THAT(after(0.2), ElementsAre("ok"));
}

TEST_P(EveryGrblTest, OnlyGrblAnswersBothHalvesOfCrLf) {
    start();
    EXPECT_THAT(send("G21\r\n"), SizeIs(is_hal() ? 1 : 2));
}

// "host gone mid-probe"
TEST_P(EveryGrblTest, AProbeWithoutAHostFinishesAndIsRemembered) {
    options.faults = {{VirtualFault::Kind::hang_up, VirtualFault::When::time, 1.0}};
    start();
    send("G38.2 X0 F600\n");
    EXPECT_THAT(after(10.0), IsEmpty());
    EXPECT_EQ(grbl->link(), VirtualGrbl::Link::hung_up);
    grbl->plug_in();
    EXPECT_THAT(status(), StartsWith("<Idle|MPos:9.73"));
    EXPECT_THAT(command("$#"), Contains("[PRB:10.000,0.000,0.000:1]"));
}

// "receive buffer"
TEST_P(EveryGrblTest, WhenTheBufferIsFullEvenRealTimeBytesAreLost) {
    start();
    send("G38.2 X0 F60\n");
    std::string line = "G4 P0\n";
    for (int i = 0; i < 21; ++i) send(line);
    EXPECT_THAT(status(), StartsWith("<Run|")) << "126 bytes";
    send("G4 P0\n");
    EXPECT_EQ(status(), "no answer");
    EXPECT_EQ(send(std::string(1, kReset)).size(), 0U);
    EXPECT_TRUE(tool->is_moving());
    const Lines lines = rest();
    EXPECT_EQ(lines.size(), 2U + 21U) << "the last line lost its end";
}

TEST_P(EveryGrblTest, MovesAnswerWhenPlannedUntilThePlannerIsFull) {
    start();
    Lines oks;
    for (int i = 0; i < 20; ++i) {
        const Lines more = send("G1 Y" + std::to_string(i + 1) + " F60\n");
        oks.insert(oks.end(), more.begin(), more.end());
    }
    EXPECT_EQ(oks.size(), 16U) << "one under way, fifteen that wait";
    EXPECT_THAT(rest(), SizeIs(4));
    EXPECT_EQ(tool->position(), Point(20, 20, 0));
}

// --- spindle, coolant, overrides -------------------------------------------------------------------------------------

class EveryGrblReport : public EveryGrblTest {
protected:
    // One that tells the offset puts off what else it would tell.
    std::string report() {
        const std::string first = status();
        return first.find("|WCO:") == std::string::npos ? first : status();
    }
};

INSTANTIATE_TEST_SUITE_P(Both, EveryGrblReport, testing::Values(GrblDialect::grbl, GrblDialect::grblhal), dialect_name);

TEST_P(EveryGrblReport, SpindleAndCoolantShowInTheModesAndTheNextReports) {
    start();
    EXPECT_THAT(command("$G"), Contains(HasSubstr(" G94 M5 M9 T0 ")));
    EXPECT_THAT(report(), HasSubstr("|Ov:"));
    const std::vector<std::vector<std::string>> kSteps{{"M3 S1000", " M3 M9 ", "|A:S"},
                                                       {"M4", " M4 M9 ", "|A:C"},
                                                       {"M8", " M4 M8 ", "|A:CF"},
                                                       {"M7", " M4 M7 M8 ", "|A:CFM"},
                                                       {"M5", " M5 M7 M8 ", "|A:FM"}};
    for (const auto& step : kSteps) {
        EXPECT_THAT(command(step[0]), ElementsAre("ok"));
        EXPECT_THAT(command("$G"), Contains(HasSubstr(step[1])));
        EXPECT_THAT(report(), HasSubstr("|Ov:100,100,100" + step[2] + ">"));
        EXPECT_THAT(report(), Not(HasSubstr("|A:"))) << "only after a change, and then and when";
    }
    command("M9");
    EXPECT_THAT(report(), HasSubstr(is_hal() ? "|A:>" : "|Ov:100,100,100>"));
    command("M3");
    command("M30");
    EXPECT_THAT(command("$G"), Contains(HasSubstr(" M5 M9 "))) << "the end of a program";
    EXPECT_THAT(command("M3 M4"), ElementsAre("error:21"));
}

TEST_P(EveryGrblReport, AResetEndsTheSpindleAndEveryOverride) {
    start();
    command("M3 S1000");
    command("M8");
    send("\x91\x96");
    send(std::string(1, kReset));
    rest();
    EXPECT_THAT(command("$G"), Contains(HasSubstr(" M5 M9 ")));
    EXPECT_THAT(report(), AllOf(HasSubstr("|Ov:100,100,100"), Not(HasSubstr("|A:S"))));
}

TEST_P(EveryGrblReport, OverridesAreToldInTheNextReportAndHaveTheirBounds) {
    start();
    (void)report();
    const std::vector<std::pair<std::string, std::string>> kSteps{{"\x91", "110,100,100"},
                                                                  {"\x92\x92", "90,100,100"},
                                                                  {"\x93", "91,100,100"},
                                                                  {"\x94\x94", "89,100,100"},
                                                                  {"\x96", "89,50,100"},
                                                                  {"\x97", "89,25,100"},
                                                                  {"\x95\x9A", "89,100,110"},
                                                                  {"\x90\x99", "100,100,100"},
                                                                  {"\x91\x91\x91\x91\x91\x91\x91\x91\x91\x91\x91\x91", "200,100,100"},
                                                                  {std::string(25, '\x92'), "10,100,100"}};
    for (const auto& [keys, percent] : kSteps) {
        EXPECT_THAT(send(keys), IsEmpty());
        EXPECT_THAT(report(), HasSubstr("|Ov:" + percent));
    }
    send("\xA0\xA1");
    EXPECT_THAT(report(), HasSubstr("|A:FM"));
}

TEST_P(EveryGrblTest, AFeedOverrideChangesTheMoveUnderWay) {
    for (const auto& [keys, feed] :
         std::vector<std::pair<std::string, double>>{{std::string(10, '\x91'), 20.0}, {std::string(5, '\x92'), 5.0}}) {
        start();
        send("G38.3 Y40 F600\n");
        after(1.0);
        EXPECT_NEAR(tool->speed_mm_per_s(), 10, 1e-9);
        send(keys);
        after(0.2);
        EXPECT_NEAR(tool->speed_mm_per_s(), feed, 1e-9);
        EXPECT_THAT(rest(), Contains("[PRB:20.000,40.000,0.000:0]"));
        EXPECT_EQ(tool->position(), Point(20, 40, 0));
    }
    // From the next on, too, and twice as fast is four times as far to stop.
    start();
    send(std::string(10, '\x91'));
    EXPECT_THAT(command("G38.3 X0 F600"), Contains("[PRB:10.000,0.000,0.000:1]"));
    EXPECT_NEAR(tool->audit().deepest_mm, stopping_distance(tool->options().motion, 20), 2e-3);
    EXPECT_EQ(tool->audit().fast_moves_inside, 0U);
}

TEST_P(EveryGrblReport, APendantSwitchesSpindleAndOverride) {
    options.faults = {{VirtualFault::Kind::spindle, VirtualFault::When::time, 1.0, 3},
                      {VirtualFault::Kind::pendant_key, VirtualFault::When::time, 1.0, 0x91}};
    start();
    (void)report();
    after(1.0);
    EXPECT_THAT(report(), HasSubstr("|Ov:110,100,100|A:S"));
}

// --- what it says of its position ------------------------------------------------------------------------------------

TEST_P(EveryGrblTest, ReportsOfThePositionLieFromAContactOn) {
    using Kind = VirtualFault::Kind;
    const std::vector<std::pair<VirtualFault, std::string>> kCases{
        {{Kind::position_zero, VirtualFault::When::contact}, "MPos:0.000,0.000,0.000|"},
        {{Kind::position_swapped, VirtualFault::When::contact}, "MPos:0.000,9.730,0.000|"},
        {{Kind::position_ahead, VirtualFault::When::contact, 1, 30}, "MPos:-20.270,0.000,0.000|"},
        {{Kind::position_frozen, VirtualFault::When::contact}, "MPos:9.730,0.000,0.000|"}};
    for (const auto& [fault, mpos] : kCases) {
        options.faults = {fault};
        start();
        EXPECT_THAT(command("G38.3 X0 F600"), Contains("[PRB:10.000,0.000,0.000:1]"));
        EXPECT_THAT(status(), HasSubstr(mpos));
        EXPECT_EQ(tool->position(), Point(9.73, 0, 0));
        if (fault.kind != Kind::position_frozen) continue;
        EXPECT_THAT(command("G38.5 X15"), Contains(StartsWith("[PRB:10.000,0.000,0.000:1]")));
        EXPECT_THAT(status(), HasSubstr(mpos));
    }
    options.faults = {{Kind::position_beside, VirtualFault::When::contact, 1, 3}};
    start();
    command("G38.3 X0 F600");
    EXPECT_THAT(status(), AllOf(HasSubstr("MPos:9.730,"), Not(HasSubstr("MPos:9.730,0.000,0.000"))));
}

TEST_P(EveryGrblTest, ALateLatchIsFartherAlongTheWay) {
    options.faults = {{VirtualFault::Kind::latch_late, VirtualFault::When::time, 0.0, 0.01}};
    start();
    EXPECT_THAT(command("G38.3 X0 F600"), Contains("[PRB:9.900,0.000,0.000:1]"));
}

}  // namespace
}  // namespace palpate::virtual_grbl_test
