// The driver and a machine on which something goes wrong: what comes back is true, or a DeviceError says what happened.
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "devices/grbl/grbl_report.h"
#include "devices/session/visited_ways.h"
#include "tests/devices/grbl/grbl_support.h"

namespace palpate::grbl_device_faults_test {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;
using Kind = VirtualFault::Kind;
using When = VirtualFault::When;
using Outcome = MoveResult::Outcome;

class GrblDeviceFaults : public GrblDeviceTest {
protected:
    inline static const Point kTouch{kRadius, 0, 0};  // of the move from the start to the origin

    MoveResult probe() { return device->guarded_move({0, 0, 0}, Pace::probe); }
    // A moment at which that move, made first of all, is under way: the same moves take the same virtual time.
    double mid_move() {
        ready();
        double moment = 0;
        once_within(15, [&] { moment = seconds(); });
        (void)probe();
        device.reset();
        grbl.reset();
        return moment;
    }
    // As a new session does that trusts the machine's count.
    void expect_that_a_new_host_can_work() {
        device_options.homing = Homing::skip;
        EXPECT_NEAR((ready().position() - tool_at()).norm(), 0, kMicrometre);
        const Point from = tool_at();
        expect_touch(probe(), *ball.first_hit({from, {0, 0, 0}}));
    }
};

INSTANTIATE_TEST_SUITE_P(Dialects, GrblDeviceFaults, testing::Values(GrblDialect::grbl, GrblDialect::grblhal), dialect_name);

// --- alarms and resets -----------------------------------------------------------------------------------------------

// "locked: error:9"
TEST_P(GrblDeviceFaults, AMachineThatWasLockedUnheardIsADeviceAlarm) {
    ready();
    grbl->press_reset();
    rest();  // the driver does not hear the banner
    EXPECT_THAT(message_of<DeviceAlarm>([&] { (void)probe(); }), HasSubstr("is locked"));
    EXPECT_THROW((void)probe(), PositionLost);
    EXPECT_EQ(grbl->counts().probes, 0U);
}

// "check mode: ok without PRB: a failure"
TEST_P(GrblDeviceFaults, CheckModeIsNotTakenForMotion) {
    ready();
    behind_its_back("$C\n");
    EXPECT_THAT(message_of<BadAnswer>([&] { (void)probe(); }), HasSubstr("check mode"));
    EXPECT_EQ(tool_at(), Point(20, 0, 0));
}

// "Ctrl-X while moving: ALARM:3, then a stale ok, banner, lock"
TEST_P(GrblDeviceFaults, AResetByAnotherProgramInMidMoveLosesThePosition) {
    ready();
    once_within(15, [&] { grbl->receive(std::string(1, kReset)); });
    EXPECT_THAT(message_of<PositionLost>([&] { (void)probe(); }), HasSubstr("ALARM:3"));
    EXPECT_THROW((void)probe(), PositionLost) << "the stale ok is no answer";
    EXPECT_EQ(grbl->counts().probes, 1U);
    device_options.homing = Homing::run;
    EXPECT_EQ(ready().position(), Point(50, 50, 50) - kOrigin);
}

TEST_P(GrblDeviceFaults, TheResetButtonInMidMoveLosesThePosition) {
    ready();
    once_within(15, [&] { grbl->press_reset(); });
    EXPECT_THAT(message_of<PositionLost>([&] { (void)probe(); }), HasSubstr("started anew"));
    EXPECT_THROW((void)probe(), PositionLost);
    EXPECT_EQ(grbl->counts().probes, 1U);
}

// A machine without homing is not locked afterwards; it would go anywhere.
TEST_P(GrblDeviceFaults, NothingMovesAfterTheResetButtonWasPressedBetweenMoves) {
    for (const bool homing : {true, false}) {
        options.homing = homing;
        power_on();
        ready();
        ASSERT_EQ(device->guarded_move({20, 5, 0}, Pace::travel).outcome, Outcome::reached);
        grbl->press_reset();
        grbl->advance(Seconds(2.0));
        EXPECT_THAT(message_of<PositionLost>([&] { (void)probe(); }), HasSubstr("started anew"));
        EXPECT_EQ(tool_at(), Point(20, 5, 0));
        EXPECT_FALSE(tool->is_moving());
    }
}

// "soft limit: ALARM:2, [MSG:Reset to continue], G then ignores everything until Ctrl-X"
TEST_P(GrblDeviceFaults, AMoveBeyondTheMachinesTravelIsAnAlarmWithAWayOut) {
    options.soft_limits = true;
    ready();
    const std::string message = message_of<DeviceAlarm>([&] { (void)device->guarded_move({20, 0, 60}, Pace::travel); });
    EXPECT_THAT(message, HasSubstr("ALARM:2"));
    EXPECT_THAT(message, HasSubstr("machine.limits"));
    EXPECT_EQ(tool_at(), Point(20, 0, 0));
    EXPECT_THROW((void)probe(), PositionLost) << "nothing moves before a new connection";
    EXPECT_THAT(status(), StartsWith("<Alarm|")) << "out of the trap, and locked";
    expect_that_a_new_host_can_work();
}

// "hard limit: ALARM:1, then as above, position lost"
TEST_P(GrblDeviceFaults, AHardLimitInMidMoveLosesThePosition) {
    options.faults = {{Kind::alarm, When::time, mid_move(), 1}};
    ready();
    EXPECT_THAT(message_of<PositionLost>([&] { (void)probe(); }), HasSubstr("ALARM:1"));
    EXPECT_THAT(status(), StartsWith("<Alarm|"));
    device_options.homing = Homing::run;
    EXPECT_EQ(ready().position(), Point(50, 50, 50) - kOrigin);
}

// "no contact, G38.2: ALARM:5", which G38.3 never is, unless someone else sends it
TEST_P(GrblDeviceFaults, AnAlarmThatKeepsThePositionIsADeviceAlarm) {
    options.faults = {{Kind::alarm, When::probe, 1, 5}};
    ready();
    EXPECT_THAT(message_of<DeviceAlarm>([&] { (void)probe(); }), HasSubstr("ALARM:5"));
    expect_that_a_new_host_can_work();
}

// "H sticky error"
TEST_P(GrblDeviceFaults, AnErrorIsADeviceRefusedOnceAndDoesNotStick) {
    ready();
    grbl->receive("G2 X1\n");
    if (is_hal()) {
        EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("error:20"));
        EXPECT_EQ(tool_at(), Point(20, 0, 0));
    }
    expect_touch(probe(), kTouch);
}

// --- stopping --------------------------------------------------------------------------------------------------------

// "`!`, wait for Hold:0, Ctrl-X: the way to stop"
TEST_P(GrblDeviceFaults, AStopInMidMoveKeepsThePositionAndGoesBack) {
    ready();
    once_within(15, [&] { stop.request_stop(); });
    EXPECT_THAT(message_of<Stopped>([&] { (void)device->guarded_move({0, 0, 0}, Pace::travel); }), HasSubstr("(20, 0, 0)"));
    EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
    EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre) << "no step is lost";
    EXPECT_EQ(grbl->counts().resets, 1U);
    EXPECT_THROW((void)probe(), Stopped) << "it stays stopped";
    EXPECT_EQ(grbl->counts().probes, 2U) << "there and back";
    stop = {};
    device_options.homing = Homing::require;
    expect_touch((ready(), probe()), kTouch);
}

TEST_P(GrblDeviceFaults, AStopWhoseFeedHoldGotLostStopsAllTheSame) {
    ready();
    once_within(15, [&] {
        stop.request_stop();
        stream->to_machine.lose(0, 1);
    });
    EXPECT_THROW((void)device->guarded_move({12, 0, 0}, Pace::probe), Stopped);
    EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
    EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre);
}

// At the touch, while it runs on, while it is drawn back: whenever it comes, the tool ends off the surface on the way that it came.
TEST_P(GrblDeviceFaults, AStopAtAnyMomentOfATouchEndsOffTheSurface) {
    device_options.motion.feeds.probe_mm_per_s = 1.0;  // slow enough for the moments to differ
    int moments = 0;
    for (double moment = 0.0; moment < 4.0; moment += 0.02) {
        SCOPED_TRACE(moment);
        power_on();
        stop = {};
        ready();
        ASSERT_EQ(device->guarded_move({10.5, 0, 0}, Pace::travel).outcome, Outcome::reached);
        const double begin = seconds();
        stream->before_read = [&] {
            if (seconds() >= begin + moment) stop.request_stop();
        };
        std::optional<MoveResult> result;
        try {
            result = probe();
        } catch (const Stopped&) {
            ++moments;
        }
        if (result) expect_touch(*result, kTouch);
        EXPECT_FALSE(tool->is_moving());
        EXPECT_FALSE(tool->is_probe_closed());
        EXPECT_NEAR((tool_at() - Point(10.5, 0, 0)).norm(), 0, kMicrometre);
        EXPECT_NEAR((device->position() - tool_at()).norm(), 0, kMicrometre);
        EXPECT_EQ(tool->audit().unsafe_moves, 0U);
        stream->before_read = nullptr;
        if (!stop.token().stop_requested()) break;
        EXPECT_THROW((void)probe(), Stopped);
    }
    EXPECT_GT(moments, 20);
}

// What moves in a retreat may be a long way from what it left.
TEST_P(GrblDeviceFaults, AStopInARetreatStopsThere) {
    power_on();
    behind_its_back("G21 G90 G38.3 X1 Y-2 Z3 F300\n");
    connect();
    stream->before_read = [&] {
        if (tool_at().x() > 12) stop.request_stop();
    };
    EXPECT_THROW(device->retreat({40, 0, 0}), Stopped);
    EXPECT_LT(tool_at().x(), 15);
    EXPECT_NEAR((device->position() - tool_at()).norm(), 0, kMicrometre);
    EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre);
}

TEST_P(GrblDeviceFaults, AStopBeforeAMoveMovesNothing) {
    ready();
    stop.request_stop();
    EXPECT_THROW((void)probe(), Stopped);
    EXPECT_EQ(grbl->counts().probes, 0U);
}

TEST_P(GrblDeviceFaults, ToStopWhatDoesNotMoveDoesNothing) {
    ready();
    device->stop();
    EXPECT_EQ(grbl->counts().resets, 0U);
    expect_touch(probe(), kTouch);
}

// --- the probe -------------------------------------------------------------------------------------------------------

TEST_P(GrblDeviceFaults, ASpuriousTriggerIsAContactThatDidNotHold) {
    for (const double share : {0.0, 0.01, 0.5, 0.99}) {
        SCOPED_TRACE(share);
        options.faults = {{Kind::spurious_trigger, When::probe, 1, share}};
        power_on();
        ready();
        const MoveResult result = device->guarded_move({20, 10, 0}, Pace::probe);
        ASSERT_EQ(result.outcome, Outcome::contact);
        EXPECT_FALSE(result.held);
        EXPECT_EQ(device->guarded_move({20, 10, 0}, Pace::probe).outcome, Outcome::reached);
        EXPECT_NEAR((tool_at() - Point(20, 10, 0)).norm(), 0, kMicrometre);
    }
}

TEST_P(GrblDeviceFaults, AProbeThatBouncesTouchesWhereItTouchedFirstAndIsFreedOfIt) {
    for (const double times : {1.0, 3.0, 8.0, 20.0}) {
        SCOPED_TRACE(times);
        options.faults = {{Kind::bounce, When::probe, 1, times}};
        power_on();
        ready();
        expect_touch(probe(), kTouch);
        EXPECT_NEAR((tool_at() - Point(10.5, 0, 0)).norm(), 0, kMicrometre);
        expect_touch(probe(), kTouch);
    }
}

TEST_P(GrblDeviceFaults, AProbeThatStaysClosedAtTheEndOfItsWayBackIsAProbeClosed) {
    tool_options.start = Point(9.5, 0, 0) + kOrigin;
    connect();
    const std::string message = message_of<ProbeClosed>([&] { device->retreat({9.8, 0, 0}); });
    EXPECT_THAT(message, HasSubstr("stays closed although the tool went back to (9.8, 0, 0)"));
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::probe), PositionLost);
    EXPECT_NEAR((tool_at() - Point(9.8, 0, 0)).norm(), 0, kMicrometre) << "never past its way back";
}

// Nothing that a controller says tells a missed trigger from free space: what it says is passed on as it is.
TEST_P(GrblDeviceFaults, AMissedTriggerIsNotMadeUp) {
    options.faults = {{Kind::missed_trigger, When::probe, 1}};
    allowed_unsafe_moves = 1;
    ready();
    EXPECT_EQ(device->guarded_move({5, 0, 0}, Pace::probe).outcome, Outcome::reached);
    EXPECT_NEAR((tool_at() - Point(5, 0, 0)).norm(), 0, kMicrometre);
}

TEST_P(GrblDeviceFaults, ATouchThatRanOnFartherThanTheOvertravelIsAFault) {
    tool_options.motion.latency = Seconds(0.06);  // more than the driver was told, and $$ does not say it
    device_options.motion.overtravel_mm = 2.0;
    tool_options.motion.overtravel_mm = 3.0;
    ready();
    EXPECT_THAT(message_of<DeviceError>([&] { (void)device->guarded_move({0, 0, 0}, Pace::travel); }), HasSubstr("overtravel"));
    EXPECT_FALSE(tool->is_probe_closed()) << "it was taken off the surface first";
}

// --- what else runs --------------------------------------------------------------------------------------------------

TEST_P(GrblDeviceFaults, WhatRunsIsRefusedBeforeTheFirstMove) {
    const std::vector<std::pair<std::string, std::string>> kCases{{"M3S1000", "spindle is on (M3; M5 ends it)"},
                                                                  {"M4S1000", "spindle is on (M4; M5 ends it)"},
                                                                  {"M7", "mist is on (M7; M9 ends it)"},
                                                                  {"M8", "coolant is on (M8; M9 ends it)"}};
    for (const auto& [command, what] : kCases) {
        for (const Homing homing : {Homing::require, Homing::run, Homing::skip}) {
            SCOPED_TRACE(command);
            device_options.homing = homing;
            power_on();
            behind_its_back("$X\n" + command + "\n");
            connect();
            EXPECT_THAT(message_of<DeviceError>([&] { device->make_ready(); }), HasSubstr(what));
            EXPECT_THAT(message_of<DeviceError>([&] { device->retreat({25, 0, 0}); }), HasSubstr(what));
            EXPECT_EQ(tool->audit().moves, 0U);
            EXPECT_EQ(tool_at(), Point(20, 0, 0));
            behind_its_back("M5\nM9\n");
            expect_touch((ready(), probe()), kTouch);
        }
    }
}

TEST_P(GrblDeviceFaults, InLaserModeItIsTheLaserThatIsOn) {
    power_on();
    behind_its_back("$32=1\nM4S0\n");
    connect();
    EXPECT_THAT(message_of<DeviceError>([&] { device->make_ready(); }), HasSubstr("laser is on (M4; M5 ends it)"));
    behind_its_back("M5\n");
    expect_touch((ready(), probe()), kTouch);
}

TEST_P(GrblDeviceFaults, AFeedOverrideIsSetTo100BeforeTheFirstMove) {
    for (const std::string key : {"\x91", "\x92"}) {
        power_on();
        for (int k = 0; k < 10; ++k) grbl->receive(key);
        ready();
        const double begin = seconds();
        expect_touch(probe(), kTouch);
        EXPECT_NEAR(seconds() - begin, 10.0 / 5, 0.5) << "at the feed that was told";
        EXPECT_LT(tool->audit().deepest_mm, 1.01 * stopping_distance(device_options.motion, 5) + kMicrometre);
    }
}

TEST_P(GrblDeviceFaults, AFeedOverrideThatStaysIsRefusedBeforeTheFirstMove) {
    power_on();
    for (int k = 0; k < 10; ++k) grbl->receive("\x91");
    connect();
    // Every byte that would set it gets lost.
    stream->before_read = [this] { grbl->receive("\x91\x91\x91\x91\x91\x91\x91\x91\x91\x91"); };
    EXPECT_THAT(message_of<DeviceError>([&] { device->make_ready(); }), HasSubstr("feed override is 200 % (set it to 100 %)"));
    EXPECT_EQ(tool->audit().moves, 0U);
}

TEST_P(GrblDeviceFaults, AControllerThatNeverReportsOverridesIsAccepted) {
    options.reports_overrides = false;
    power_on();
    for (int k = 0; k < 10; ++k) grbl->receive("\x91");
    ready();
    expect_touch(probe(), kTouch);
    EXPECT_LT(tool->audit().deepest_mm, 1.01 * stopping_distance(device_options.motion, 5) + kMicrometre) << "it was set all the same";
    for (const MachineSetting& s : report_on(*device).settings) {
        if (s.name != "feed override") continue;
        EXPECT_EQ(s.value, "not reported");
    }
    behind_its_back("M3S1\n");
    connect();
    EXPECT_THAT(message_of<DeviceError>([&] { device->make_ready(); }), HasSubstr("spindle")) << "$G tells";
}

// What moves in a retreat may be a long way from what it left.
TEST_P(GrblDeviceFaults, WhatIsSwitchedOnInARetreatStopsItThere) {
    power_on();
    behind_its_back("G21 G90 G38.3 X1 Y-2 Z3 F300\n");
    connect();
    stream->before_read = [&] {
        if (tool_at().x() < 12) return;
        grbl->receive("\x91");
        stream->before_read = nullptr;
    };
    EXPECT_THAT(message_of<DeviceError>([&] { device->retreat({40, 0, 0}); }), AllOf(HasSubstr("override"), HasSubstr("and rests at")));
    EXPECT_LT(tool_at().x(), 15);
    EXPECT_NEAR((device->position() - tool_at()).norm(), 0, kMicrometre);
}

// Also on the way back, which is guarded and at the probe feed.
TEST_P(GrblDeviceFaults, WhatIsSwitchedOnInMidMoveStopsTheToolAndTakesItBack) {
    const std::vector<std::pair<VirtualFault, std::string>> kCases{{{Kind::spindle, When::time, 0, 3}, "spindle is on (M3"},
                                                                   {{Kind::spindle, When::time, 0, 4}, "spindle is on (M4"},
                                                                   {{Kind::pendant_key, When::time, 0, 0xA0}, "coolant is on (M8"},
                                                                   {{Kind::pendant_key, When::time, 0, 0xA1}, "mist is on (M7"},
                                                                   {{Kind::pendant_key, When::time, 0, 0x91}, "feed override is 110 %"}};
    const double moment = mid_move();
    for (const auto& [fault, what] : kCases) {
        SCOPED_TRACE(what);
        options.faults = {fault};
        options.faults[0].at = moment;
        power_on();
        ready();
        EXPECT_THAT(message_of<DeviceError>([&] { (void)probe(); }), AllOf(HasSubstr(what), HasSubstr("went back to (20, 0, 0)")));
        EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
        EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre) << "no step is lost";
        EXPECT_EQ(tool->audit().deepest_mm, 0.0);
        EXPECT_EQ(grbl->counts().probes, 2U) << "there and back";
        EXPECT_THROW((void)probe(), PositionLost) << "nothing moves before a new connection";
        device_options.homing = Homing::require;
        expect_touch((ready(), probe()), kTouch);
    }
}

// The tool touches before the next report: the answer is true, and nothing moves after it.
TEST_P(GrblDeviceFaults, WhatIsSwitchedOnJustBeforeATouchIsFoundBeforeTheNextMove) {
    double moment = 0;
    ready();
    once_within(10.2, [&] { moment = seconds(); });
    (void)probe();
    for (const VirtualFault& fault : {VirtualFault{Kind::spindle, When::time, moment, 3}, {Kind::pendant_key, When::time, moment, 0x91}}) {
        options.faults = std::vector<VirtualFault>(10, fault);
        power_on();
        ready();
        try {
            expect_touch(probe(), kTouch);
            EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), DeviceError);
            EXPECT_NEAR((tool_at() - Point(10.5, 0, 0)).norm(), 0, kMicrometre);
        } catch (const DeviceError&) {
            EXPECT_FALSE(tool->is_probe_closed());
        }
        EXPECT_FALSE(tool->is_moving());
        EXPECT_LT(tool->audit().deepest_mm, device_options.motion.overtravel_mm);
    }
}

// Whenever it comes, the tool is not deeper than the probe gives way, and ends outside.
TEST_P(GrblDeviceFaults, AnOverrideOf200AtAnyMomentOfATouchEndsOutside) {
    int stopped = 0;
    for (double moment = 0.0; moment < 3.0; moment += 0.05) {
        SCOPED_TRACE(moment);
        options.faults.clear();
        power_on();
        ready();
        options.faults = std::vector<VirtualFault>(10, {Kind::pendant_key, When::time, seconds() + moment, 0x91});
        power_on();
        ready();
        try {
            expect_touch(probe(), kTouch);
            expect_touch(probe(), kTouch);
        } catch (const DeviceError& fault) {
            EXPECT_THAT(fault.what(), HasSubstr("feed override"));
            ++stopped;
        }
        EXPECT_FALSE(tool->is_moving());
        EXPECT_FALSE(tool->is_probe_closed());
        EXPECT_LT(tool->audit().deepest_mm, device_options.motion.overtravel_mm);
        EXPECT_FALSE(ball.contains(tool_at()));
    }
    EXPECT_GT(stopped, 30);
}

TEST_P(GrblDeviceFaults, AnOverrideBelow100IsTheOperatorsDoing) {
    tool_options.start = Point(40, 0, 0) + kOrigin;
    options.faults = std::vector<VirtualFault>(9, {Kind::pendant_key, When::time, 1.0, 0x92});
    ready();
    const double begin = seconds();
    expect_touch(probe(), kTouch);
    EXPECT_GT(seconds() - begin, 50) << "it was not slow, so the test says nothing";
}

TEST_P(GrblDeviceFaults, CheckTellsWhatRunsAndChangesNothing) {
    power_on();
    behind_its_back("$32=1\nM3S100\nM8\n");
    for (int k = 0; k < 5; ++k) grbl->receive("\x91");
    connect();
    const auto found = [](const MachineReport& report, const std::string& name) {
        for (const MachineSetting& s : report.settings) {
            if (s.name == name) return s;
        }
        return MachineSetting{"none", "none", "none"};
    };
    MachineReport report = report_on(*device);
    EXPECT_EQ(found(report, "laser").value, "on");
    EXPECT_THAT(found(report, "laser").problem, HasSubstr("M5"));
    EXPECT_EQ(found(report, "$32 laser mode").problem, "");
    EXPECT_EQ(found(report, "coolant").value, "on");
    EXPECT_EQ(found(report, "feed override").value, "150 %");
    EXPECT_THAT(found(report, "feed override").problem, HasSubstr("100 %"));
    EXPECT_THAT(behind_its_back("$G\n"), Contains(HasSubstr(" M3 M8 ")));
    behind_its_back("$32=0\nM5\nM9\n\x90");
    connect();
    report = report_on(*device);
    EXPECT_EQ(found(report, "spindle").value, "off");
    EXPECT_EQ(found(report, "coolant").value, "off");
    EXPECT_EQ(found(report, "feed override").value, "100 %");
    EXPECT_EQ(found(report, "feed override").problem, "");
}

// --- positions that cannot be true -----------------------------------------------------------------------------------

struct FalsePosition {
    Kind kind;
    double argument = 0.0;
};
const std::vector<FalsePosition> kFalsePositions{{Kind::position_zero},        {Kind::position_frozen},     {Kind::position_swapped},
                                                 {Kind::position_ahead, 30},   {Kind::position_ahead, -30}, {Kind::position_beside, 30},
                                                 {Kind::position_beside, 3},   {Kind::position_ahead, 3},   {Kind::position_ahead, -3},
                                                 {Kind::position_beside, 0.1}, {Kind::position_ahead, -0.2}};

// From a contact on. The machine's own account: no deeper than the first stop, nothing unguarded, nothing outside the way that it came.
TEST_P(GrblDeviceFaults, APositionThatIsFalseFromAContactOnMovesNothingElsewhere) {
    for (const Point& target : {Point(0, 0, 0), Point(-45, 0, 0), Point(0, 4, -3)}) {
        for (const FalsePosition& lie : kFalsePositions) {
            for (const double contact : {1.0, 2.0}) {
                for (const Pace pace : {Pace::travel, Pace::probe}) {
                    SCOPED_TRACE(testing::Message() << "kind " << static_cast<int>(lie.kind) << ' ' << lie.argument << " to "
                                                    << target.transpose() << ", contact " << contact);
                    options.faults = {{lie.kind, When::contact, contact, lie.argument}};
                    power_on();
                    ready();
                    const Point touch = *ball.first_hit({{20, 0, 0}, target});
                    const auto move = [&] {
                        expect_touch(device->guarded_move(target, pace), touch);
                        return device->guarded_move(target, pace);
                    };
                    const std::string message = message_of<BadAnswer>([&] { (void)move(); });
                    EXPECT_THAT(message, AnyOf(HasSubstr("may be pressed"), HasSubstr("reports that its probe changed")));
                    EXPECT_FALSE(tool->is_moving());
                    EXPECT_LT(distance_to({{20, 0, 0}, target}, tool_at()), 2 * kMicrometre) << "beside its way";
                    const double overrun = stopping_distance(device_options.motion, device_options.motion.feeds.of(pace));
                    EXPECT_LT(tool->audit().deepest_mm, overrun + 2 * kMicrometre) << "it moved on";
                    const auto moves = tool->audit().moves;
                    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::probe), PositionLost);
                    EXPECT_EQ(tool->audit().moves, moves);
                }
            }
        }
    }
}

// ... and while it is stopped by the operator.
TEST_P(GrblDeviceFaults, APositionThatIsFalseAsItIsStoppedMovesNothing) {
    const double moment = mid_move();
    for (const FalsePosition& lie : kFalsePositions) {
        if (lie.kind == Kind::position_frozen || (lie.kind == Kind::position_ahead && std::abs(lie.argument) < 10)) continue;
        SCOPED_TRACE(testing::Message() << "kind " << static_cast<int>(lie.kind) << ' ' << lie.argument);
        options.faults = {{lie.kind, When::time, moment, lie.argument}};
        stop = {};
        power_on();
        ready();
        stream->before_read = [&] {
            if (seconds() >= moment) stop.request_stop();
        };
        EXPECT_THAT(message_of<BadAnswer>([&] { (void)probe(); }), HasSubstr("not on its way"));
        EXPECT_FALSE(tool->is_moving());
        EXPECT_GT(tool_at().x(), 13.9);
        EXPECT_LT(tool_at().x(), 15);
        EXPECT_EQ(grbl->counts().probes, 1U);
    }
    stop = {};
}

// --- off the surface, however far it ran on --------------------------------------------------------------------------

// At 80 mm/s, 2.5 ms make 0.2 mm.
TEST_P(GrblDeviceFaults, ALatchThatIsOffAlongTheWayEndsOpenAllTheSame) {
    device_options.motion.acceleration_mm_per_s2 = tool_options.motion.acceleration_mm_per_s2 = 2000;
    device_options.motion.feeds.travel_mm_per_s = 80;
    for (const double retract : {0.5, 0.1, 0.01}) {
        for (const double late : {0.0025, 0.001, -0.0025}) {
            SCOPED_TRACE(testing::Message() << late << " s late, retract " << retract);
            device_options.motion.retract_mm = retract;
            options.faults = {{Kind::latch_late, When::time, 0, late}};
            power_on();
            ready();
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(device->guarded_move({0, 0, 0}, Pace::travel).position.x(), kRadius, 0.201) << "what was latched";
                EXPECT_FALSE(tool->is_probe_closed());
                EXPECT_FALSE(ball.contains(tool_at()));
                EXPECT_LT(tool_at().x(), kRadius + retract + 0.25);
                ASSERT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached);
            }
        }
    }
}

// 5 mm before the touch, or as far behind where the tool stands.
TEST_P(GrblDeviceFaults, ALatchThatCannotBeTrueIsNoAnswer) {
    for (const double late : {-1.0, 1.0}) {
        SCOPED_TRACE(late);
        options.faults = {{Kind::latch_late, When::time, 0, late}};
        power_on();
        ready();
        EXPECT_THAT(message_of<BadAnswer>([&] { (void)probe(); }), AnyOf(HasSubstr("past where it reports"), HasSubstr("may be pressed")));
        EXPECT_FALSE(tool->is_moving());
        EXPECT_LT(tool->audit().deepest_mm, stopping_distance(device_options.motion, 5) + 2 * kMicrometre) << "it moved on";
        EXPECT_LT(tool_at().x(), 20);
        EXPECT_THROW((void)probe(), PositionLost);
    }
}

TEST_P(GrblDeviceFaults, AToolThatRanOnTooFarIsTakenOffAndThenTold) {
    for (const double latency : {0.06, 0.3, 0.45}) {
        SCOPED_TRACE(latency);
        tool_options.motion.latency = Seconds(latency);
        tool_options.motion.overtravel_mm = 20.0;  // as deep as it goes is what the test makes
        power_on();
        ready();
        EXPECT_THAT(message_of<DeviceError>([&] {
                        (void)device->guarded_move({0, 0, 0}, Pace::travel);
                    }),
                    AnyOf(HasSubstr("overtravel"), HasSubstr("past where it reports")));
        EXPECT_GT(tool->audit().deepest_mm, device_options.motion.overtravel_mm);
        EXPECT_FALSE(tool->is_probe_closed());
        EXPECT_NEAR((tool_at() - Point(10.5, 0, 0)).norm(), 0, kMicrometre);
        EXPECT_THROW((void)probe(), PositionLost);
    }
}

// The machine says 200 mm/s² and has 90: from 20 mm/s it needs 2.3 mm.
TEST_P(GrblDeviceFaults, AMachineThatBrakesMoreWeaklyThanItSaysIsTakenOffTheSurface) {
    tool_options.motion.acceleration_mm_per_s2 = 90;
    tool_options.motion.overtravel_mm = 3;
    power_on();
    behind_its_back("$120=200\n$121=200\n$122=200\n");
    ready();
    EXPECT_THAT(message_of<DeviceError>([&] { (void)device->guarded_move({0, 0, 0}, Pace::travel); }), HasSubstr("overtravel"));
    EXPECT_GT(tool->audit().deepest_mm, 2.2);
    EXPECT_FALSE(tool->is_probe_closed());
    EXPECT_NEAR((tool_at() - Point(10.5, 0, 0)).norm(), 0, kMicrometre);
}

TEST_P(GrblDeviceFaults, AProbeThatStaysClosedAllTheWayBackIsToldAsPressed) {
    ready();
    once_within(10, [&] { tool->press(true); });
    EXPECT_THAT(message_of<ProbeClosed>([&] { (void)probe(); }), HasSubstr("pressed"));
    EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre) << "no farther than the start";
    EXPECT_THROW((void)probe(), PositionLost);
}

// Somebody lets go of it while it is drawn back.
TEST_P(GrblDeviceFaults, ATouchThatGivesWayLateIsRetractedFromWhereItOpened) {
    ready();
    once_within(10, [&] {
        tool->press(true);
        stream->before_read = [&] {
            if (tool_at().x() < 12) return;
            tool->press(false);
            stream->before_read = nullptr;
        };
    });
    expect_touch(probe(), kTouch);
    EXPECT_FALSE(tool->is_probe_closed());
    EXPECT_GT(tool_at().x(), 12.4);
    EXPECT_LT(tool_at().x(), 12.7);
    EXPECT_NEAR((device->position() - tool_at()).norm(), 0, kMicrometre);
}

}  // namespace
}  // namespace palpate::grbl_device_faults_test
