// The driver on a virtual controller: sockets, pseudo-terminals, libmodbus on both sides (devices/FACTS.md, "Modbus" and "Safety floor").
#include "devices/modbus/modbus_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include "devices/errors.h"
#include "tests/devices/message_of.h"
#include "tests/devices/modbus/modbus_support.h"
#include "tests/random.h"

namespace palpate::modbus_device_test {
namespace {

using test::expect_safe;
using test::Machine;
using test::wait_until_under_way;
using test::Wire;
using Outcome = MoveResult::Outcome;
using State = ModbusDevice::State;

constexpr double kMicrometre = 0.001;  // mm
constexpr double kRounding = 2 * kMicrometre;

long count(const MoveResult& result, DeviceEvent::Kind kind) {
    return std::ranges::count_if(result.events, [kind](const DeviceEvent& event) { return event.kind == kind; });
}

class ModbusDeviceOn : public testing::TestWithParam<Wire> {
protected:
    ~ModbusDeviceOn() override { expect_safe(machine); }
    Machine machine{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Wires, ModbusDeviceOn, testing::Values(Wire::tcp, Wire::rtu),
                         [](const auto& wire) { return test::name_of(wire.param); });

TEST_P(ModbusDeviceOn, ReachesATargetInFreeSpace) {
    const auto device = machine.device();
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_NEAR((device->position() - test::kStart).norm(), 0, 1e-9);
    const Point target(12.3456, 7, 8);
    const MoveResult result = device->guarded_move(target, Pace::travel);
    EXPECT_EQ(result, (MoveResult{Outcome::reached, target, {}}));
    EXPECT_EQ(device->position(), target);
    EXPECT_NEAR((machine.tool() - target).norm(), 0, kRounding);
    EXPECT_EQ(device->state(), State::idle);
}

// Only the latch is the contact: the tool runs on, and is drawn back.
TEST_P(ModbusDeviceOn, AContactIsTheLatchAndTheToolIsDrawnBack) {
    const auto device = machine.device();
    const MoveResult result = device->guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
    EXPECT_NEAR((device->position() - Point(test::kRadius + 1, 0, 0)).norm(), 0, kRounding);
    EXPECT_NEAR((machine.tool() - device->position()).norm(), 0, kRounding);
    EXPECT_GT(machine.audit().deepest_mm, 0.05) << "the tool did not run on, so the test says nothing";
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_EQ(device->guarded_move({6, 5, 0}, Pace::travel).outcome, Outcome::reached);
}

TEST_P(ModbusDeviceOn, IsNeverDrawnBackPastTheStart) {
    const auto device = machine.device();
    const Point near_by(test::kRadius + 0.3, 0, 0);
    ASSERT_EQ(device->guarded_move(near_by, Pace::travel).outcome, Outcome::reached);
    ASSERT_EQ(device->guarded_move({0, 0, 0}, Pace::touch).outcome, Outcome::contact);
    EXPECT_NEAR((device->position() - near_by).norm(), 0, kRounding);
    EXPECT_NEAR((machine.tool() - near_by).norm(), 0, kRounding);
}

TEST_P(ModbusDeviceOn, RandomMovesMeetTheSphereWhereItIs) {
    constexpr std::uint64_t kSeed = 3;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const auto device = machine.device();
    int contacts = 0;
    for (int i = 0; i < 25; ++i) {
        const Point start = device->position();
        const Point target = random.in_box(Point::Constant(-9), Point::Constant(9));
        const auto truth = machine.object().first_hit({start, target});
        // A hit that is nearer than rounding to the target may be missed or not.
        if (truth && (*truth - target).norm() < 10 * kMicrometre) continue;
        // Where the tool can run on past the middle of a short chord, the way back leads over a deeper place than it rests at, which the
        // tool's account calls unsafe although it is the way that the tool came.
        const double slant = truth ? std::abs((target - start).normalized().dot(truth->normalized())) : 1.0;
        if (slant < 0.25) continue;
        const MoveResult result = device->guarded_move(target, random.chance(0.5) ? Pace::travel : Pace::probe);
        ASSERT_EQ(result.outcome == Outcome::contact, truth.has_value()) << i;
        // A micrometre of the way is more than one of the touch where the way grazes the sphere.
        EXPECT_NEAR((result.position - truth.value_or(target)).norm(), 0, kRounding / slant) << i;
        contacts += truth.has_value() ? 1 : 0;
    }
    EXPECT_GT(contacts, 3);
}

TEST_P(ModbusDeviceOn, AMoveOfNoLengthSendsNothing) {
    const auto device = machine.device();
    const std::uint64_t requests = machine->requests();
    const Point target = test::kStart + Point(0.0002, 0, 0);
    EXPECT_EQ(device->guarded_move(target, Pace::probe), (MoveResult{Outcome::reached, target, {}}));
    EXPECT_EQ(machine->requests(), requests);
}

TEST_P(ModbusDeviceOn, AMoveBeyondTheLimitsIsNotSent) {
    const auto device = machine.device();
    const std::string message = message_of<OutOfLimits>([&] { (void)device->guarded_move({20, 0, 37.001}, Pace::travel); });
    expect_says(message, "(21, -2, 40.001) mm");
    EXPECT_EQ(machine.audit().moves, 0U);
    EXPECT_EQ(device->guarded_move({20, 0, 37}, Pace::travel).outcome, Outcome::reached);
    EXPECT_THROW((void)device->guarded_move({20, 0, std::nan("")}, Pace::travel), DeviceError);
    EXPECT_EQ(device->state(), State::idle);
}

// "After a late answer ... returns the previous request's value." Here: in whole moves, at random places.
TEST_P(ModbusDeviceOn, LateAnswersInMovesShiftNothing) {
    constexpr std::uint64_t kSeed = 17;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const auto device = machine.device();
    long repeated = 0;
    for (int i = 0; i < 12; ++i) {
        const Point target = i % 2 == 0 ? Point(0, 0, 0) : Point(9, random.uniform(-3, 3), random.uniform(-3, 3));
        const Point start = device->position();
        const auto truth = machine.object().first_hit({start, target});
        machine.inject({AnswerFault::Kind::late, 1 + static_cast<int>(random.below(6)), Seconds(random.uniform(0.11, 0.19))});
        const MoveResult result = device->guarded_move(target, Pace::probe);
        ASSERT_EQ(result.outcome == Outcome::contact, truth.has_value()) << i;
        EXPECT_NEAR((result.position - truth.value_or(target)).norm(), 0, kRounding) << i;
        repeated += count(result, DeviceEvent::Kind::repeated_command);
    }
    EXPECT_GT(repeated, 2);
}

// Answers that come later than anybody said: the line was not left alone for long enough. Every look at the status begins with a write,
// so that such an answer meets a request of another shape and is refused, and the move may fail, but not with another's values.
TEST_P(ModbusDeviceOn, AnswersLaterThanTheSlowestAreNotTakenForNewOnes) {
    constexpr std::uint64_t kSeed = 23;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const auto device = machine.device();
    int answered = 0;
    for (int i = 0; i < 8; ++i) {
        const Point target = i % 2 == 0 ? Point(0, 0, 0) : Point(9, random.uniform(-3, 3), random.uniform(-3, 3));
        const auto truth = machine.object().first_hit({device->position(), target});
        const Seconds delay = test::kSlowestAnswer * random.uniform(1.0, 2.0);
        machine.inject({AnswerFault::Kind::late, 1 + static_cast<int>(random.below(6)), delay});
        try {
            const MoveResult result = device->guarded_move(target, Pace::probe);
            ASSERT_EQ(result.outcome == Outcome::contact, truth.has_value()) << i;
            EXPECT_NEAR((result.position - truth.value_or(target)).norm(), 0, kRounding) << i;
            ++answered;
        } catch (const DeviceError&) {
            if (device->state() != State::idle) device->recover();
        }
        EXPECT_NEAR((machine.tool() - device->position()).norm(), 0, kRounding) << i;
    }
    EXPECT_GT(answered, 3);
}

TEST_P(ModbusDeviceOn, ALostAnswerToTheCommandDoesNotMoveTwice) {
    const auto device = machine.device();
    (void)device->guarded_move({19, 0, 0}, Pace::travel);  // enables the drives
    const std::uint64_t moves = machine.audit().moves;
    machine.inject({AnswerFault::Kind::lost, 3});  // after heartbeat and status
    const MoveResult result = device->guarded_move({12, 0, 0}, Pace::travel);
    EXPECT_EQ(result.outcome, Outcome::reached);
    EXPECT_EQ(count(result, DeviceEvent::Kind::repeated_command), 1);
    EXPECT_EQ(machine.audit().moves, moves + 1);
}

TEST(ModbusDevice, AnotherUnitsAnswerInMidMoveIsAskedForAgain) {
    Machine machine(Wire::rtu);
    const auto device = machine.device();
    machine.inject({AnswerFault::Kind::other_unit, 14});  // after the command
    const MoveResult result = device->guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
    EXPECT_EQ(count(result, DeviceEvent::Kind::repeated_command), 1);
}

TEST_P(ModbusDeviceOn, AnExceptionInMidMoveStopsTheToolAndDrawsItBack) {
    const auto device = machine.device();
    machine.inject({AnswerFault::Kind::exception, 8, {}, 4});
    try {
        (void)device->guarded_move({8, 0, 0}, Pace::probe);
        FAIL() << "nothing was thrown";
    } catch (const DeviceRefused& refused) {
        EXPECT_EQ(refused.code(), 4);
    }
    EXPECT_FALSE(machine.is_moving());
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_NEAR((machine.tool() - device->position()).norm(), 0, kRounding);
    EXPECT_EQ(device->guarded_move({8, 0, 0}, Pace::probe).outcome, Outcome::reached);
}

// "... an edge counter that makes a missed or repeated touch visible."
TEST_P(ModbusDeviceOn, AMissedEdgeIsABadAnswerAndTheToolIsDrawnBack) {
    const auto device = machine.device();
    machine.inject(MachineFault::missed_edge);
    expect_says(message_of<BadAnswer>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "no touch was latched");
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_GT((machine.tool()).norm(), test::kRadius);
    EXPECT_EQ(device->guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
}

TEST_P(ModbusDeviceOn, ARepeatedEdgeIsABadAnswerAndTheToolIsDrawnBack) {
    const auto device = machine.device();
    machine.inject(MachineFault::repeated_edge);
    expect_says(message_of<BadAnswer>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "counted 2 touches");
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_GT((machine.tool()).norm(), test::kRadius);
    EXPECT_EQ(device->guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
}

TEST_P(ModbusDeviceOn, ASpuriousTriggerIsAContactAndTheProbeIsOpenAgain) {
    const auto device = machine.device();
    machine.inject(MachineFault::spurious_trigger);
    const MoveResult result = device->guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_GT(result.position.norm(), test::kRadius + 0.5);
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_EQ(device->guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
    EXPECT_NEAR(device->position().norm(), test::kRadius + 1, kRounding);
}

TEST_P(ModbusDeviceOn, AFaultIsAnAlarmAndRecoveredFrom) {
    const auto device = machine.device();
    machine.inject(MachineFault::limit);
    try {
        (void)device->guarded_move({9, 0, 0}, Pace::travel);
        FAIL() << "nothing was thrown";
    } catch (const DeviceAlarm& alarm) {
        EXPECT_EQ(alarm.code(), 0x8612);
        expect_says(alarm.what(), "beyond the limits");
    }
    EXPECT_EQ(device->state(), State::fault);
    EXPECT_THROW((void)device->guarded_move({9, 0, 0}, Pace::travel), DeviceError);
    device->recover();
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_EQ(device->guarded_move({9, 0, 0}, Pace::travel).outcome, Outcome::reached);
}

TEST_P(ModbusDeviceOn, AClosedProbeAtConnectLocksUntilItIsFree) {
    machine->with_controller([](VirtualModbusController& c) { c.tool().place(test::kOrigin); });
    const auto device = machine.device();
    EXPECT_EQ(device->state(), State::locked);
    EXPECT_TRUE(device->report().is_probe_closed);
    EXPECT_THROW((void)device->guarded_move({9, 0, 0}, Pace::travel), ProbeClosed);
    EXPECT_THROW(device->recover(), ProbeClosed);
    machine->with_controller([](VirtualModbusController& c) { c.tool().place(test::kStart + test::kOrigin); });
    device->recover();
    EXPECT_EQ(device->guarded_move({9, 0, 0}, Pace::travel).outcome, Outcome::reached);
}

TEST_P(ModbusDeviceOn, AClosedProbeBeforeAMoveIsRefused) {
    const auto device = machine.device();
    machine->with_controller([](VirtualModbusController& c) { c.tool().place(test::kOrigin); });
    expect_says(message_of<ProbeClosed>([&] { (void)device->guarded_move({9, 0, 0}, Pace::travel); }), "closed before a move");
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_EQ(machine.audit().moves, 0U);
    machine->with_controller([](VirtualModbusController& c) { c.tool().place(test::kStart + test::kOrigin); });
    EXPECT_EQ(device->guarded_move({9, 0, 0}, Pace::travel).outcome, Outcome::reached);
}

TEST_P(ModbusDeviceOn, NothingMovesBeforeHoming) {
    machine->with_controller([](VirtualModbusController& c) { c.reset(); });
    const auto device = machine.device();
    EXPECT_EQ(device->state(), State::locked);
    expect_says(message_of<PositionLost>([&] { (void)device->guarded_move({9, 0, 0}, Pace::travel); }), "home it");
    EXPECT_THROW(device->recover(), PositionLost);
    EXPECT_EQ(machine.audit().moves, 0U);
    machine->with_controller([](VirtualModbusController& c) { c.home(); });
    device->recover();
    EXPECT_EQ(device->guarded_move({9, 0, 0}, Pace::travel).outcome, Outcome::reached);
}

TEST_P(ModbusDeviceOn, AMachineThatWasMovedByHandHasLostItsPosition) {
    const auto device = machine.device();
    machine->with_controller([](VirtualModbusController& c) { c.tool().place(Point(15, 0, 0) + test::kOrigin); });
    expect_says(message_of<PositionLost>([&] { (void)device->guarded_move({9, 0, 0}, Pace::travel); }), "moved by something else");
    EXPECT_EQ(machine.audit().moves, 0U);
    device->recover();
    EXPECT_NEAR((device->position() - Point(15, 0, 0)).norm(), 0, kRounding);
}

TEST_P(ModbusDeviceOn, StopAtRestKeepsThePosition) {
    const auto device = machine.device();
    device->stop();
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_NEAR((device->position() - test::kStart).norm(), 0, kRounding);
    EXPECT_EQ(device->guarded_move({9, 0, 0}, Pace::travel).outcome, Outcome::reached);
}

TEST_P(ModbusDeviceOn, AConnectionThatIsLostAtRestIsMadeAgain) {
    const auto device = machine.device();
    machine.inject({AnswerFault::Kind::hang_up, 1});
    const MoveResult result = device->guarded_move({9, 0, 0}, Pace::travel);
    EXPECT_EQ(result.outcome, Outcome::reached);
    EXPECT_EQ(count(result, DeviceEvent::Kind::reconnected), 1);
}

TEST_P(ModbusDeviceOn, ReportsWhatCheckShowsAndMovesNothing) {
    const auto device = machine.device();
    const ModbusReport report = device->report();
    EXPECT_EQ(report.identity, "palpate virtual probe 1");
    EXPECT_EQ(report.limits.min, Point::Constant(-40));
    EXPECT_EQ(report.limits.max, Point::Constant(40));
    EXPECT_TRUE(report.is_homed);
    EXPECT_TRUE(report.is_standing);
    EXPECT_FALSE(report.is_enabled);
    EXPECT_FALSE(report.is_probe_closed);
    EXPECT_EQ(report.fault_code, 0);
    EXPECT_EQ(machine.audit().moves, 0U);
    std::string all;
    for (const std::string& line : report.lines()) all += line + "\n";
    for (const char* what :
         {"palpate virtual probe 1", "unit 1 at", "standard", "(-40, -40, -40) mm", "homed: yes", "probe: open", "no fault"}) {
        expect_says(all, what);
    }
}

TEST_P(ModbusDeviceOn, AnotherControllerThanTheProfilesIsRefused) {
    ModbusDeviceOptions options = machine.options();
    options.profile.expected_identity = "ACME";
    expect_says(message_of<DeviceError>([&] { const ModbusDevice device(options, machine.clock()); }),
                "calls itself \"palpate virtual probe 1\"");
}

// "Feed such that stopping distance stays below the probe's overtravel."
TEST_P(ModbusDeviceOn, FeedsThatCannotStopInTheOvertravelAreRefused) {
    ModbusDeviceOptions options = machine.options();
    options.motion.feeds.probe_mm_per_s = 60;
    expect_says(message_of<DeviceError>([&] { const ModbusDevice device(options, machine.clock()); }), "lower that feed");
}

// At 20 mm/s the tool runs on by 1.04 mm. The chords are 1.5 mm and 0.6 mm long: it rests past the middle of the first, where the way back
// leads over the deepest place that it had come over, and has left the second on the far side.
TEST(ModbusDevice, AGrazingTouchIsDrawnBackAlongTheWayThatItCame) {
    for (const double height : {4.94, 4.99}) {
        Machine machine(Wire::tcp);
        const auto device = machine.device();
        const double half_chord = std::sqrt(test::kRadius * test::kRadius - height * height);
        ASSERT_EQ(device->guarded_move({8, height, 0}, Pace::travel).outcome, Outcome::reached);
        const MoveResult result = device->guarded_move({-8, height, 0}, Pace::travel);
        EXPECT_EQ(result.outcome, Outcome::contact);
        EXPECT_NEAR((result.position - Point(half_chord, height, 0)).norm(), 0, 0.02) << height;
        EXPECT_NEAR((machine.tool() - Point(half_chord + 1, height, 0)).norm(), 0, 0.02) << height;
        EXPECT_LT(machine.audit().deepest_mm, 0.1);
        EXPECT_EQ(machine.audit().unguarded_moves, 0U);
    }
}

// Slow machines: something can be done to them in mid-move.
class ModbusDeviceInMidMove : public testing::TestWithParam<Wire> {
protected:
    ~ModbusDeviceInMidMove() override { expect_safe(machine); }
    // 14 mm at 5 mm/s and 8 times the speed: 0.36 s.
    Machine machine{GetParam(), test::machine_options(8.0)};
    // Runs `disturb` once the tool is under way.
    template <class Disturb>
    auto meanwhile(const Disturb& disturb) {
        return std::jthread([this, disturb] {
            wait_until_under_way(machine, test::kStart, 2.0);
            disturb();
        });
    }
};

INSTANTIATE_TEST_SUITE_P(Wires, ModbusDeviceInMidMove, testing::Values(Wire::tcp, Wire::rtu),
                         [](const auto& wire) { return test::name_of(wire.param); });

TEST_P(ModbusDeviceInMidMove, AStopSlowsDownGoesBackAndThrows) {
    StopSource stop;
    const auto device = machine.device(stop.token());
    Point at_stop;
    {
        const auto helper = meanwhile([&] {
            at_stop = machine.tool();
            stop.request_stop();
        });
        expect_says(message_of<Stopped>([&] { (void)device->guarded_move({6, 0, 0}, Pace::probe); }), "went back to (20, 0, 0) mm");
    }
    EXPECT_FALSE(machine.is_moving());
    EXPECT_LT(at_stop.x(), test::kStart.x() - 0.5) << "it was under way";
    EXPECT_EQ(device->state(), State::idle);
    EXPECT_NEAR((machine.tool() - device->position()).norm(), 0, kRounding);
    EXPECT_NEAR((machine.tool() - test::kStart).norm(), 0, kRounding);
    const std::uint64_t moves = machine.audit().moves;
    EXPECT_THROW((void)device->guarded_move({6, 0, 0}, Pace::probe), Stopped);
    EXPECT_EQ(machine.audit().moves, moves);
}

// "... the controller decelerates and stops when the host is silent for 250 ms"
TEST_P(ModbusDeviceInMidMove, SilenceStopsTheAxesAndTheMoveGoesOnAfterwards) {
    ModbusDeviceOptions options = machine.options();
    options.link.answer_timeout = Seconds(0.5);
    options.link.slowest_answer = Seconds(0.6);
    ModbusDevice device(options, machine.clock());
    machine.inject({AnswerFault::Kind::late, 14, Seconds(0.4)});
    const MoveResult result = device.guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(machine.heartbeat_stops(), 1U);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
    EXPECT_EQ(count(result, DeviceEvent::Kind::repeated_command), 1);
}

TEST_P(ModbusDeviceInMidMove, AHostThatDiesLeavesAMachineThatStopsByItself) {
    {
        const auto device = machine.device();
        const auto helper = meanwhile([&] { machine->unplug(); });
        EXPECT_THROW((void)device->guarded_move({0, 0, 0}, Pace::probe), ConnectionLost);
        EXPECT_EQ(device->state(), State::lost);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    EXPECT_FALSE(machine.is_moving());
    EXPECT_EQ(machine.heartbeat_stops(), 1U);
    EXPECT_GT(machine.tool().x(), test::kRadius + 0.5);
}

TEST_P(ModbusDeviceInMidMove, AConnectionThatIsLostForAMomentCostsNothing) {
    const auto device = machine.device();
    machine.inject({AnswerFault::Kind::hang_up, 16});
    const MoveResult result = device->guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
    EXPECT_EQ(count(result, DeviceEvent::Kind::reconnected), 1);
    EXPECT_EQ(machine.heartbeat_stops(), 0U);
}

TEST_P(ModbusDeviceInMidMove, AMoveThatWasGivenUpWhileTheLineWasDownIsResumable) {
    ModbusDeviceOptions options = machine.options();
    options.link.reconnect_time = Seconds(2);
    ModbusDevice device(options, machine.clock());
    {
        const auto helper = meanwhile([&] {
            machine->unplug();
            std::this_thread::sleep_for(std::chrono::milliseconds(450));
            machine->replug();
        });
        expect_says(message_of<ConnectionLost>([&] { (void)device.guarded_move({0, 0, 0}, Pace::probe); }), "resume");
    }
    EXPECT_EQ(machine.heartbeat_stops(), 1U);
    EXPECT_FALSE(machine.is_moving());
    EXPECT_EQ(device.state(), State::fault);
    device.recover();
    EXPECT_EQ(device.state(), State::idle);
    EXPECT_NEAR((machine.tool() - device.position()).norm(), 0, kRounding);
    const MoveResult result = device.guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
}

TEST_P(ModbusDeviceInMidMove, ATouchWhileTheLineWasDownIsNotLost) {
    ModbusDeviceOptions options = machine.options();
    options.link.reconnect_time = Seconds(2);
    ModbusDevice device(options, machine.clock());
    (void)device.guarded_move({7, 0, 0}, Pace::probe);
    // 2 mm are left, 0.05 s: the touch comes before the silence is too long.
    machine.inject({AnswerFault::Kind::unplug, 4});
    MoveResult result;
    {
        const std::jthread helper([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(500));
            machine->replug();
        });
        result = device.guarded_move({0, 0, 0}, Pace::probe);
    }
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
    EXPECT_GE(count(result, DeviceEvent::Kind::reconnected), 1);
    EXPECT_EQ(device.state(), State::idle);
}

TEST_P(ModbusDeviceInMidMove, AControllerThatRestartsHasLostItsPosition) {
    const auto device = machine.device();
    {
        const auto helper = meanwhile([&] { machine->with_controller([](VirtualModbusController& c) { c.reset(); }); });
        expect_says(message_of<PositionLost>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "restarted");
    }
    EXPECT_EQ(device->state(), State::fault);
    EXPECT_THROW(device->recover(), PositionLost);
}

// The heartbeat is checked by both sides: a controller whose program stands still answers, but does not echo.
TEST_P(ModbusDeviceInMidMove, AProgramThatStandsStillIsFoundOut) {
    const auto device = machine.device();
    {
        const auto helper = meanwhile([&] { machine->with_controller([](VirtualModbusController& c) { c.freeze(); }); });
        expect_says(message_of<DeviceError>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "echo the heartbeat");
    }
    EXPECT_EQ(device->state(), State::fault);
    EXPECT_FALSE(machine.is_moving());
}

TEST_P(ModbusDeviceInMidMove, ACommandWhileTheAxesMoveIsRejected) {
    // PLCopen's MC_TouchProbe: re-triggering is rejected. A second host, on the controller itself.
    const auto device = machine.device();
    const auto helper = meanwhile([&] {
        machine->with_controller([](const VirtualModbusController& c) {
            EXPECT_EQ(c.refuses_to_write(256, 14), 6);
            EXPECT_EQ(c.refuses_to_write(256, 1), std::nullopt) << "the control word can halt it";
        });
    });
    EXPECT_EQ(device->guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
}

TEST(ModbusDevice, AnotherRegisterMapNeedsNoCode) {
    VirtualModbusOptions options = test::machine_options();
    options.profile.name = "shuffled";
    options.profile.word_order = ModbusWordOrder::low_first;
    options.profile.homed_bit = 9;
    options.profile.probe_closed_bit = 15;
    for (ModbusRegister& entry : options.profile.registers) entry.address = 40000 - entry.address - entry.registers();
    options.profile[ModbusField::velocity].unit = 0.01;
    options.profile[ModbusField::actual_y] = {39500, 32, true, 0.0005};
    Machine machine(Wire::tcp, options);
    ModbusDeviceOptions driver = machine.options();
    driver.profile = options.profile;
    ModbusDevice device(driver, machine.clock());
    const MoveResult result = device.guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(test::kRadius, 0, 0)).norm(), 0, kRounding);
    expect_safe(machine);
}

}  // namespace
}  // namespace palpate::modbus_device_test
