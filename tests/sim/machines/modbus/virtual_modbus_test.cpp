// The virtual controller by itself, and its server as any Modbus master sees it (devices/FACTS.md, "Modbus").
#include "sim/machines/modbus/virtual_modbus.h"

#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "devices/modbus/modbus_bits.h"
#include "sim/objects/hidden_object.h"

namespace palpate::virtual_modbus_test {
namespace {

using F = ModbusField;

const ModbusProfile kProfile = ModbusProfile::standard();
constexpr Seconds kTick{0.001};
const Box kLimits{Point::Constant(-30), Point::Constant(30)};

VirtualModbusOptions options_at(const Point& start) {
    VirtualModbusOptions options;
    options.tool.start = start;
    options.tool.limits = kLimits;
    return options;
}

// A controller with a sphere of 5 mm in it, and a host that sends what it is told to.
class VirtualController : public testing::Test {
protected:
    void write(F field, std::uint16_t word) {
        ASSERT_EQ(controller.refuses_to_write(kProfile[field].address, 1), std::nullopt);
        controller.write(kProfile[field].address, std::array{word});
    }
    void enable() {
        for (const std::uint16_t word : {cia402::kShutdown, cia402::kSwitchOn, cia402::kEnableOperation}) write(F::control_word, word);
    }
    static std::vector<std::uint16_t> command(const Point& target, std::uint16_t function, std::uint16_t stop_on_touch,
                                              std::uint16_t sequence) {
        const ModbusSpan span = span_of(kProfile, ModbusBlock::command);
        std::vector<std::uint16_t> words(static_cast<std::size_t>(span.registers), 0);
        const auto put = [&](F field, double value) { put_value(words, span.address, kProfile, field, value); };
        put(F::control_word, cia402::kEnableOperation | cia402::kNewSetPoint);
        for (int axis = 0; axis < 3; ++axis) put(axis_of(F::target_x, axis), target[axis]);
        put(F::velocity, 5.0);
        put(F::acceleration, 200.0);
        put(F::touch_probe_function, function);
        put(F::stop_on_touch, stop_on_touch);
        put(F::sequence, sequence);
        return words;
    }
    std::optional<int> send(const std::vector<std::uint16_t>& words) {
        const ModbusSpan span = span_of(kProfile, ModbusBlock::command);
        if (const auto refusal = controller.refuses_to_write(span.address, span.registers)) return refusal;
        controller.write(span.address, words);
        return std::nullopt;
    }
    std::uint16_t word(F field) { return get_word(controller.registers(), controller.first_address(), kProfile, field); }
    Point point(F x) {
        Point p;
        for (int axis = 0; axis < 3; ++axis) {
            p[axis] = get_value(controller.registers(), controller.first_address(), kProfile, axis_of(x, axis));
        }
        return p;
    }
    bool has(F field, std::uint16_t bits) { return (word(field) & bits) == bits; }
    // Time passes, with a heartbeat every 100 ms.
    void run(Seconds time) {
        for (Seconds at{0}; at < time; at += kTick) {
            if (std::fmod(at.count(), 0.1) < kTick.count()) write(F::heartbeat, ++beat_);
            controller.advance(kTick);
        }
    }
    void run_to_standstill() {
        for (int i = 0; i < 600 && !has(F::status_word, cia402::kStanding); ++i) run(Seconds(0.1));
        ASSERT_TRUE(has(F::status_word, cia402::kStanding));
    }

    static constexpr std::uint16_t kClosing = cia402::kProbeEnable | cia402::kProbePositiveEdge;
    static constexpr std::uint16_t kOpening = cia402::kProbeEnable | cia402::kProbeNegativeEdge;
    HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    VirtualModbusController controller{object, options_at({10, 0, 0})};

private:
    std::uint16_t beat_ = 0;
};

// "one FC16 frame carries profile and trigger together"
TEST_F(VirtualController, OneFrameCarriesTheMoveAndItsTrigger) {
    enable();
    EXPECT_EQ(send(command({10, 8, 0}, kClosing, 1, 1)), std::nullopt);
    EXPECT_EQ(word(F::sequence_echo), 1);
    EXPECT_FALSE(has(F::status_word, cia402::kStanding));
    run_to_standstill();
    EXPECT_EQ(point(F::actual_x), Point(10, 8, 0));
    EXPECT_EQ(word(F::edge_counter), 0);
    EXPECT_EQ(word(F::fault_code), 0);
}

TEST_F(VirtualController, TheSameNumberStartsNothing) {
    enable();
    (void)send(command({10, 1, 0}, kClosing, 1, 1));
    run_to_standstill();
    (void)send(command({10, 8, 0}, kClosing, 1, 1));
    EXPECT_TRUE(has(F::status_word, cia402::kStanding));
    EXPECT_EQ(controller.tool().audit().moves, 1U);
}

// "measuring does not change the axis state; re-triggering is rejected"
TEST_F(VirtualController, ReTriggeringIsRejectedAndTheMoveGoesOn) {
    enable();
    (void)send(command({10, 8, 0}, kClosing, 1, 1));
    run(Seconds(0.5));
    EXPECT_EQ(send(command({0, 0, 0}, kClosing, 1, 2)), 6);
    EXPECT_EQ(word(F::sequence_echo), 1);
    run_to_standstill();
    EXPECT_EQ(point(F::actual_x), Point(10, 8, 0));
}

TEST_F(VirtualController, ATouchIsLatchedAndCountedAndStopsTheAxes) {
    enable();
    (void)send(command({0, 0, 0}, kClosing, 1, 1));
    EXPECT_TRUE(has(F::touch_probe_status, cia402::kProbeEnabled));
    run_to_standstill();
    EXPECT_TRUE(has(F::touch_probe_status, cia402::kPositiveEdgeStored));
    EXPECT_TRUE(has(F::touch_probe_status, 1U << 7U)) << "the probe is pressed";
    EXPECT_EQ(word(F::edge_counter), 1);
    EXPECT_NEAR((point(F::latched_x) - Point(5, 0, 0)).norm(), 0, 0.0015);
    EXPECT_LT(point(F::actual_x).x(), 4.97) << "it runs on: v·latency + v²/2a is 0.07 mm";
    EXPECT_GT(point(F::actual_x).x(), 4.90);
    // Away until it opens.
    (void)send(command({8, 0, 0}, kOpening, 1, 2));
    EXPECT_FALSE(has(F::touch_probe_status, cia402::kPositiveEdgeStored)) << "each command arms afresh";
    run_to_standstill();
    EXPECT_TRUE(has(F::touch_probe_status, cia402::kNegativeEdgeStored));
    EXPECT_EQ(word(F::edge_counter), 1) << "positive edges only";
    EXPECT_NEAR((point(F::latched_x) - Point(5, 0, 0)).norm(), 0, 0.0015);
    EXPECT_LT(point(F::actual_x).x(), 5.2);
    EXPECT_EQ(controller.tool().audit().unsafe_moves, 0U);
}

// "A latch does not stop the axis by itself"
TEST_F(VirtualController, WithoutStopOnTouchTheAxesGoOn) {
    enable();
    (void)send(command({0, 0, 0}, kClosing, 0, 1));
    run_to_standstill();
    EXPECT_EQ(point(F::actual_x), Point(0, 0, 0));
    EXPECT_EQ(controller.tool().audit().unguarded_moves, 1U);
    EXPECT_EQ(controller.tool().audit().unsafe_moves, 1U);
}

// "the controller decelerates and stops when the host is silent for 250 ms"
TEST_F(VirtualController, SilenceSlowsTheAxesDownAndKeepsThePosition) {
    enable();
    (void)send(command({10, 20, 0}, kClosing, 1, 1));
    run(Seconds(1.0));
    write(F::heartbeat, 999);
    const double y = point(F::actual_x).y();
    for (int i = 0; i < 249; ++i) controller.advance(kTick);
    EXPECT_FALSE(has(F::status_word, cia402::kFault));
    EXPECT_NEAR(point(F::actual_x).y(), y + 5 * 0.249, 0.01);
    for (int i = 0; i < 200; ++i) controller.advance(kTick);
    EXPECT_TRUE(has(F::status_word, cia402::kFault | cia402::kStanding));
    EXPECT_EQ(word(F::fault_code), cia402::kHeartbeatFault);
    EXPECT_NEAR(point(F::actual_x).y(), y + 5 * 0.250 + 5 * 5 / (2 * 200.0), 0.01);
    EXPECT_TRUE(has(F::status_word, 1U << 14U)) << "still homed";
}

TEST_F(VirtualController, AHeartbeatThatDoesNotChangeIsSilence) {
    enable();
    (void)send(command({10, 20, 0}, kClosing, 1, 1));
    for (int i = 0; i < 300; ++i) {
        write(F::heartbeat, 5);
        controller.advance(kTick);
    }
    EXPECT_EQ(word(F::fault_code), cia402::kHeartbeatFault);
    EXPECT_EQ(controller.heartbeat_stops(), 1U);
}

TEST_F(VirtualController, AFaultIsResetByTheRisingEdgeOfItsBit) {
    enable();
    (void)send(command({100, 0, 0}, kClosing, 1, 1));
    EXPECT_EQ(word(F::fault_code), cia402::kLimitFault);
    EXPECT_TRUE(has(F::status_word, cia402::kFault | cia402::kInternalLimit));
    (void)send(command({12, 0, 0}, kClosing, 1, 2));
    EXPECT_EQ(word(F::sequence_echo), 1) << "in fault no command is taken";
    write(F::control_word, cia402::kFaultReset);
    EXPECT_EQ(word(F::fault_code), 0);
    EXPECT_FALSE(has(F::status_word, cia402::kFault));
    (void)send(command({100, 0, 0}, kClosing, 1, 3));
    EXPECT_EQ(word(F::sequence_echo), 1) << "after a reset the drives have to be enabled";
    EXPECT_EQ(controller.tool().audit().moves, 0U);
}

TEST_F(VirtualController, DrivesAreEnabledInTheOrderOfCia402) {
    write(F::control_word, cia402::kEnableOperation);
    EXPECT_FALSE(has(F::status_word, cia402::kOperationEnabled));
    write(F::control_word, cia402::kShutdown);
    EXPECT_TRUE(has(F::status_word, cia402::kReadyToSwitchOn));
    write(F::control_word, cia402::kSwitchOn);
    EXPECT_TRUE(has(F::status_word, cia402::kSwitchedOn));
    EXPECT_FALSE(has(F::status_word, cia402::kOperationEnabled));
    write(F::control_word, cia402::kEnableOperation);
    EXPECT_TRUE(has(F::status_word, cia402::kOperationEnabled));
}

TEST_F(VirtualController, HaltSlowsDownAndIsNoFault) {
    enable();
    (void)send(command({10, 20, 0}, kClosing, 1, 1));
    run(Seconds(1.0));
    write(F::control_word, cia402::kEnableOperation | cia402::kHalt);
    run_to_standstill();
    EXPECT_EQ(word(F::fault_code), 0);
    EXPECT_LT(point(F::actual_x).y(), 5.3);
    (void)send(command({10, 20, 0}, kClosing, 1, 2));
    run_to_standstill();
    EXPECT_EQ(point(F::actual_x), Point(10, 20, 0));
}

TEST_F(VirtualController, AMoveThatMustNotBeIsAFault) {
    enable();
    controller.tool().place({4.9, 0, 0});
    (void)send(command({4, 0, 0}, kClosing, 1, 1));
    EXPECT_EQ(word(F::fault_code), cia402::kProbeClosedFault);
    controller.reset();
    enable();
    (void)send(command({9, 0, 0}, kClosing, 1, 1));
    EXPECT_EQ(word(F::fault_code), cia402::kNotHomedFault);
    EXPECT_EQ(controller.tool().audit().moves, 0U);
}

// What any client may write: a number alone, over registers that are 0; and a command without a velocity.
TEST_F(VirtualController, AMoveWithoutAVelocityOrAnAccelerationIsAFault) {
    enable();
    write(F::sequence, 1);
    EXPECT_EQ(word(F::fault_code), cia402::kParameterFault);
    EXPECT_EQ(word(F::sequence_echo), 1);
    EXPECT_TRUE(has(F::status_word, cia402::kFault | cia402::kStanding));
    std::uint16_t sequence = 1;
    for (const F rate : {F::velocity, F::acceleration}) {
        write(F::control_word, 0);
        write(F::control_word, cia402::kFaultReset);
        enable();
        std::vector<std::uint16_t> words = command({9, 0, 0}, kClosing, 1, ++sequence);
        put_value(words, span_of(kProfile, ModbusBlock::command).address, kProfile, rate, 0.0);
        EXPECT_EQ(send(words), std::nullopt);
        EXPECT_EQ(word(F::fault_code), cia402::kParameterFault);
    }
    EXPECT_EQ(controller.tool().audit().moves, 0U);
}

// A machine that is told in micrometres of 32 bits ends at 2147 m.
TEST(VirtualControllerSetup, LimitsAndAStartThatNoRegisterHoldsAreRefused) {
    const HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    VirtualModbusOptions options = options_at({10, 0, 0});
    options.tool.limits.max.z() = 3e6;
    EXPECT_THROW(VirtualModbusController(object, options), std::invalid_argument);
    options.tool.limits = kLimits;
    options.tool.start.x() = -3e6;
    EXPECT_THROW(VirtualModbusController(object, options), std::invalid_argument);
    options.tool.start.x() = 10;
    EXPECT_NO_THROW(VirtualModbusController(object, options));
}

TEST_F(VirtualController, AMissedTriggerGoesThroughAndTheAuditSeesIt) {
    enable();
    controller.inject(MachineFault::missed_trigger);
    (void)send(command({0, 0, 0}, kClosing, 1, 1));
    run_to_standstill();
    EXPECT_EQ(word(F::edge_counter), 0);
    EXPECT_EQ(controller.tool().audit().unsafe_moves, 1U);
}

TEST_F(VirtualController, AFrozenProgramEchoesNothing) {
    write(F::heartbeat, 7);
    EXPECT_EQ(word(F::heartbeat_echo), 7);
    controller.freeze();
    write(F::heartbeat, 8);
    EXPECT_EQ(word(F::heartbeat_echo), 7);
}

TEST_F(VirtualController, TellsItsLimitsAndItsName) {
    EXPECT_EQ(point(F::min_x), kLimits.min);
    EXPECT_EQ(point(F::max_x), kLimits.max);
    const auto identity =
        controller.registers().subspan(static_cast<std::size_t>(kProfile.identity.address - controller.first_address()), 16);
    EXPECT_EQ(text_of_registers(identity), "palpate virtual probe 1");
}

TEST_F(VirtualController, AnAddressThatIsNoRegisterIsRefused) {
    EXPECT_EQ(controller.refuses_to_read(512, 18), std::nullopt);
    EXPECT_EQ(controller.refuses_to_read(512, 19), 2);
    EXPECT_EQ(controller.refuses_to_read(0, 1), 2);
    EXPECT_EQ(controller.refuses_to_read(65535, 1), 2);
    EXPECT_EQ(controller.refuses_to_write(512, 1), 2) << "the status is not the host's";
    EXPECT_EQ(controller.refuses_to_write(257, 1), 2) << "half of a value";
}

// A Modbus master without any hygiene.
class RawMaster {
public:
    explicit RawMaster(const ModbusLinkOptions& link)
        : context_(std::holds_alternative<ModbusTcp>(link.where)
                       ? modbus_new_tcp("127.0.0.1", std::get<ModbusTcp>(link.where).port)
                       : modbus_new_rtu(std::get<ModbusRtu>(link.where).path.c_str(), 19200, 'N', 8, 1)) {
        modbus_set_slave(context_, link.unit);
        modbus_set_response_timeout(context_, 0, 50000);
        EXPECT_EQ(modbus_connect(context_), 0);
    }
    ~RawMaster() {
        modbus_close(context_);
        modbus_free(context_);
    }
    RawMaster(const RawMaster&) = delete;
    RawMaster& operator=(const RawMaster&) = delete;
    RawMaster(RawMaster&&) = delete;
    RawMaster& operator=(RawMaster&&) = delete;

    // The value, or nothing and errno.
    std::optional<std::uint16_t> read(int address) {
        std::uint16_t value = 0;
        return modbus_read_registers(context_, address, 1, &value) == 1 ? std::optional(value) : std::nullopt;
    }

    // Any frame: unit, function, data. The number of the exception that answers it, or 0.
    int raw(const std::vector<std::uint8_t>& frame) {
        std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> answer{};
        EXPECT_GT(modbus_send_raw_request(context_, frame.data(), static_cast<int>(frame.size())), 0);
        errno = 0;
        return modbus_receive_confirmation(context_, answer.data()) < 0 ? -1 : exception_in(answer);
    }

private:
    [[nodiscard]] int exception_in(const std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH>& answer) const {
        const auto at = static_cast<std::size_t>(modbus_get_header_length(context_));
        return (answer[at] & 0x80U) != 0 ? answer[at + 1] : 0;
    }

    modbus_t* context_;
};

// "After a late answer, error recovery NONE on RTU returns the previous request's value with rc = 1 for every later read"
TEST(VirtualModbus, ALateAnswerOnRtuShiftsEveryValueOfACarelessMaster) {
    const HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    VirtualModbus machine(object, options_at({10, 0, 0}), VirtualModbusSerial{});
    RawMaster master(machine.link());
    const auto first = master.read(768);
    const auto second = master.read(769);
    ASSERT_NE(first, second);
    machine.inject({AnswerFault::Kind::late, 1, Seconds(0.08)});
    EXPECT_EQ(master.read(768), std::nullopt);
    EXPECT_EQ(master.read(769), first);
    EXPECT_EQ(master.read(768), second);
    EXPECT_EQ(master.read(769), first);
}

// "An unknown unit id may be answered by silence, an illegal address by an exception"
TEST(VirtualModbus, AnotherUnitIsAnsweredByNobodyAndAnIllegalAddressByAnException) {
    const HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    for (const bool serial : {false, true}) {
        std::variant<VirtualModbusTcp, VirtualModbusSerial> where = VirtualModbusTcp{};
        if (serial) where = VirtualModbusSerial{};
        VirtualModbus machine(object, options_at({10, 0, 0}), where, 3);
        RawMaster master(machine.link());
        EXPECT_NE(master.read(768), std::nullopt);
        EXPECT_EQ(master.read(100), std::nullopt);
        EXPECT_EQ(errno, EMBXILADD);
        ModbusLinkOptions other = machine.link();
        other.unit = 4;
        RawMaster stranger(other);
        EXPECT_EQ(stranger.read(768), std::nullopt);
        EXPECT_EQ(errno, ETIMEDOUT);
    }
}

TEST(VirtualModbus, FramesThatItDoesNotKnowAreAnsweredByExceptions) {
    const HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    for (const bool serial : {false, true}) {
        std::variant<VirtualModbusTcp, VirtualModbusSerial> where = VirtualModbusTcp{};
        if (serial) where = VirtualModbusSerial{};
        VirtualModbus machine(object, options_at({10, 0, 0}), where);
        RawMaster master(machine.link());
        EXPECT_EQ(master.raw({1, 0x07}), 1) << "no data";
        EXPECT_EQ(master.raw({1, 0x11}), 1) << "no data";
        EXPECT_EQ(master.raw({1, 0x10, 0x01, 0x20, 0x00, 0x02, 0x02, 0x00, 0x05}), 3) << "two registers announced, one sent";
        EXPECT_EQ(master.raw({1, 0x10, 0x01, 0x20, 0x00, 0x00, 0x00}), 3) << "none";
        EXPECT_EQ(master.raw({1, 0x03, 0x02, 0x00, 0x00, 0x00}), 3) << "none";
        EXPECT_EQ(master.raw({1, 0x03, 0x02, 0x00, 0x00, 0x7E}), 3) << "more than a frame carries";
        EXPECT_EQ(master.raw({1, 0x10, 0x01, 0x20, 0x00, 0x01, 0x02, 0x00, 0x05}), 0);
        EXPECT_EQ(master.read(529), 5) << "the heartbeat's echo";
    }
}

TEST(VirtualModbus, ThePseudoTerminalHasALinkThatGoesWithIt) {
    const HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    const std::filesystem::path link = std::filesystem::temp_directory_path() / ("palpate-modbus-link-" + std::to_string(::getpid()));
    {
        VirtualModbus machine(object, options_at({10, 0, 0}), VirtualModbusSerial{link});
        EXPECT_EQ(std::get<ModbusRtu>(machine.link().where).path, link.string());
        EXPECT_NE(RawMaster(machine.link()).read(768), std::nullopt);
        machine.unplug();
        EXPECT_FALSE(std::filesystem::exists(link));
        machine.replug();
        EXPECT_NE(RawMaster(machine.link()).read(768), std::nullopt);
    }
    EXPECT_FALSE(std::filesystem::is_symlink(link));
}

TEST(VirtualModbus, SeveralMastersOnTcpAreServed) {
    const HiddenObject object{ShapeSpec{SphereSpec{5.0}}};
    VirtualModbus machine(object, options_at({10, 0, 0}), VirtualModbusTcp{});
    RawMaster one(machine.link());
    RawMaster two(machine.link());
    EXPECT_EQ(one.read(768), two.read(768));
    machine.inject({AnswerFault::Kind::hang_up, 1});
    EXPECT_EQ(one.read(768), std::nullopt);
    EXPECT_NE(two.read(768), std::nullopt);
}

}  // namespace
}  // namespace palpate::virtual_modbus_test
