// Firmware as it is met: builds and settings that leave things out, other dialects, and what is no GRBL at all.
#include "devices/grbl/grbl_report.h"
#include "tests/devices/grbl/grbl_support.h"

namespace palpate::grbl_device_firmware_test {
namespace {

using testing::HasSubstr;
using testing::Not;
using Outcome = MoveResult::Outcome;

class GrblFirmware : public GrblDeviceTest {
protected:
    inline static const Point kTouch{kRadius, 0, 0};

    template <class Fault = DeviceError>
    std::string refusal() {
        power_on();
        return message_of<Fault>([&] { ready(); });
    }
};

INSTANTIATE_TEST_SUITE_P(Dialects, GrblFirmware, testing::Values(GrblDialect::grbl, GrblDialect::grblhal, GrblDialect::fluidnc),
                         dialect_name);

TEST_P(GrblFirmware, IsNamed) {
    ready();
    const std::string identity = report_on(*device).identity;
    EXPECT_THAT(identity, HasSubstr(options.dialect == GrblDialect::fluidnc   ? "Grbl 3.9 (3.9 FluidNC v3.9.1:)"
                                    : options.dialect == GrblDialect::grblhal ? "GrblHAL 1.1f (1.1f.20230917:)"
                                                                              : "Grbl 1.1h (1.1h.20190830:)"));
    expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), kTouch);
}

TEST_P(GrblFirmware, ReportsThatNeverTellTheWorkOffsetAreRefusedByName) {
    options.reports_offset = false;
    const std::string message = refusal();
    if (options.dialect == GrblDialect::grblhal) {
        EXPECT_THAT(message, HasSubstr("leave out the work offset, bit 5: nothing has moved; say $10=511 to it"));
    } else {
        EXPECT_THAT(message, HasSubstr("reports its status, but never the work offset (WCO)"));
    }
    EXPECT_EQ(tool->audit().moves, 0U);
}

TEST_P(GrblFirmware, ReportsThatLeaveOutTheProbeAreRefusedByName) {
    if (options.dialect != GrblDialect::grblhal)
        GTEST_SKIP() << "a build of Grbl without them does not say so; the probe is pressed by hand";
    options.reports_pins = false;
    options.reports_probes = false;
    const std::string message = refusal<DeviceRefused>();
    EXPECT_THAT(message, HasSubstr("the probe's state (pin state), bit 4"));
    EXPECT_THAT(message, HasSubstr("where a probe touched (probe coordinates), bit 7"));
    EXPECT_THAT(message, HasSubstr("say $10=511 to it"));
    EXPECT_EQ(tool->audit().moves, 0U);
}

TEST_P(GrblFirmware, ATouchThatIsNeverToldIsAskedFor) {
    if (options.dialect == GrblDialect::grblhal) GTEST_SKIP() << "refused";
    options.reports_probes = false;
    ready();
    expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), kTouch);
    EXPECT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached);
    EXPECT_EQ(grbl->counts().probes, 4U) << "a touch, off the surface, a retract, and back; none twice";
}

// "the host learns of it from $# alone": before its first probe FluidNC says nothing there.
TEST_P(GrblFirmware, AMachineThatHasNeverProbedMaySaySo) {
    ready();
    EXPECT_EQ(device->controller().last_probe().contact, false);
    expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), kTouch);
    EXPECT_EQ(device->controller().last_probe().contact, false) << "that of the way off the surface, until the probe opened or the end";
}

TEST_P(GrblFirmware, ABoardThatStartsSlowlyIsWaitedFor) {
    device_options.homing = Homing::skip;  // it locks when it starts
    for (const double boot : {2.0, 7.0, 25.0}) {
        SCOPED_TRACE(boot);
        power_on();
        // Deaf and mute; its boot loader's last second is the virtual machine's own.
        constexpr std::size_t kAll = 1'000'000'000;
        stream->to_host.lose(0, kAll);
        stream->to_machine.lose(0, kAll);
        stream->before_read = [&, boot] {
            if (seconds() < boot - 1) return;
            stream->to_host.lose(0, 0);
            stream->to_machine.lose(0, 0);
            grbl->press_reset();
            stream->before_read = nullptr;
        };
        device_options.boot_time = Seconds(8);
        if (boot > 8) {
            EXPECT_THAT(message_of<DeviceTimeout>([&] { connect(); }), HasSubstr("nothing answers on virtual GRBL within 8 s"));
            device_options.boot_time = Seconds(40);
        }
        connect().make_ready();
        EXPECT_EQ(device->controller().state(), grbl::State::idle);
    }
}

// What another program wrote before the session waits in the controller's buffer.
TEST_P(GrblFirmware, WhatAModemManagerLeftBehindIsNoErrorOfOurs) {
    power_on();
    grbl->receive("ATE1 E0\rAT");
    connect().make_ready();
    expect_touch(device->guarded_move({0, 0, 0}, Pace::probe), kTouch);
}

TEST(GrblErrors, OfDamagedLinesNameAlsoThePortsOtherUsers) {
    for (const int code : {1, 2}) EXPECT_THAT(grbl::explain_error(code), HasSubstr("ModemManager"));
}

// --- what is no GRBL that is known here ------------------------------------------------------------------------------

// Answers every byte of ours that is in `to` by `text`, in virtual time.
class Talker final : public ByteStream, public Clock {
public:
    Talker(std::string to, std::string text) : to_(std::move(to)), text_(std::move(text)) {}

    [[nodiscard]] std::string read(std::chrono::milliseconds timeout) override {
        if (said_.empty()) now_ += timeout;
        return std::exchange(said_, {});
    }
    void write(std::string_view bytes) override {
        for (const char c : bytes) {
            if (to_.find(c) != std::string::npos) said_ += text_;
        }
    }
    [[nodiscard]] std::string name() const override { return "port"; }
    [[nodiscard]] std::chrono::nanoseconds now() const override { return now_; }
    void sleep(std::chrono::nanoseconds duration) override { now_ += duration; }

private:
    std::string to_;
    std::string text_;
    std::string said_;
    std::chrono::nanoseconds now_{0};
};

std::string refusal_of(Talker talker) {
    return message_of<DeviceTimeout>([&] { GrblDevice device(talker, talker, {}); });
}

TEST(OtherFirmware, IsToldFromSilence) {
    const std::string old = refusal_of({"?", "Grbl 0.9j ['$' for help]\r\n<Idle,MPos:0.000,0.000,0.000,WPos:0.000,0.000,0.000>\r\n"});
    EXPECT_THAT(old, HasSubstr("what answers on port is Grbl 0.9j, which is older than Grbl 1.1: update"));
    const std::string older = refusal_of({"?", "<Idle,MPos:0.000,0.000,0.000,WPos:0.000,0.000,0.000>\r\n"});
    EXPECT_THAT(older, HasSubstr("which is older than Grbl 1.1"));
    const std::string marlin = refusal_of({"?", "echo:Unknown command: \"?\"\nok\n"});
    EXPECT_THAT(marlin, HasSubstr("something answers on port, but not as GRBL does: it says \"echo:Unknown command: \"?\"\""));
    EXPECT_THAT(marlin, HasSubstr("Grbl 1.1, grblHAL and FluidNC are supported"));
    const std::string silent = refusal_of({"", ""});
    EXPECT_THAT(silent, HasSubstr("nothing answers on port within 8 s"));
    EXPECT_THAT(silent, Not(HasSubstr("supported")));
}

TEST(OtherFirmware, CriticalIsSaidInWords) {
    Talker talker("?", "<Critical|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
    EXPECT_THAT(message_of<DeviceAlarm>([&] { GrblDevice device(talker, talker, {}); }), HasSubstr("says Critical"));
}

TEST(GrblLines, OfBridgesAreUnderstood) {
    EXPECT_TRUE(std::holds_alternative<grbl::Ok>(grbl::parse("OK")));
    EXPECT_TRUE(std::holds_alternative<grbl::Ok>(grbl::parse("ok \t")));
    EXPECT_TRUE(std::holds_alternative<grbl::ProbeReport>(grbl::parse("[PRB:1.000,2.000,3.000:1]  ")));
    EXPECT_TRUE(std::holds_alternative<grbl::Status>(grbl::parse("<Idle|MPos:1.000,2.000,3.000|FS:0,0> ")));
    EXPECT_TRUE(std::holds_alternative<grbl::Unknown>(grbl::parse("oK"))) << "a damaged line";
}

}  // namespace
}  // namespace palpate::grbl_device_firmware_test
