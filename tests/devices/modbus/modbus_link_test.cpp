// The transport against libmodbus' own server, over loopback sockets and pseudo-terminals (devices/FACTS.md, "Modbus").
#include "devices/modbus/modbus_link.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <functional>
#include <vector>

#include "devices/errors.h"
#include "tests/devices/message_of.h"
#include "tests/devices/modbus/modbus_support.h"
#include "tests/random.h"

namespace palpate::modbus_link_test {
namespace {

using test::Machine;
using test::Wire;

constexpr int kLimits = 768;  // the first of twelve registers that never change

class ModbusLinkOn : public testing::TestWithParam<Wire> {
protected:
    Machine machine{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Wires, ModbusLinkOn, testing::Values(Wire::tcp, Wire::rtu),
                         [](const auto& wire) { return test::name_of(wire.param); });

TEST_P(ModbusLinkOn, ReadsAndWritesRegisters) {
    ModbusLink link(machine.link(), machine.clock());
    const std::array<std::uint16_t, 1> beat{77};
    link.write(288, beat);
    EXPECT_EQ(link.read(529, 1), std::vector<std::uint16_t>{77});
    EXPECT_EQ(link.read(kLimits, 2), (std::vector<std::uint16_t>{0xFFFF, 0x63C0}));  // -40000 µm
    expect_says(link.last_exchange(), "FC03");
    expect_says(link.last_exchange(), "FFFF 63C0");
}

// "After a late answer, error recovery NONE on RTU returns the previous request's value with rc = 1 for every later read."
TEST_P(ModbusLinkOn, LateAnswersNeverShiftAValueByOneRequest) {
    constexpr std::uint64_t kSeed = 5;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    ModbusLink link(machine.link(), machine.clock());
    const std::vector<std::uint16_t> truth = link.read(kLimits, 12);
    int late = 0;
    for (int i = 0; i < 60; ++i) {
        if (random.chance(0.4)) {
            // The server answers one request after the other: together they may take no longer than the slowest answer.
            machine.inject({AnswerFault::Kind::late, 1, Seconds(random.uniform(0.0, 0.95 * test::kSlowestAnswer.count()))});
        }
        const auto at = random.below(12);
        try {
            EXPECT_EQ(link.read(kLimits + static_cast<int>(at), 1).front(), truth[at]) << "request " << i;
        } catch (const DeviceTimeout&) {
            ++late;
        }
    }
    EXPECT_GT(late, 3);
}

// "A stale frame can sit in a pseudo-terminal from an earlier run."
TEST(ModbusLink, AStaleFrameInAPseudoTerminalIsDropped) {
    Machine machine(Wire::rtu);
    // Unit 1 answers FC03 with one register: DEAD. The checksum is right.
    const std::array<std::uint8_t, 7> stale{0x01, 0x03, 0x02, 0xDE, 0xAD, 0x20, 0x59};
    machine->send_stale(stale);
    ModbusLink link(machine.link(), machine.clock());
    EXPECT_EQ(link.read(kLimits, 1).front(), 0xFFFF);
}

// "An unknown unit id may be answered by silence, an illegal address by an exception: tell them apart."
TEST_P(ModbusLinkOn, AnUnknownUnitIsSilentAndAnIllegalAddressIsAnException) {
    {
        ModbusLinkOptions options = machine.link();
        options.unit = 9;
        ModbusLink link(options, machine.clock());
        EXPECT_THROW((void)link.read(kLimits, 1), DeviceTimeout);
        const std::string message = message_of<DeviceError>([&] { (void)link.read(kLimits, 1); });
        expect_says(message, "unit 9");
        expect_says(message, "does it have this unit number");
        expect_says(message, "last request: read (FC03) of registers 768 to 768");
    }
    ModbusLink link(machine.link(), machine.clock());
    try {
        (void)link.read(5000, 2);
        FAIL() << "nothing was thrown";
    } catch (const DeviceRefused& refused) {
        EXPECT_EQ(refused.code(), 2);
        expect_says(refused.what(), "registers 5000 to 5001");
        expect_says(refused.what(), "does the profile fit");
    }
    EXPECT_EQ(link.read(kLimits, 1).front(), 0xFFFF);
}

// "Debian's build loops on EPIPE if the peer is gone and the error is ignored: reconnect."
TEST_P(ModbusLinkOn, APeerThatIsGoneIsSaidOnceAndReconnected) {
    ModbusLink link(machine.link(), machine.clock());
    (void)link.read(kLimits, 1);
    machine->unplug();
    EXPECT_THROW((void)link.read(kLimits, 1), ConnectionLost);
    EXPECT_FALSE(link.is_connected());
    EXPECT_THROW((void)link.read(kLimits, 1), ConnectionLost);
    expect_says(message_of<DeviceError>([&] { link.reconnect(); }), "given up after ");
    machine->replug();
    link.reconnect();
    EXPECT_EQ(link.read(kLimits, 1).front(), 0xFFFF);
}

TEST_P(ModbusLinkOn, ALostAnswerIsATimeoutAndTheNextIsRight) {
    ModbusLink link(machine.link(), machine.clock());
    machine.inject({AnswerFault::Kind::lost, 1});
    EXPECT_THROW((void)link.read(kLimits, 1), DeviceTimeout);
    EXPECT_EQ(link.read(kLimits + 1, 1).front(), 0x63C0);
}

TEST(ModbusLink, AnotherUnitsAnswerIsNotTaken) {
    Machine machine(Wire::rtu);
    ModbusLink link(machine.link(), machine.clock());
    machine.inject({AnswerFault::Kind::other_unit, 1});
    expect_says(message_of<DeviceError>([&] { (void)link.read(kLimits, 1); }), "another unit answered");
    EXPECT_EQ(link.read(kLimits + 1, 1).front(), 0x63C0);
}

TEST_P(ModbusLinkOn, AnExceptionHasItsNumber) {
    ModbusLink link(machine.link(), machine.clock());
    machine.inject({AnswerFault::Kind::exception, 2, {}, 4});
    (void)link.read(kLimits, 1);
    try {
        (void)link.read(kLimits, 1);
        FAIL() << "nothing was thrown";
    } catch (const DeviceRefused& refused) {
        EXPECT_EQ(refused.code(), 4);
    }
}

TEST_P(ModbusLinkOn, ASecondDriverIsRefusedUntilTheFirstIsGone) {
    {
        const ModbusLink first(machine.link(), machine.clock());
        expect_says(message_of<DeviceError>([&] { const ModbusLink second(machine.link(), machine.clock()); }),
                    "another process drives the machine");
    }
    EXPECT_NO_THROW(ModbusLink(machine.link(), machine.clock()));
}

TEST_P(ModbusLinkOn, TheLockDiesWithItsHolder) {
    // Asked for here: in the child nobody would unlock a mutex that the machine's thread held when we forked.
    const ModbusLinkOptions options = machine.link();
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        ::close(pipe[0]);
        try {
            SteadyClock clock;
            const ModbusLink link(options, clock);
            (void)!::write(pipe[1], "x", 1);
            ::pause();
        } catch (const DeviceError& error) {
            (void)!::write(STDERR_FILENO, error.what(), std::strlen(error.what()));
        }
        ::_exit(1);
    }
    ::close(pipe[1]);
    char ready = 0;
    EXPECT_EQ(::read(pipe[0], &ready, 1), 1) << "the child could not connect";
    EXPECT_THROW(ModbusLink(options, machine.clock()), DeviceError);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_NO_THROW(ModbusLink(options, machine.clock()));
    ::close(pipe[0]);
}

TEST(ModbusLink, WhatCannotBeReachedIsNamed) {
    SteadyClock clock;
    ModbusLinkOptions options;
    options.where = ModbusTcp{"127.0.0.1", 1};
    expect_says(message_of<DeviceError>([&] { const ModbusLink link(options, clock); }), "unit 1 at 127.0.0.1:1");
    options.where = ModbusRtu{"/dev/nonexistent"};
    expect_says(message_of<DeviceError>([&] { const ModbusLink link(options, clock); }), "/dev/nonexistent");
    options.where = ModbusTcp{"no such host", 502};
    expect_says(message_of<DeviceError>([&] { const ModbusLink link(options, clock); }), "no such host");
}

TEST(ModbusLink, OptionsOutOfRangeAreRefused) {
    SteadyClock clock;
    const auto refused = [&](const std::function<void(ModbusLinkOptions&)>& change, const std::string& what) {
        ModbusLinkOptions options;
        options.where = ModbusRtu{"/dev/nonexistent"};
        change(options);
        expect_says(message_of<DeviceError>([&] { const ModbusLink link(options, clock); }), what);
    };
    refused([](ModbusLinkOptions& o) { o.unit = 248; }, "unit 248");
    refused([](ModbusLinkOptions& o) { o.unit = 255; }, "unit 255");
    refused([](ModbusLinkOptions& o) { o.where = ModbusRtu{"x", 0}; }, "baud");
    refused([](ModbusLinkOptions& o) { o.where = ModbusRtu{"x", 250000}; }, "baud 250000");
    refused([](ModbusLinkOptions& o) { o.where = ModbusRtu{"x", 9600, 'X'}; }, "parity");
    refused([](ModbusLinkOptions& o) { o.where = ModbusRtu{"x", 9600, 'N', 3}; }, "stop bits");
    refused([](ModbusLinkOptions& o) { o.where = ModbusTcp{"x", 65536}; }, "port");
    refused([](ModbusLinkOptions& o) { o.slowest_answer = Seconds(0.1); }, "slowest answer");
}

}  // namespace
}  // namespace palpate::modbus_link_test
