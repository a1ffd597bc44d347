// What a driver must not do whatever a controller says (devices/FACTS.md, "Safety floor"), judged by the virtual machine's own account.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <functional>
#include <thread>

#include "devices/errors.h"
#include "devices/modbus/modbus_bits.h"
#include "tests/devices/message_of.h"
#include "tests/devices/modbus/modbus_support.h"

namespace palpate::modbus_device_safety_test {
namespace {

using test::expect_safe;
using test::Machine;
using test::Wire;
using F = ModbusField;
using Outcome = MoveResult::Outcome;
using State = ModbusDevice::State;

constexpr double kRounding = 0.002;  // mm
constexpr double kOvertravel = 2.0;  // mm

void sleep(Seconds time) { std::this_thread::sleep_for(time); }

void send(VirtualModbusController& c, const Point& target, std::uint16_t sequence) {
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
    c.write(span.address, words);
}

// Another master halts our move and begins its own.
void take_over(VirtualModbusController& c, const Point& target) {
    const std::array halt{static_cast<std::uint16_t>(cia402::kEnableOperation | cia402::kHalt)};
    c.write(ModbusProfile::standard()[F::control_word].address, halt);
    while (c.tool().is_moving()) c.advance(Seconds(0.001));
    send(c, target, 17);
}

std::string told_after(const std::function<void()>& call) { return message_of<DeviceError>(call); }

// A report that the tool cannot be where it is said to be, from a contact on.
class FalsePositions : public testing::TestWithParam<MachineFault> {};

INSTANTIATE_TEST_SUITE_P(Kinds, FalsePositions,
                         testing::Values(MachineFault::zero_position, MachineFault::swapped_words, MachineFault::shifted_along,
                                         MachineFault::shifted_beside));

TEST_P(FalsePositions, HaltAndMoveNothing) {
    for (const Pace pace : {Pace::probe, Pace::travel}) {
        Machine machine(Wire::tcp, test::machine_options(8.0));
        const auto device = machine.device();
        // Off every axis, so that no coordinate of a place on the way is 0.
        ASSERT_EQ(device->guarded_move({12, 1, 1}, Pace::travel).outcome, Outcome::reached);
        machine.inject(GetParam());
        const std::uint64_t before = machine.commands();
        const std::string message = message_of<BadAnswer>([&] { (void)device->guarded_move({-2, 1, 1}, pace); });
        EXPECT_LE(machine.commands(), before + 3) << "the command, its set-point bit taken back, one halt if it moved";
        expect_says(message, "where it cannot be");
        expect_says(message, "pressed");
        expect_says(message, "then recover");
        EXPECT_EQ(device->state(), State::fault);
        const Point rest = machine.true_tool();
        const std::uint64_t commands = machine.commands();
        EXPECT_FALSE(machine.is_moving());
        EXPECT_TRUE(machine.is_probe_closed());
        EXPECT_LE(machine.audit().deepest_mm, kOvertravel);
        EXPECT_EQ(machine.audit().moves, 2U) << "nothing but the two that were asked for";
        // Nor does it while the reports stay false, whatever is asked of it.
        EXPECT_THROW((void)device->guarded_move({12, 1, 1}, Pace::travel), DeviceError);
        EXPECT_THROW(device->recover(), DeviceError);
        EXPECT_EQ(machine.true_tool(), rest);
        EXPECT_LE(machine.commands(), commands);
        expect_safe(machine);
        // Once they are true again, it comes off along the way that it came.
        machine.mend();
        device->recover();
        EXPECT_EQ(device->state(), State::idle);
        EXPECT_FALSE(machine.is_probe_closed());
        EXPECT_NEAR((machine.true_tool() - device->position()).norm(), 0, kRounding);
        expect_safe(machine);
    }
}

// It is on the way, so it does no harm until the retract: that is made, and seen not to have been.
TEST(ModbusSafety, APositionThatStandsStillIsFoundOutAtTheRetract) {
    Machine machine(Wire::tcp, test::machine_options(8.0));
    const auto device = machine.device();
    machine.inject(MachineFault::frozen_position);
    const std::string message = message_of<BadAnswer>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); });
    expect_says(message, "nobody knows where the tool is");
    EXPECT_EQ(device->state(), State::fault);
    const Point rest = machine.true_tool();
    EXPECT_LE((rest - Point(test::kRadius, 0, 0)).norm(), 1.0 + kRounding) << "no farther than the retract";
    sleep(Seconds(0.3));
    EXPECT_EQ(machine.true_tool(), rest);
    EXPECT_LE(machine.audit().deepest_mm, kOvertravel);
    expect_safe(machine);
}

TEST(ModbusSafety, AWayThatLeadsFarBehindThePlaceOfATouchIsDrawnBackFromUntilTheProbeOpens) {
    Machine machine(Wire::tcp, test::machine_options(8.0));
    const auto device = machine.device();
    machine.inject(MachineFault::shifted_along);  // and 30 mm farther along is on the way, too
    EXPECT_THROW((void)device->guarded_move({-35, 0, 0}, Pace::probe), DeviceError);
    EXPECT_FALSE(machine.is_probe_closed());
    EXPECT_GT(machine.true_tool().x(), test::kRadius);
    EXPECT_LE(machine.audit().deepest_mm, kOvertravel);
    expect_safe(machine);
}

TEST(ModbusSafety, NeitherRecoverNorRetreatMoveAToolThatIsNotWhereItWas) {
    Machine machine(Wire::tcp, test::machine_options(8.0));
    const auto place = [&](const Point& tool) {
        machine->with_controller([&](VirtualModbusController& c) { c.tool().place(tool + test::kOrigin); });
    };
    place({4.95, 0, 0});
    const auto device = machine.device();
    place({4.5, 0.9, 0});
    expect_says(told_after([&] { device->retreat(test::kStart); }), "pressed");
    EXPECT_EQ(device->state(), State::locked);
    EXPECT_EQ(machine.audit().moves, 0U);
    (void)device->report();
    device->retreat(test::kStart);
    EXPECT_FALSE(machine.is_probe_closed());
    EXPECT_EQ(device->state(), State::idle);
}

// A machine of 80 mm/s that stops in 1.76 mm.
class FastMachine : public testing::Test {
protected:
    static VirtualModbusOptions fast_options() {
        VirtualModbusOptions options = test::machine_options(1.0);
        options.tool.motion.acceleration_mm_per_s2 = 2000;
        return options;
    }
    [[nodiscard]] ModbusDeviceOptions driver() const {
        ModbusDeviceOptions options = machine.options();
        options.motion.feeds.travel_mm_per_s = 80;
        options.motion.acceleration_mm_per_s2 = 2000;
        options.motion.retract_mm = 0.1;
        return options;
    }
    void expect_off(ModbusDevice& device) {
        EXPECT_FALSE(machine.is_probe_closed());
        EXPECT_GT(machine.true_tool().norm(), test::kRadius);
        EXPECT_EQ(device.state(), State::idle);
        EXPECT_NEAR((machine.true_tool() - device.position()).norm(), 0, kRounding);
        EXPECT_EQ(machine.audit().unguarded_moves, 0U);
        EXPECT_EQ(machine.audit().outside_limits, 0U);
    }
    Machine machine{Wire::tcp, fast_options()};
};

TEST_F(FastMachine, ALatchThatIsOffAlongTheWayDoesNotLeaveTheToolPressed) {
    ModbusDevice device(driver(), machine.clock());
    for (const double shift : {0.2, -0.2}) {
        ASSERT_EQ(device.guarded_move({15, 0, 0}, Pace::travel).outcome, Outcome::reached);
        machine->with_controller([&](VirtualModbusController& c) { c.shift_latches(shift); });
        const MoveResult result = device.guarded_move({0, 0, 0}, Pace::travel);
        EXPECT_NEAR(result.position.x(), test::kRadius - shift, kRounding);
        expect_off(device);
    }
    EXPECT_LT(machine.audit().deepest_mm, kOvertravel);
}

TEST_F(FastMachine, AnEdgeTooManyIsDrawnBackFromUntilTheProbeOpens) {
    ModbusDevice device(driver(), machine.clock());
    machine.inject(MachineFault::repeated_edge);
    expect_says(message_of<BadAnswer>([&] { (void)device.guarded_move({0, 0, 0}, Pace::travel); }), "counted 2 touches");
    expect_off(device);
    EXPECT_NEAR(device.position().x(), test::kRadius + 0.1, kRounding) << "a retract from where it opened";
    EXPECT_LT(machine.audit().deepest_mm, kOvertravel);
}

// It overruns by 2.5 mm, told 1.76.
TEST(ModbusSafety, AToolThatOverranIsDrawnBackUntilTheProbeOpens) {
    VirtualModbusOptions real = test::machine_options(1.0);
    real.tool.motion.acceleration_mm_per_s2 = 1368;
    Machine machine(Wire::tcp, real);
    ModbusDeviceOptions options = machine.options();
    options.motion.feeds.travel_mm_per_s = 80;
    options.motion.acceleration_mm_per_s2 = 2000;
    options.motion.retract_mm = 0.2;
    ModbusDevice device(options, machine.clock());
    expect_says(message_of<BadAnswer>([&] { (void)device.guarded_move({0, 0, 0}, Pace::travel); }), "ran on by 2.49");
    EXPECT_FALSE(machine.is_probe_closed());
    EXPECT_NEAR(machine.true_tool().x(), test::kRadius + 0.2, kRounding);
    EXPECT_EQ(device.state(), State::idle);
    EXPECT_EQ(machine.audit().unguarded_moves, 0U);
}

TEST(ModbusSafety, AProbeThatNeverOpensIsToldToBePressed) {
    Machine machine(Wire::tcp, test::machine_options(8.0));
    const auto device = machine.device();
    machine.inject(MachineFault::stuck_probe);
    expect_says(message_of<ProbeClosed>([&] { (void)device->guarded_move({0, 0, 0}, Pace::probe); }), "pressed");
    EXPECT_EQ(device->state(), State::fault);
    const std::uint64_t commands = machine.commands();
    sleep(Seconds(0.3));
    EXPECT_FALSE(machine.is_moving());
    EXPECT_EQ(machine.commands(), commands);
    expect_safe(machine);
}

// "Who did not start a motion does not add to it."
class ModbusInterference : public testing::Test {
protected:
    ~ModbusInterference() override { expect_safe(machine); }
    // What a move says that is disturbed so, and that nothing was commanded after that.
    std::string disturbed(const std::function<void(VirtualModbusController&)>& disturb) {
        std::uint64_t commands = 0;
        std::string message;
        {
            const std::jthread helper([&] {
                test::wait_until_under_way(machine, test::kStart, 3.0);
                machine->with_controller([&](VirtualModbusController& c) {
                    disturb(c);
                    commands = c.commands();
                });
            });
            message = told_after([&] { (void)device->guarded_move({8, 0, 0}, Pace::probe); });
        }
        sleep(Seconds(0.1));
        EXPECT_EQ(machine.commands(), commands);
        EXPECT_EQ(device->state(), State::fault);
        return message;
    }
    Machine machine{Wire::tcp, test::machine_options(8.0)};
    std::unique_ptr<ModbusDevice> device = machine.device();
};

TEST_F(ModbusInterference, AnotherMastersCommandIsLeftAlone) {
    const std::string message = disturbed([](VirtualModbusController& c) { take_over(c, {20, 5, 0}); });
    expect_says(message, "another master commands it: command 17 instead of 1");
    while (machine.is_moving()) sleep(Seconds(0.05));  // nobody keeps its heartbeat up
}

TEST_F(ModbusInterference, DisabledDrivesAreLeftAlone) {
    expect_says(disturbed([](VirtualModbusController& c) { c.disable(); }), "its drives are disabled");
    EXPECT_FALSE(machine.is_moving());
    expect_says(told_after([&] { (void)device->guarded_move({8, 0, 0}, Pace::probe); }), "recover first");
    device->recover();
    EXPECT_EQ(device->guarded_move({8, 0, 0}, Pace::probe).outcome, Outcome::reached);
}

TEST_F(ModbusInterference, AnEmergencyStopIsLeftAlone) {
    expect_says(disturbed([](VirtualModbusController& c) { c.press_emergency_stop(); }), "emergency stop");
    EXPECT_FALSE(machine.is_moving());
}

TEST_F(ModbusInterference, AQuickStopIsLeftAlone) {
    expect_says(disturbed([](VirtualModbusController& c) { c.quick_stop(); }), "quick stop");
    EXPECT_FALSE(machine.is_moving());
}

TEST_F(ModbusInterference, AQuickStopAtRestIsSeenBeforeTheNextMove) {
    EXPECT_EQ(device->guarded_move({19, 0, 0}, Pace::probe).outcome, Outcome::reached);
    std::uint64_t commands = 0;
    machine->with_controller([&](VirtualModbusController& c) {
        c.quick_stop();
        commands = c.commands();
    });
    expect_says(told_after([&] { (void)device->guarded_move({18, 0, 0}, Pace::probe); }), "it is in a quick stop");
    EXPECT_EQ(machine.commands(), commands);
}

// A controller may take a command at the rising edge of the bit alone, which a host that was killed may have left set.
TEST_F(ModbusInterference, AnEarlierHostsSetPointFallsBeforeTheFirstCommand) {
    EXPECT_EQ(device->guarded_move({19, 0, 0}, Pace::probe).outcome, Outcome::reached);
    std::uint64_t edges = 0;
    machine->with_controller([&](VirtualModbusController& c) {
        const std::array left{static_cast<std::uint16_t>(cia402::kEnableOperation | cia402::kNewSetPoint)};
        c.write(ModbusProfile::standard()[F::control_word].address, left);
        edges = c.set_points();
    });
    device.reset();
    device = machine.device();
    EXPECT_EQ(device->guarded_move({18, 0, 0}, Pace::probe).outcome, Outcome::reached);
    machine->with_controller([&](const VirtualModbusController& c) { EXPECT_EQ(c.set_points(), edges + 1); });
}

TEST(ModbusReport, AUnitThatIsCoarserThanTheResolutionIsAProblem) {
    ModbusReport report;
    report.position_unit_mm = 0.001;
    report.resolution_mm = 0.001;
    EXPECT_EQ(report.unit_problem(), "");
    report.position_unit_mm = 0.01;
    expect_says(report.unit_problem(), "say 0.01 or more there");
}

TEST_F(ModbusInterference, AHaltByAnotherIsLeftAlone) {
    expect_says(disturbed([](VirtualModbusController& c) {
                    const std::array halt{static_cast<std::uint16_t>(cia402::kEnableOperation | cia402::kHalt)};
                    c.write(ModbusProfile::standard()[F::control_word].address, halt);
                }),
                "latched no touch");
}

// Slow answers: the set-point bit is not taken back before the end.
TEST(ModbusSafety, AHaltByAnotherIsLeftAloneWhereAnswersAreSlow) {
    Machine machine(Wire::tcp, test::machine_options(1.0));
    machine.inject({AnswerFault::Kind::late, 1, Seconds(0.15), 4, Seconds(1e6)});
    ModbusDeviceOptions options = machine.options();
    options.link = machine->link();
    options.profile.read_write = true;
    ModbusDevice device(options, machine.clock());
    std::uint64_t commands = 0;
    {
        const std::jthread helper([&] {
            test::wait_until_under_way(machine, test::kStart, 3.0);
            machine->with_controller([&](VirtualModbusController& c) {
                const std::array halt{static_cast<std::uint16_t>(cia402::kEnableOperation | cia402::kHalt)};
                c.write(ModbusProfile::standard()[F::control_word].address, halt);
                commands = c.commands();
            });
        });
        expect_says(message_of<DeviceAlarm>([&] { (void)device.guarded_move({8, 0, 0}, Pace::probe); }), "latched no touch");
    }
    EXPECT_EQ(machine.commands(), commands);
    EXPECT_EQ(device.state(), State::fault);
    expect_safe(machine);
}

TEST_F(ModbusInterference, DrivesThatWereDisabledBetweenMovesAreNotEnabledByItself) {
    ASSERT_EQ(device->guarded_move({15, 0, 0}, Pace::probe).outcome, Outcome::reached);
    machine->with_controller([](VirtualModbusController& c) { c.disable(); });
    const std::uint64_t commands = machine.commands();
    expect_says(message_of<DeviceAlarm>([&] { (void)device->guarded_move({8, 0, 0}, Pace::probe); }), "its drives are disabled");
    EXPECT_EQ(machine.commands(), commands);
    EXPECT_EQ(device->state(), State::locked);
    device->recover();
    EXPECT_EQ(device->guarded_move({8, 0, 0}, Pace::probe).outcome, Outcome::reached);
}

}  // namespace
}  // namespace palpate::modbus_device_safety_test
