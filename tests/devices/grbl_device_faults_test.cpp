// The driver and a machine on which something goes wrong: what comes back is true, or a DeviceError says what happened.
#include <optional>

#include "tests/devices/grbl_support.h"

namespace palpate {
namespace {

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
    device_options.kinematics.feeds.probe_mm_per_s = 1.0;  // slow enough for the moments to differ
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
        if (!stop.stop_requested()) break;
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
    tool_options.kinematics.latency = Seconds(0.06);  // more than the driver was told, and $$ does not say it
    device_options.kinematics.overtravel_mm = 2.0;
    tool_options.kinematics.overtravel_mm = 3.0;
    ready();
    EXPECT_THAT(message_of<DeviceError>([&] { (void)device->guarded_move({0, 0, 0}, Pace::travel); }), HasSubstr("overtravel"));
    EXPECT_FALSE(tool->is_probe_closed()) << "it was taken off the surface first";
}

}  // namespace
}  // namespace palpate
