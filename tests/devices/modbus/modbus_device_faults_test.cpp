// What can go wrong with a Modbus controller, one fault a test: what the driver says, and where it leaves the tool.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "devices/errors.h"
#include "devices/modbus/modbus_bits.h"
#include "tests/devices/message_of.h"
#include "tests/devices/modbus/modbus_support.h"

namespace palpate::modbus_device_faults_test {
namespace {

using test::Machine;
using test::Wire;
using F = ModbusField;
using Outcome = MoveResult::Outcome;
using State = ModbusDevice::State;

constexpr double kRounding = 0.002;  // mm
constexpr Seconds kPatience{0.1};
// In reach, 36 mm from the start, with nothing between.
const Point kFar = test::kStart + Point(0, 0, 36);

void sleep(Seconds time) { std::this_thread::sleep_for(time); }

// A second host, on the controller itself.
void send(Machine& machine, const Point& target, std::uint16_t sequence) {
    const ModbusProfile profile = ModbusProfile::standard();
    const ModbusSpan span = span_of(profile, ModbusBlock::command);
    std::vector<std::uint16_t> words(static_cast<std::size_t>(span.registers), 0);
    const auto put = [&](F field, double value) { put_value(words, span.address, profile, field, value); };
    put(F::control_word, cia402::kEnableOperation | cia402::kNewSetPoint);
    for (int axis = 0; axis < 3; ++axis) put(axis_of(F::target_x, axis), (target + test::kOrigin)[axis]);
    put(F::velocity, 5.0);
    put(F::acceleration, 200.0);
    put(F::touch_probe_function, cia402::kProbeEnable | cia402::kProbePositiveEdge);
    put(F::stop_on_touch, 1);
    put(F::sequence, sequence);
    machine->with_controller([&](VirtualModbusController& c) {
        ASSERT_EQ(c.refuses_to_write(span.address, span.registers), std::nullopt);
        c.write(span.address, words);
    });
}

int sequence_of(Machine& machine) {
    return machine->with_controller(
        [](VirtualModbusController& c) { return get_word(c.registers(), c.first_address(), ModbusProfile::standard(), F::sequence_echo); });
}

void place(Machine& machine, const Point& tool) {
    machine->with_controller([&](VirtualModbusController& c) { c.tool().place(tool + test::kOrigin); });
}

// It stands, and not because it had heard nothing for so long.
void expect_halted(Machine& machine) {
    sleep(Seconds(0.3));
    EXPECT_FALSE(machine.is_moving());
    EXPECT_EQ(machine.heartbeat_stops(), 0U);
}

// Slow enough for something to be done in mid-move.
class ModbusDeviceFaults : public testing::TestWithParam<Wire> {
protected:
    void TearDown() override { test::expect_safe(machine); }
    [[nodiscard]] std::unique_ptr<ModbusDevice> impatient_device(const StopToken& stop = {}) {
        ModbusDeviceOptions options = machine.options();
        options.patience = kPatience;
        return std::make_unique<ModbusDevice>(options, machine.clock(), stop);
    }
    // The device has its tool where it says, and goes on.
    void expect_usable(ModbusDevice& device) {
        ASSERT_EQ(device.state(), State::idle);
        EXPECT_NEAR((machine.tool() - device.position()).norm(), 0, kRounding);
        EXPECT_EQ(device.guarded_move(device.position() + Point(1, 0, 0), Pace::probe).outcome, Outcome::reached);
    }
    Machine machine{GetParam(), test::machine_options(8.0)};
};

INSTANTIATE_TEST_SUITE_P(Wires, ModbusDeviceFaults, testing::Values(Wire::tcp, Wire::rtu),
                         [](const auto& wire) { return test::name_of(wire.param); });

// To send the rest of the move again would press the probe on, where the controller does not object by itself.
TEST_P(ModbusDeviceFaults, AMoveThatSilenceEndedOnTheSurfaceIsNotSentAgain) {
    const auto device = machine.device();
    machine.inject(MachineFault::missed_edge_in_silence);
    expect_says(message_of<BadAnswer>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "no touch was latched");
    EXPECT_GT(machine.tool().x(), test::kRadius);
    EXPECT_LT(machine.audit().deepest_mm, 0.1);
    expect_usable(*device);
}

TEST_P(ModbusDeviceFaults, AToolThatAKilledHostLeftOnTheSurfaceIsBroughtOff) {
    place(machine, {4.95, 0, 0});
    const auto device = machine.device();
    ASSERT_EQ(device->state(), State::locked);
    ASSERT_FALSE(device->report().is_enabled);
    device->retreat(test::kStart);
    EXPECT_NEAR((device->position() - Point(6, 0, 0)).norm(), 0, kRounding) << "a retract from where the probe opened";
    expect_usable(*device);
}

// PLCopen's MC_TouchProbe: re-triggering is rejected. The frame of a command may still come later, and must not pass for another one.
TEST_P(ModbusDeviceFaults, ARejectedCommandIsToldAndItsNumberIsGivenToNoOther) {
    const auto device = machine.device();
    ASSERT_EQ(device->guarded_move({19, 0, 0}, Pace::probe).outcome, Outcome::reached);
    ASSERT_EQ(sequence_of(machine), 1);
    // After heartbeat and status, for longer than it is tried.
    machine.inject({AnswerFault::Kind::exception, 3, {}, 6, 1.5 * test::kBusyTime});
    try {
        (void)device->guarded_move({12, 0, 0}, Pace::probe);
        FAIL() << "nothing was thrown";
    } catch (const DeviceRefused& refused) {
        EXPECT_EQ(refused.code(), 6);
    }
    EXPECT_EQ(sequence_of(machine), 1) << "it was not carried out";
    expect_usable(*device);
    EXPECT_EQ(sequence_of(machine), 3);
}

TEST_P(ModbusDeviceFaults, NumbersWrapAndPassOverWhatIsEchoed) {
    {
        const auto device = machine.device();
        ASSERT_EQ(device->guarded_move({19, 0, 0}, Pace::probe).outcome, Outcome::reached);
    }
    send(machine, {19, 0, 0}, 65535);
    const auto device = machine.device();
    EXPECT_EQ(device->guarded_move({18, 0, 0}, Pace::probe).outcome, Outcome::reached);
    EXPECT_EQ(sequence_of(machine), 0);
    send(machine, {18, 0, 0}, 1);
    EXPECT_EQ(device->guarded_move({17, 0, 0}, Pace::probe).outcome, Outcome::reached);
    EXPECT_EQ(sequence_of(machine), 2);
}

TEST_P(ModbusDeviceFaults, APositionThatIsLostInMidMoveHaltsTheAxes) {
    const auto device = machine.device();
    machine.inject(MachineFault::homing_lost);
    EXPECT_THROW((void)device->guarded_move(kFar, Pace::probe), PositionLost);
    EXPECT_EQ(device->state(), State::fault);
    expect_halted(machine);
}

TEST_P(ModbusDeviceFaults, ARetractThatTakesTooLongIsHalted) {
    place(machine, {4.9, 0, 0});
    const auto device = impatient_device();
    machine.inject(MachineFault::crawl);
    const Point near_by(6.5, 0, 0);
    EXPECT_THROW(device->retreat(near_by), DeviceTimeout);
    EXPECT_EQ(device->state(), State::locked);
    expect_halted(machine);
    device->retreat(near_by);
    expect_usable(*device);
}

TEST_P(ModbusDeviceFaults, AHaltThatIsIgnoredIsFoundOutAndSentAgain) {
    StopSource stop;
    const auto device = impatient_device(stop.token());
    machine.inject(MachineFault::ignored_halt);
    {
        const std::jthread helper([&] {
            test::wait_until_under_way(machine, test::kStart, 2.0);
            stop.request_stop();
        });
        expect_says(message_of<DeviceTimeout>([&] { (void)device->guarded_move(kFar, Pace::probe); }), "emergency stop");
    }
    EXPECT_EQ(device->state(), State::fault);
    expect_halted(machine);
}

TEST_P(ModbusDeviceFaults, ALatchOfAnEarlierMoveIsABadAnswerAndTheToolIsDrawnBack) {
    const auto device = machine.device();
    ASSERT_EQ(device->guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
    for (const Point& way : {Point(8, 0, 0), Point(8, 8, 0), Point(0, 8, 0)}) {
        ASSERT_EQ(device->guarded_move(way, Pace::travel).outcome, Outcome::reached);
    }
    machine.inject(MachineFault::stale_latch);
    expect_says(message_of<BadAnswer>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "latch of an earlier move");
    EXPECT_GT(machine.tool().y(), test::kRadius);
    expect_usable(*device);
}

// The driver was told of an acceleration that the machine does not have: at 20 mm/s it runs on by 1.04 mm.
TEST_P(ModbusDeviceFaults, AToolThatRanOnTooFarIsABadAnswerAndIsDrawnBack) {
    ModbusDeviceOptions options = machine.options();
    options.motion.acceleration_mm_per_s2 = 5000;
    options.motion.overtravel_mm = 0.5;
    options.motion.retract_mm = 2.0;
    ModbusDevice device(options, machine.clock());
    expect_says(message_of<BadAnswer>([&] { (void)device.guarded_move({0, 0, 0}, Pace::travel); }), "ran on by 1.04");
    EXPECT_GT(machine.tool().x(), test::kRadius);
    expect_usable(device);
}

TEST_P(ModbusDeviceFaults, ACommandThatIsNotTakenIsABadAnswer) {
    const auto device = machine.device();
    machine.inject(MachineFault::ignored_command);
    expect_says(message_of<BadAnswer>([&] { (void)device->guarded_move({12, 0, 0}, Pace::probe); }), "shows command 0 instead of 1");
    EXPECT_NEAR((machine.tool() - test::kStart).norm(), 0, kRounding);
    expect_usable(*device);
}

// Three answers are lost one after the other, each for longer than the controller waits.
TEST_P(ModbusDeviceFaults, AMoveThatSilenceEndedIsDrawnBackAfterTheHalt) {
    ModbusDeviceOptions options = machine.options();
    options.link.slowest_answer = Seconds(0.3);
    ModbusDevice device(options, machine.clock());
    for (const int nth : {13, 14, 15}) machine.inject({AnswerFault::Kind::lost, nth});
    EXPECT_THROW((void)device.guarded_move(kFar, Pace::probe), DeviceTimeout);
    EXPECT_EQ(machine.heartbeat_stops(), 1U);
    EXPECT_GT((machine.tool() - test::kStart).norm(), 1.0);
    expect_usable(device);
}

TEST_P(ModbusDeviceFaults, LimitsThatChangeAreABadAnswer) {
    machine.inject(MachineFault::unsteady_limits);
    expect_says(message_of<BadAnswer>([&] { (void)machine.device(); }), "other limits each time");
}

TEST_P(ModbusDeviceFaults, AFaultBeforeAMoveIsAnAlarmUntilItIsRecoveredFrom) {
    const auto device = machine.device();
    ASSERT_EQ(device->guarded_move({19, 0, 0}, Pace::probe).outcome, Outcome::reached);
    send(machine, {100, 0, 0}, 77);
    for (int i = 0; i < 2; ++i) {
        try {
            (void)device->guarded_move({12, 0, 0}, Pace::probe);
            FAIL() << "nothing was thrown";
        } catch (const DeviceAlarm& alarm) {
            EXPECT_EQ(alarm.code(), cia402::kLimitFault);
            expect_says(alarm.what(), "then recover");
        }
        EXPECT_EQ(device->state(), State::locked);
    }
    device->recover();
    expect_usable(*device);
}

TEST_P(ModbusDeviceFaults, AMachineThatMovesByItselfIsNotCommanded) {
    const auto device = machine.device();
    ASSERT_EQ(device->guarded_move({19, 0, 0}, Pace::probe).outcome, Outcome::reached);
    send(machine, kFar, 77);
    expect_says(message_of<BadAnswer>([&] { (void)device->guarded_move({12, 0, 0}, Pace::probe); }), "nothing was asked of it");
    EXPECT_EQ(device->state(), State::locked);
    EXPECT_EQ(sequence_of(machine), 77);
    device->recover();
    EXPECT_FALSE(machine.is_moving());
    expect_usable(*device);
}

TEST_P(ModbusDeviceFaults, AProbeThatStaysClosedIsToldAndRecoveredFromOnceItIsFree) {
    const auto device = machine.device();
    machine.inject(MachineFault::stuck_probe);
    expect_says(message_of<ProbeClosed>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "did not open on the way back");
    EXPECT_EQ(device->state(), State::fault);
    EXPECT_THROW(device->recover(), ProbeClosed);
    machine.mend();
    device->recover();
    expect_usable(*device);
}

TEST_P(ModbusDeviceFaults, AMoveThatTakesTooLongIsStopped) {
    const auto device = impatient_device();
    machine.inject(MachineFault::crawl);
    expect_says(message_of<DeviceTimeout>([&] {
                    (void)device->guarded_move({19, 0, 0}, Pace::probe);
                }),
                "does it take the velocity that it is given?");
    expect_usable(*device);
}

TEST(ModbusDevice, LimitsThatAreNoneAreRefused) {
    VirtualModbusOptions options = test::machine_options();
    options.tool.limits = {Point::Constant(40.0), Point::Constant(-40.0)};
    Machine machine(Wire::tcp, options);
    expect_says(message_of<DeviceError>([&] { (void)machine.device(); }), "set them in the controller");
}

// Six answers late by more than the heartbeat may be, each some looks after the move has been sent again.
TEST(ModbusDevice, AMoveThatSilenceEndsAgainAndAgainIsGivenUp) {
    Machine machine(Wire::tcp, test::machine_options(2.0));
    ModbusDeviceOptions options = machine.options();
    options.link.answer_timeout = Seconds(0.5);
    options.link.slowest_answer = Seconds(0.6);
    ModbusDevice device(options, machine.clock());
    for (const int nth : {14, 34, 54, 74, 94, 114}) machine.inject({AnswerFault::Kind::late, nth, Seconds(0.4)});
    expect_says(message_of<DeviceTimeout>([&] { (void)device.guarded_move(kFar, Pace::probe); }), "because our heartbeat came late");
    EXPECT_EQ(machine.heartbeat_stops(), 6U);
    EXPECT_EQ(device.state(), State::idle);
    EXPECT_NEAR((machine.tool() - device.position()).norm(), 0, kRounding);
    test::expect_safe(machine);
}

}  // namespace
}  // namespace palpate::modbus_device_faults_test
