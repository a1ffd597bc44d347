// Slow, busy and absent controllers, and what `check` says of them.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "devices/errors.h"
#include "devices/modbus/modbus_bits.h"
#include "tests/devices/message_of.h"
#include "tests/devices/modbus/modbus_support.h"
#include "tests/random.h"

namespace palpate::modbus_device_timing_test {
namespace {

using test::expect_safe;
using test::Machine;
using test::Wire;
using Outcome = MoveResult::Outcome;
using State = ModbusDevice::State;

constexpr double kRounding = 0.002;  // mm
constexpr Seconds kForEver{1e6};
const Point kFar = test::kStart + Point(0, 0, 36);

void sleep(Seconds time) { std::this_thread::sleep_for(time); }

// A heartbeat and the status in one request, as the standard map has it; the times are the defaults.
ModbusDeviceOptions default_options(Machine& machine) {
    ModbusDeviceOptions options = machine.options();
    options.profile = ModbusProfile::standard();
    options.link = machine->link();
    return options;
}

TEST(ModbusTiming, OneRequestIsALookWhereTheControllerKnowsIt) {
    Machine machine(Wire::tcp);
    ModbusDevice device(default_options(machine), machine.clock());
    const std::uint64_t requests = machine->requests();
    EXPECT_EQ(device.report().look_requests, 1);
    EXPECT_EQ(machine->requests(), requests + 6) << "one, and five that are timed";
}

TEST(ModbusTiming, AControllerWithoutThatFunctionIsAskedTwice) {
    VirtualModbusOptions options = test::machine_options();
    options.profile.read_write = false;
    Machine machine(Wire::tcp, options);
    ModbusDevice device(default_options(machine), machine.clock());
    EXPECT_EQ(device.report().look_requests, 2);
    EXPECT_EQ(device.guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
}

TEST(ModbusTiming, RandomMovesMeetTheSphereWhereItIsInOneRequest) {
    constexpr std::uint64_t kSeed = 31;
    SCOPED_TRACE(seed_text(kSeed));
    for (const Wire wire : {Wire::tcp, Wire::rtu}) {
        Random random(kSeed);
        Machine machine(wire);
        ModbusDeviceOptions options = machine.options();
        options.profile.read_write = true;
        ModbusDevice device(options, machine.clock());
        for (int i = 0; i < 16; ++i) {
            const Point target = i % 2 == 0 ? Point(0, 0, 0) : Point(9, random.uniform(-3, 3), random.uniform(-3, 3));
            const auto truth = machine.object().first_hit({device.position(), target});
            if (i % 3 == 0) {
                machine.inject({AnswerFault::Kind::late, 1 + static_cast<int>(random.below(6)), Seconds(random.uniform(0.11, 0.19))});
            }
            const MoveResult result = device.guarded_move(target, Pace::probe);
            ASSERT_EQ(result.outcome == Outcome::contact, truth.has_value()) << i;
            EXPECT_NEAR((result.position - truth.value_or(target)).norm(), 0, kRounding) << i;
        }
        expect_safe(machine);
    }
}

struct Slowness {
    Seconds answer{0};
    Seconds scan{0};
    bool read_write = true;
};

class SlowControllers : public testing::TestWithParam<Slowness> {};

INSTANTIATE_TEST_SUITE_P(Times, SlowControllers,
                         testing::Values(Slowness{Seconds(0.05), Seconds(0), false}, Slowness{Seconds(0.1), Seconds(0), false},
                                         Slowness{Seconds(0.05), Seconds(0.1), false}, Slowness{Seconds(0), Seconds(0.2), false},
                                         Slowness{Seconds(0.1)}, Slowness{Seconds(0.2)}, Slowness{Seconds(0.22)},
                                         Slowness{Seconds(0.1), Seconds(0.1)}, Slowness{Seconds(0.2), Seconds(0.04)},
                                         Slowness{Seconds(0), Seconds(0.2)}));

// Moves of 2 s, and no heartbeat too late.
TEST_P(SlowControllers, Work) {
    const Slowness& slow = GetParam();
    VirtualModbusOptions options = test::machine_options(4.0);
    options.scan = slow.scan;
    Machine machine(Wire::tcp, options);
    if (slow.answer.count() > 0.0) machine.inject({AnswerFault::Kind::late, 1, slow.answer, 4, kForEver});
    ModbusDeviceOptions driver = default_options(machine);
    driver.profile.read_write = slow.read_write;
    ModbusDevice device(driver, machine.clock());
    EXPECT_EQ(device.report().timing_problem(), "");
    ASSERT_EQ(device.guarded_move({8, 0, 0}, Pace::probe).outcome, Outcome::reached);
    const MoveResult result = device.guarded_move({0, 0, 0}, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), test::kRadius, kRounding);
    EXPECT_EQ(device.state(), State::idle);
    EXPECT_EQ(machine.heartbeat_stops(), 0U);
    machine->with_controller([](const VirtualModbusController& c) { EXPECT_EQ(c.commands_without_edge(), 0U); });
    expect_safe(machine);
}

TEST(ModbusTiming, AnswersThatAreTooSlowAreAProblemOfCheck) {
    Machine machine(Wire::tcp);
    machine.inject({AnswerFault::Kind::late, 1, Seconds(0.3), 4, kForEver});
    ModbusDevice device(default_options(machine), machine.clock());
    const ModbusReport report = device.report();
    EXPECT_GE(report.look_time, Seconds(0.3));
    expect_says(report.timing_problem(), "no heartbeat for 250 ms");
    expect_says(report.timing_text(), "up to 225 ms will do");
}

TEST(ModbusTiming, TwoRequestsThatAreTooSlowCouldBeOne) {
    VirtualModbusOptions options = test::machine_options();
    options.profile.read_write = false;
    Machine machine(Wire::tcp, options);
    machine.inject({AnswerFault::Kind::late, 1, Seconds(0.15), 4, kForEver});
    ModbusDevice device(default_options(machine), machine.clock());
    expect_says(device.report().timing_problem(), "read_write: true");
}

class PassingExceptions : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Codes, PassingExceptions, testing::Values(5, 6, 11));

TEST_P(PassingExceptions, AreTriedAgainWhereverTheyCome) {
    Machine machine(Wire::tcp, test::machine_options(8.0));
    // One at every request of a whole touch, one after the other.
    for (int nth = 1; nth < 40; nth += 3) {
        const auto device = machine.device();
        const std::uint64_t moves = machine.audit().moves;
        machine.inject({AnswerFault::Kind::exception, nth, {}, GetParam()});
        ASSERT_EQ(device->guarded_move({7, 0, 0}, Pace::travel).outcome, Outcome::reached) << nth;
        ASSERT_EQ(device->guarded_move({8, 0, 0}, Pace::travel).outcome, Outcome::reached) << nth;
        EXPECT_EQ(machine.audit().moves, moves + 2) << "no command was carried out twice, " << nth;
    }
    const auto device = machine.device();
    machine.inject({AnswerFault::Kind::exception, 1, {}, GetParam(), Seconds(0.1)});
    EXPECT_EQ(device->guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
    EXPECT_EQ(machine.heartbeat_stops(), 0U);
    expect_safe(machine);
}

// 0Bh for 2 s in mid-move.
TEST(ModbusTiming, AGatewayThatLosesItsTargetIsToldToHaltUntilItHears) {
    Machine machine(Wire::tcp, test::machine_options(1.0));
    ModbusDevice device(default_options(machine), machine.clock());
    machine.inject({AnswerFault::Kind::exception, 60, {}, 11, Seconds(2)});
    try {
        (void)device.guarded_move(kFar, Pace::probe);
        FAIL() << "nothing was thrown";
    } catch (const DeviceRefused& refused) {
        EXPECT_EQ(refused.code(), 11);
    }
    EXPECT_FALSE(machine.is_moving());
    EXPECT_EQ(device.state(), State::idle);
    EXPECT_NEAR((machine.tool() - device.position()).norm(), 0, kRounding);
    expect_safe(machine);
}

TEST(ModbusTiming, AHaltThatIsNeverHeardIsToldSo) {
    Machine machine(Wire::tcp, test::machine_options(1.0));
    const auto device = machine.device();
    machine.inject({AnswerFault::Kind::exception, 60, {}, 11, kForEver});
    expect_says(message_of<DeviceError>([&] { (void)device->guarded_move(kFar, Pace::probe); }), "may still move");
    EXPECT_EQ(device->state(), State::fault);
}

TEST(ModbusTiming, ANetworkThatIsAwayForThreeSecondsIsWaitedFor) {
    Machine machine(Wire::tcp, test::machine_options(1.0));
    ModbusDevice device(default_options(machine), machine.clock());
    ASSERT_EQ(device.guarded_move(test::kStart + Point(0, 0, 1), Pace::probe).outcome, Outcome::reached);
    machine->unplug();
    const std::jthread helper([&] {
        sleep(Seconds(3));
        machine->replug();
    });
    EXPECT_EQ(device.guarded_move(test::kStart + Point(0, 0, 2), Pace::probe).outcome, Outcome::reached);
    expect_safe(machine);
}

// Packets that get lost: nobody hangs up.
TEST(ModbusTiming, SilenceOfThreeSecondsInMidMoveIsWaitedFor) {
    Machine machine(Wire::tcp, test::machine_options(1.0));
    ModbusDevice device(default_options(machine), machine.clock());
    machine.inject({AnswerFault::Kind::lost, 40, {}, 4, Seconds(3)});
    EXPECT_EQ(device.guarded_move(test::kStart + Point(0, 0, 6), Pace::probe).outcome, Outcome::reached);
    expect_safe(machine);
}

// Limits of 0 and 3 · 65.537 mm read the same with their words swapped; a position does not.
TEST(ModbusTiming, PositionsOutOfReachAreAProblemAndNothingMoves) {
    VirtualModbusOptions options = test::machine_options();
    options.tool.limits = {Point::Zero(), Point::Constant(196.611)};
    options.tool.start = Point(18.925, 1.2, 30);
    Machine machine(Wire::tcp, options);
    ModbusDeviceOptions driver = machine.options();
    driver.profile.word_order = ModbusWordOrder::low_first;
    ModbusDevice device(driver, machine.clock());
    EXPECT_EQ(device.state(), State::locked);
    EXPECT_EQ(device.report().position.x(), 1240268.8);
    expect_says(device.report().position_problem(), "word_order");
    expect_says(message_of<BadAnswer>([&] { device.recover(); }), "word_order");
    expect_says(message_of<BadAnswer>([&] { device.retreat(test::kStart); }), "word_order");
    expect_says(message_of<BadAnswer>([&] { (void)device.guarded_move({20, 5, 10}, Pace::travel); }), "word_order");
    EXPECT_EQ(machine.commands(), 0U);
    EXPECT_EQ(machine.audit().moves, 0U);
}

TEST(ModbusTiming, LimitsThatAreNoneNameTheWordOrder) {
    Machine machine(Wire::tcp);
    ModbusDeviceOptions driver = machine.options();
    driver.profile.word_order = ModbusWordOrder::low_first;
    expect_says(message_of<DeviceError>([&] { const ModbusDevice device(driver, machine.clock()); }), "word_order");
}

// A controller after CiA 402 starts at the rising edge of bit 4.
TEST(ModbusTiming, TheSetPointBitFallsBetweenCommands) {
    for (const bool read_write : {true, false}) {
        Machine machine(Wire::tcp, test::machine_options(8.0));
        ModbusDeviceOptions options = machine.options();
        options.profile.read_write = read_write;
        ModbusDevice device(options, machine.clock());
        for (int i = 0; i < 3; ++i) {
            ASSERT_EQ(device.guarded_move({0, 0, 0}, Pace::probe).outcome, Outcome::contact);
            ASSERT_EQ(device.guarded_move({10, 0, 0}, Pace::probe).outcome, Outcome::reached);
        }
        machine->with_controller([](const VirtualModbusController& c) {
            EXPECT_EQ(c.commands_without_edge(), 0U);
            EXPECT_EQ(c.set_points(), 12U);
        });
    }
}

}  // namespace
}  // namespace palpate::modbus_device_timing_test
