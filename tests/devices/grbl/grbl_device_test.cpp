// The driver and a machine that does what it should: one test or more for each row of devices/FACTS.md, "GRBL" that a driver meets.
#include "devices/grbl/grbl_device.h"

#include <cmath>

#include "tests/devices/grbl/grbl_support.h"

namespace palpate::grbl_device_test {
namespace {

using grbl::State;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;
using Outcome = MoveResult::Outcome;

INSTANTIATE_TEST_SUITE_P(Dialects, GrblDeviceTest, testing::Values(GrblDialect::grbl, GrblDialect::grblhal), dialect_name);

// --- connecting ------------------------------------------------------------------------------------------------------

// "banner"
TEST_P(GrblDeviceTest, ConnectingReadsWhatTheMachineSaysAndMovesNothing) {
    EXPECT_EQ(connect().position(), Point(20, 0, 0));
    const auto& identity = device->controller().identity();
    EXPECT_THAT(identity.version, StartsWith(is_hal() ? "GrblHAL 1.1f" : "Grbl 1.1h"));
    EXPECT_EQ(identity.number(120), 200.0);
    EXPECT_EQ(device->controller().state(), State::idle);
    EXPECT_EQ(tool->audit().moves, 0U);
}

// "Fresh EEPROM"
TEST_P(GrblDeviceTest, AFreshEepromThatSaysErrorAndSettingsBeforeTheBannerIsNoFault) {
    options.fresh_eeprom = true;
    EXPECT_EQ(ready().guarded_move({20, 5, 0}, Pace::travel).outcome, Outcome::reached);
}

// "Opening a USB port resets many boards"
TEST_P(GrblDeviceTest, ABoardThatOpeningThePortHasResetIsWaitedFor) {
    power_on();
    grbl->press_reset();
    EXPECT_EQ(connect().controller().state(), State::locked) << "it has forgotten where it is";
}

TEST_P(GrblDeviceTest, APortOnWhichNothingAnswersIsATimeoutThatSaysWhatToDo) {
    options.faults = {{VirtualFault::Kind::silence, VirtualFault::When::time, 0.0}};
    power_on();
    EXPECT_THAT(message_of<DeviceTimeout>([&] { connect(); }), HasSubstr("is it the right port"));
    EXPECT_LT(seconds(), 10.0);
}

TEST_P(GrblDeviceTest, TheOperatorIsHeardWhileNothingAnswers) {
    options.faults = {{VirtualFault::Kind::silence, VirtualFault::When::time, 0.0}};
    power_on();
    stream->before_read = [this] {
        if (seconds() >= 1.0) stop.request_stop();
    };
    EXPECT_THAT(message_of<Stopped>([&] { connect(); }), HasSubstr("told to hold"));
    EXPECT_LT(seconds(), 2.0);
}

TEST_P(GrblDeviceTest, AMotionOfAnEarlierHostIsStoppedWithTheWaiting) {
    power_on();
    (void)behind_its_back("$X\n");
    grbl->receive("G21G90G38.3X-30F60\n");
    stream->before_read = [this] {
        if (seconds() >= 3.0) stop.request_stop();
    };
    EXPECT_THAT(message_of<Stopped>([&] { connect(); }), HasSubstr("was stopped"));
    EXPECT_FALSE(tool->is_moving());
    EXPECT_GT(tool_at().x(), 15);
    EXPECT_THAT(status(), StartsWith("<Idle|")) << "it knows where it is";
}

TEST_P(GrblDeviceTest, AHomingCycleOfAnEarlierHostIsEndedWithTheWaiting) {
    power_on();
    grbl->receive("$H\n");
    stream->before_read = [this] {
        if (seconds() >= 0.5) stop.request_stop();
    };
    EXPECT_THROW(connect(), Stopped);
    EXPECT_LT(seconds(), 5.0);
    EXPECT_FALSE(tool->is_moving());
}

// "locked": require refuses
TEST_P(GrblDeviceTest, ALockedMachineIsRefusedWhereHomingIsRequired) {
    options.locked = true;
    device_options.homing = Homing::require;
    connect();
    EXPECT_THAT(message_of<DeviceAlarm>([&] { device->make_ready(); }), HasSubstr("home it"));
    EXPECT_THROW((void)device->guarded_move({20, 5, 0}, Pace::travel), PositionLost);
    EXPECT_THAT(status(), StartsWith("<Alarm|"));
    EXPECT_EQ(grbl->counts().probes, 0U);
}

TEST_P(GrblDeviceTest, AStopBeforeHomingMovesNothing) {
    options.locked = true;
    device_options.homing = Homing::run;
    connect();
    stop.request_stop();
    EXPECT_THAT(message_of<Stopped>([&] { device->make_ready(); }), HasSubstr("nothing has moved"));
    EXPECT_THAT(rest(), testing::IsEmpty());
    EXPECT_EQ(tool_at(), Point(20, 0, 0));
}

TEST_P(GrblDeviceTest, AStopWhileItHomesLosesThePosition) {
    options.locked = true;
    device_options.homing = Homing::run;
    connect();
    const double begin = seconds();
    stream->before_read = [this, begin] {
        if (seconds() >= begin + 0.5) stop.request_stop();
    };
    EXPECT_THAT(message_of<PositionLost>([&] { device->make_ready(); }), HasSubstr("stopped by the operator"));
    EXPECT_LT(seconds() - begin, 3);
    EXPECT_FALSE(tool->is_moving());
}

// devices/FACTS.md, "Safety floor": the stopping distance is "computed and checked"
TEST_P(GrblDeviceTest, AMachineThatStopsMoreSlowlyThanReckonedIsRefused) {
    tool_options.motion.acceleration_mm_per_s2 = 20;
    connect();
    EXPECT_THAT(message_of<DeviceError>([&] { device->make_ready(); }),
                HasSubstr("20 mm/s² ($120), less than machine.acceleration, 200 mm/s²"));
    EXPECT_EQ(grbl->counts().probes, 0U);
}

// "locked": run homes
TEST_P(GrblDeviceTest, ALockedMachineIsHomedWhereHomingMayRun) {
    options.locked = true;
    options.knows_position = false;
    device_options.homing = Homing::run;
    EXPECT_EQ(ready().position(), Point(50, 50, 50) - kOrigin);
    EXPECT_EQ(device->controller().state(), State::idle);
    EXPECT_EQ(device->guarded_move({20, 20, 20}, Pace::travel).outcome, Outcome::reached);
    EXPECT_NEAR((tool_at() - Point(20, 20, 20)).norm(), 0, kMicrometre);
}

TEST_P(GrblDeviceTest, AMachineThatIsIdleAndDoesNotSayThatItIsUnhomedIsNotHomedAgain) {
    device_options.homing = Homing::run;
    EXPECT_EQ(ready().position(), Point(20, 0, 0));
}

// "locked": skip unlocks
TEST_P(GrblDeviceTest, ALockedMachineIsUnlockedWhereHomingIsSkipped) {
    options.locked = true;
    device_options.homing = Homing::skip;
    EXPECT_EQ(ready().position(), Point(20, 0, 0));
    expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), {kRadius, 0, 0});
}

// "H adds H:0|1 (homed)", which comes in some reports only
TEST_P(GrblDeviceTest, AMachineThatSaysThatItIsNotHomedIsRefusedOrHomed) {
    if (!is_hal()) GTEST_SKIP() << "Grbl does not say";
    options.knows_position = false;
    connect();
    EXPECT_EQ(device->controller().state(), State::idle) << "it is not locked";
    EXPECT_THAT(message_of<DeviceAlarm>([&] { device->make_ready(); }), HasSubstr("not homed"));
    EXPECT_EQ(tool_at(), Point(20, 0, 0));
    device_options.homing = Homing::run;
    EXPECT_EQ(ready().position(), Point(50, 50, 50) - kOrigin);
    device->make_ready();
    EXPECT_EQ(device->guarded_move({20, 20, 20}, Pace::travel).outcome, Outcome::reached) << "once is enough";
    EXPECT_EQ(tool_at(), Point(20, 20, 20));
}

// "homing failed"
TEST_P(GrblDeviceTest, HomingThatFindsNoSwitchLosesThePosition) {
    options.locked = true;
    options.faults = {{VirtualFault::Kind::alarm, VirtualFault::When::line, 4, 9}};
    device_options.homing = Homing::run;
    connect();
    EXPECT_THAT(message_of<PositionLost>([&] { device->make_ready(); }), HasSubstr("ALARM:9"));
    EXPECT_THROW((void)device->guarded_move({20, 5, 0}, Pace::travel), PositionLost);
}

TEST_P(GrblDeviceTest, HomingThatIsSwitchedOffIsRefusedWithAdvice) {
    options.locked = true;
    options.homing = false;
    device_options.homing = Homing::run;
    connect();
    EXPECT_THAT(message_of<DeviceRefused>([&] { device->make_ready(); }), HasSubstr("$22=0"));
}

// "check mode"
TEST_P(GrblDeviceTest, AMachineInCheckModeIsRefused) {
    power_on();
    behind_its_back("$C\n");
    EXPECT_THAT(message_of<DeviceRefused>([&] { connect(); }), HasSubstr("check mode"));
}

// "H sticky error"
TEST_P(GrblDeviceTest, AnErrorThatAnEarlierHostLeftDoesNotAnswerEverything) {
    power_on();
    behind_its_back("G2 X1\n");
    EXPECT_EQ(ready().guarded_move({20, 5, 0}, Pace::travel).outcome, Outcome::reached);
}

// "soft limit: G then ignores everything, until Ctrl-X"
TEST_P(GrblDeviceTest, AMachineInTheTrapOfItsSoftLimitIsResetWhenConnecting) {
    options.soft_limits = true;
    power_on();
    behind_its_back("G21 G90 G0 X200\n");
    device_options.homing = Homing::skip;
    expect_touch(ready().guarded_move({0, 0, 0}, Pace::probe), {kRadius, 0, 0});
}

// "`!`": an earlier host may have left a hold
TEST_P(GrblDeviceTest, AHoldThatAnEarlierHostLeftIsEndedWithoutLosingThePosition) {
    power_on();
    grbl->receive("G21 G90 G38.3 X0 F300\n");
    grbl->advance(Seconds(1.0));
    grbl->receive("!");
    grbl->advance(Seconds(1.0));
    const Point held = tool_at();
    EXPECT_NEAR((ready().position() - held).norm(), 0, kMicrometre);
    expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), ball.first_hit({held, Point::Zero()}).value_or(held));
}

// "host gone mid-probe"
TEST_P(GrblDeviceTest, ANewHostWaitsForTheMoveOfAnEarlierOneToEnd) {
    power_on();
    grbl->receive("G21 G90 G38.3 X1 Y-2 Z3 F60\n");
    grbl->advance(Seconds(1.0));
    connect();
    EXPECT_FALSE(tool->is_moving());
    EXPECT_GT(seconds(), 9.0);
    EXPECT_NEAR((device->position() - tool_at()).norm(), 0, kMicrometre);
    expect_touch({Outcome::contact, device->controller().last_probe().position - kOrigin}, {kRadius, 0, 0});
}

TEST_P(GrblDeviceTest, ANewHostTakesTheToolOffWhatAnEarlierOneLeftItOn) {
    power_on();
    behind_its_back("G21 G90 G38.3 X1 Y-2 Z3 F300\n");
    connect();
    EXPECT_TRUE(device->is_probe_closed());
    EXPECT_THAT(message_of<ProbeClosed>([&] { device->make_ready(); }), HasSubstr("closed before anything moves"));
    device->retreat({15, 0, 0});
    device->make_ready();
    EXPECT_NEAR((tool_at() - Point(15, 0, 0)).norm(), 0, kMicrometre);
    expect_touch(device->guarded_move({0, 0, 0}, Pace::touch), {kRadius, 0, 0});
}

// --- moving ----------------------------------------------------------------------------------------------------------

// "Only PRB is the contact: the machine runs on. Retract from the actual position"
TEST_P(GrblDeviceTest, AContactIsWhatWasLatchedAndTheToolIsDrawnBack) {
    const MoveResult result = ready().guarded_move({0, 0, 0}, Pace::travel);
    expect_touch(result, {kRadius, 0, 0});
    EXPECT_TRUE(result.held);
    EXPECT_TRUE(result.events.empty());
    EXPECT_GT(tool->audit().deepest_mm, 0.5) << "the tool did not run on, so the test says nothing";
    const Point rest(kRadius + device_options.motion.retract_mm, 0, 0);
    EXPECT_NEAR((tool_at() - rest).norm(), 0, kMicrometre);
    EXPECT_NEAR((device->position() - rest).norm(), 0, kMicrometre);
    EXPECT_FALSE(tool->is_probe_closed());
}

TEST_P(GrblDeviceTest, TheToolIsNeverDrawnBackPastTheStart) {
    const Point near_by(kRadius + 0.2, 0, 0);
    ASSERT_EQ(ready().guarded_move(near_by, Pace::travel).outcome, Outcome::reached);
    expect_touch(device->guarded_move({0, 0, 0}, Pace::touch), {kRadius, 0, 0});
    EXPECT_NEAR((tool_at() - near_by).norm(), 0, kMicrometre);
}

// "no contact, G38.3"
TEST_P(GrblDeviceTest, AMoveThatTouchesNothingReaches) {
    const Point target(12.3456, 7, -8);
    EXPECT_EQ(ready().guarded_move(target, Pace::probe), (MoveResult{Outcome::reached, target, {}}));
    EXPECT_NEAR((tool_at() - target).norm(), 0, kMicrometre);
    EXPECT_NEAR((device->position() - target).norm(), 0, kMicrometre);
}

// "33 target equals position"
TEST_P(GrblDeviceTest, AMoveOfNoLengthSendsNothing) {
    ready();
    const auto lines = grbl->counts().lines;
    const Point target(20.0002, 0, 0);
    EXPECT_EQ(device->guarded_move(target, Pace::probe), (MoveResult{Outcome::reached, target, {}}));
    EXPECT_EQ(grbl->counts().lines, lines);
}

TEST_P(GrblDeviceTest, AMoveToWhereNoNumberIsIsNotSent) {
    ready();
    const auto lines = grbl->counts().lines;
    EXPECT_THROW((void)device->guarded_move({20, 0, std::nan("")}, Pace::travel), DeviceError);
    EXPECT_THROW((void)device->guarded_move({20, HUGE_VAL, 0}, Pace::travel), DeviceError);
    EXPECT_EQ(grbl->counts().lines, lines);
    EXPECT_EQ(device->guarded_move({20, 5, 0}, Pace::travel).outcome, Outcome::reached) << "nothing is lost";
}

TEST_P(GrblDeviceTest, EveryPaceHasItsFeed) {
    ready();
    const auto duration = [&](Pace pace, double y) {
        const double begin = seconds();
        EXPECT_EQ(device->guarded_move({20, y, 0}, pace).outcome, Outcome::reached);
        return seconds() - begin;
    };
    EXPECT_NEAR(duration(Pace::travel, 10), 10.0 / 20 + 20.0 / 200, 0.1);
    EXPECT_NEAR(duration(Pace::probe, 0), 10.0 / 5 + 5.0 / 200, 0.1);
    EXPECT_NEAR(duration(Pace::touch, 5), 5.0 / 1 + 1.0 / 200, 0.1);
}

// "WPos instead of MPos when $10=0", "WCO only in some reports"
TEST_P(GrblDeviceTest, WorkCoordinatesAndTheirOffsetAreFollowed) {
    options.work_offset = Point(-7, 11.5, 0.25);
    for (const int mask : {0, 1}) {
        options.status_mask = mask;
        power_on();
        EXPECT_EQ(ready().position(), Point(20, 0, 0));
        expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), {kRadius, 0, 0});
        EXPECT_EQ(device->guarded_move({15, 5, 5}, Pace::probe).outcome, Outcome::reached);
        EXPECT_NEAR((tool_at() - Point(15, 5, 5)).norm(), 0, kMicrometre);
    }
}

// "$13=1: MPos and PRB in inches whatever G20/G21 say"
TEST_P(GrblDeviceTest, AMachineThatReportsInchesIsUnderstood) {
    constexpr double kInchDigit = 0.00254;  // mm: the last digit that it says
    options.report_inches = true;
    options.work_offset = Point(-7, 11.5, 0.25);
    for (const int mask : {0, 1}) {
        options.status_mask = mask;
        power_on();
        EXPECT_NEAR((ready().position() - Point(20, 0, 0)).norm(), 0, kInchDigit);
        const Point off(12.3456, 7, 0);
        ASSERT_EQ(device->guarded_move(off, Pace::probe).outcome, Outcome::reached);
        EXPECT_NEAR((tool_at() - off).norm(), 0, kInchDigit);
        const auto probes = grbl->counts().probes;
        EXPECT_EQ(device->guarded_move(off, Pace::probe).outcome, Outcome::reached);
        EXPECT_EQ(grbl->counts().probes, probes) << "a move of no length";
        const MoveResult result = device->guarded_move({0, 0, 0}, Pace::probe);
        EXPECT_EQ(result.outcome, Outcome::contact);
        EXPECT_NEAR((result.position - kRadius * off.normalized()).norm(), 0, kInchDigit);
        EXPECT_NEAR((tool_at() - (kRadius + device_options.motion.retract_mm) * off.normalized()).norm(), 0, kInchDigit);
    }
}

// Hobby machines have 80 to 400 steps per millimetre; what they reach is not what they were told.
TEST_P(GrblDeviceTest, AMachineOfCoarseStepsIsUnderstood) {
    for (const double steps : {80.0, 250.0, 400.0}) {
        tool_options.motion.resolution_mm = 1.0 / steps;
        power_on();
        ready();
        const Point off(12.3456, 7.0111, 0.0017);
        ASSERT_EQ(device->guarded_move(off, Pace::probe).outcome, Outcome::reached);
        EXPECT_NEAR((device->position() - off).norm(), 0, 1.0 / steps);
        const auto lines = grbl->counts().lines;
        EXPECT_EQ(device->guarded_move(off, Pace::probe).outcome, Outcome::reached);
        EXPECT_EQ(grbl->counts().lines, lines) << "a move of no length";
        const MoveResult result = device->guarded_move({0, 0, 0}, Pace::probe);
        EXPECT_EQ(result.outcome, Outcome::contact);
        EXPECT_NEAR((result.position - kRadius * off.normalized()).norm(), 0, 2.0 / steps);
    }
}

// "11 line too long (80 bytes)"
TEST_P(GrblDeviceTest, LinesOfLongNumbersAreShortEnough) {
    tool_options.start = Point::Constant(-12345.678);
    tool_options.limits = {Point::Constant(-20000), Point::Constant(20000)};
    EXPECT_EQ(ready().guarded_move(device->position() + Vector(0.123, 0.456, 0.789), Pace::travel).outcome, Outcome::reached);
}

// "already closed at start: ALARM:4, ok, no PRB"
TEST_P(GrblDeviceTest, AProbeThatIsClosedIsFoundBeforeAnythingMoves) {
    tool_options.start = Point(9.9, 0, 0) + kOrigin;
    connect();
    EXPECT_THAT(message_of<ProbeClosed>([&] { device->make_ready(); }), HasSubstr("closed before anything moves"));
    EXPECT_EQ(grbl->counts().probes, 0U);
}

TEST_P(GrblDeviceTest, AProbeThatClosesBetweenMovesIsAProbeClosedAndNothingMoves) {
    options.faults = {{VirtualFault::Kind::spurious_trigger, VirtualFault::When::line, 8}};
    ready();
    ASSERT_EQ(device->guarded_move({20, 1, 0}, Pace::travel).outcome, Outcome::reached);
    EXPECT_THAT(message_of<ProbeClosed>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), HasSubstr("ALARM:4"));
    EXPECT_EQ(tool_at(), Point(20, 1, 0));
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::probe), PositionLost) << "nothing moves before a new connection";
    device_options.homing = Homing::skip;
    expect_touch(ready().guarded_move({0, 0, 0}, Pace::probe), kRadius * Point(20, 1, 0).normalized());
}

// "Also H with the probe unplugged (Pn:O)"
TEST_P(GrblDeviceTest, AProbeThatIsNotPluggedInIsFoundWhereTheFirmwareCanTell) {
    options.faults = {{VirtualFault::Kind::cut_probe, VirtualFault::When::time, 0.0}};
    connect();
    if (is_hal()) {
        EXPECT_THAT(message_of<ProbeClosed>([&] { device->make_ready(); }), HasSubstr("not plugged in"));
    } else {
        EXPECT_NO_THROW(device->make_ready());
    }
}

TEST_P(GrblDeviceTest, AProbeThatIsUnpluggedLaterIsFoundWhereTheFirmwareCanTell) {
    if (!is_hal()) GTEST_SKIP() << "Grbl reads an open lead as a probe that is free";
    options.faults = {{VirtualFault::Kind::cut_probe, VirtualFault::When::probe, 2}};
    ready();
    ASSERT_EQ(device->guarded_move({20, 1, 0}, Pace::travel).outcome, Outcome::reached);
    EXPECT_THAT(message_of<ProbeClosed>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), HasSubstr("unplugged"));
    EXPECT_EQ(tool_at(), Point(20, 1, 0));
}

}  // namespace
}  // namespace palpate::grbl_device_test
