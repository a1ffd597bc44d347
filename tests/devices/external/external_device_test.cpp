// The driver on programs that do right, and on programs that do not. What must never happen is counted by the machine itself.
#include "devices/external/external_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "devices/errors.h"
#include "devices/external/external_machine.h"
#include "devices/posix/child_stream.h"
#include "devices/posix/tcp_stream.h"
#include "sim/machines/external/virtual_program.h"
#include "sim/objects/hidden_object.h"
#include "tests/devices/message_of.h"
#include "tests/random.h"

namespace palpate::external_device_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Kind = ProgramFault::Kind;
using Outcome = MoveResult::Outcome;

constexpr double kRadius = 10.0;
const Point kOrigin(1, -2, 3);
const Point kStart(20, 0, 0);

class ExternalDeviceTest : public ::testing::Test {
protected:
    ExternalDeviceTest() {
        axes.origin = kOrigin;
        axes.start = kStart + kOrigin;
        options.origin = kOrigin;
    }
    // What must never happen, whatever the test does.
    void TearDown() override {
        device.reset();
        if (!program) return;
        const VirtualToolAudit audit = this->audit();
        EXPECT_EQ(audit.unguarded_moves, 0U);
        EXPECT_EQ(audit.unsafe_moves, 0U);
        EXPECT_EQ(audit.outside_limits, 0U);
    }
    void start(const VirtualProgramOptions& wanted = {}) {
        device.reset();
        stream.reset();
        program.reset();
        tool = std::make_unique<VirtualTool>(ball, axes);
        program = std::make_unique<VirtualProgram>(*tool, wanted);
    }
    ExternalDevice& connect() {
        if (!program) start();
        device.reset();
        stream.reset();
        const auto until = std::chrono::steady_clock::now() + 10s;
        while (!stream) {
            // The program sees the end of an earlier connection a moment later.
            try {
                stream = std::make_unique<TcpStream>(*parse_host_port(program->address()));
            } catch (const DeviceError&) {
                if (std::chrono::steady_clock::now() > until) throw;
            }
        }
        device = std::make_unique<ExternalDevice>(*stream, clock, options, stop.token());
        return *device;
    }
    ExternalDevice& ready() {
        connect().make_ready();
        return *device;
    }
    void suffer(Kind kind, std::uint64_t at = 1) {
        VirtualProgramOptions wanted;
        wanted.faults = {{kind, at}};
        start(wanted);
    }
    [[nodiscard]] VirtualToolAudit audit() const {
        VirtualToolAudit audit;
        program->with([&](VirtualTool& t) { audit = t.audit(); });
        return audit;
    }
    [[nodiscard]] Point tool_at() const {
        Point at;
        program->with([&](VirtualTool& t) { at = t.true_position() - kOrigin; });
        return at;
    }
    MoveResult probe() { return device->guarded_move({0, 0, 0}, Pace::probe); }
    void expect_touch(const MoveResult& result, const Point& at) const {
        EXPECT_EQ(result.outcome, Outcome::contact);
        EXPECT_NEAR((result.position - at).norm(), 0, 0.003);
    }

    HiddenObject ball{ShapeSpec{SphereSpec{kRadius}}};
    VirtualToolOptions axes;
    ExternalOptions options;
    StopSource stop;
    SteadyClock clock;
    std::unique_ptr<VirtualTool> tool;
    std::unique_ptr<VirtualProgram> program;
    std::unique_ptr<TcpStream> stream;
    std::unique_ptr<ExternalDevice> device;
};

TEST_F(ExternalDeviceTest, TouchesWhereThePartIsAndDrawsBack) {
    ready();
    EXPECT_EQ(device->position(), kStart);
    expect_touch(probe(), {kRadius, 0, 0});
    EXPECT_NEAR((device->position() - Point(kRadius + 0.5, 0, 0)).norm(), 0, 0.003) << "the retract, from where the probe opened";
    EXPECT_NEAR((tool_at() - device->position()).norm(), 0, 0.003);
    EXPECT_EQ(device->guarded_move({20, 20, 0}, Pace::travel).outcome, Outcome::reached);
    EXPECT_EQ(device->guarded_move({0, 20, 0}, Pace::travel).outcome, Outcome::reached);
    expect_touch(probe(), {0, kRadius, 0});
    EXPECT_FALSE(device->state().is_probe_closed);
}

TEST_F(ExternalDeviceTest, RandomMovesAreAnsweredByTheTruth) {
    ready();
    Random random(3);
    int touches = 0;
    for (int k = 0; k < 200; ++k) {
        const Point from = device->position();
        const Point to = random.uniform(5, 30) * random.direction();
        const Vector d = to - from;
        // Where the straight way first meets the ball.
        const double b = from.dot(d) / d.squaredNorm();
        const double c = (from.squaredNorm() - kRadius * kRadius) / d.squaredNorm();
        const double root = b * b - c;
        const double at = root > 0 ? -b - std::sqrt(root) : 2;
        const MoveResult result = device->guarded_move(to, Pace::probe);
        const bool is_clear = at > 0 && at < 0.99;
        const bool is_graze = std::abs(root) * d.squaredNorm() < 0.01 || std::abs(at - 1) < 0.01 || std::abs(at) < 0.01;
        if (is_graze) continue;
        ASSERT_EQ(result.outcome == Outcome::contact, is_clear) << k;
        if (is_clear) {
            EXPECT_NEAR((result.position - (from + at * d)).norm(), 0, 0.01 / std::sqrt(std::max(root, 1e-3))) << k;
        }
        touches += is_clear ? 1 : 0;
    }
    EXPECT_GT(touches, 50);
}

// --- what a program cannot do ----------------------------------------------------------------------------------------

TEST_F(ExternalDeviceTest, AProgramThatCannotStopOrLatchByItselfIsRefused) {
    for (const bool stops : {true, false}) {
        VirtualProgramOptions wanted;
        wanted.stops_at_touch = stops;
        wanted.latches = false;
        start(wanted);
        EXPECT_THAT(message_of<DeviceError>([&] { connect(); }),
                    HasSubstr(stops ? "does not know where it touched" : "does not stop by itself"));
        EXPECT_EQ(program->moves(), 0U);
    }
}

TEST_F(ExternalDeviceTest, NothingMovesUnlessItIsReady) {
    VirtualProgramOptions wanted;
    wanted.homed = false;
    start(wanted);
    EXPECT_THAT(message_of<DeviceAlarm>([&] { ready(); }), HasSubstr("is not homed"));
    wanted = {};
    wanted.fault = "joint 3 is too hot";
    start(wanted);
    EXPECT_THAT(message_of<DeviceAlarm>([&] { ready(); }), HasSubstr("joint 3 is too hot"));
    start();
    program->with([](VirtualTool& t) { t.press(true); });
    EXPECT_THAT(message_of<ProbeClosed>([&] { ready(); }), HasSubstr("is closed before anything moves"));
    start();
    options.motion.acceleration_mm_per_s2 = 2 * axes.motion.acceleration_mm_per_s2;
    EXPECT_THAT(message_of<DeviceError>([&] { ready(); }), HasSubstr("lower machine.acceleration"));
    options.motion.acceleration_mm_per_s2 = axes.motion.acceleration_mm_per_s2;
    axes.limits = Box{kOrigin - Vector::Constant(25), kOrigin + Vector::Constant(25)};
    start();
    ready();
    EXPECT_THROW((void)device->guarded_move({26, 0, 0}, Pace::travel), OutOfLimits);
    EXPECT_EQ(program->moves(), 0U);
}

TEST_F(ExternalDeviceTest, HomesWhereItIsToldToAndTheProgramCan) {
    VirtualProgramOptions wanted;
    wanted.homed = false;
    options.homing = Homing::run;
    start(wanted);
    EXPECT_THAT(message_of<DeviceAlarm>([&] { ready(); }), HasSubstr("home it by its own means"));
    wanted.homes = true;
    start(wanted);
    options.homing = Homing::require;
    EXPECT_THAT(message_of<DeviceAlarm>([&] { ready(); }), HasSubstr("or let Palpate do so (machine.homing: run)"));
    options.homing = Homing::run;
    ready();
    EXPECT_TRUE(device->state().is_homed);
    expect_touch(probe(), {kRadius, 0, 0});
}

TEST_F(ExternalDeviceTest, ATouchThatIsSeenLateIsSaidToBe) {
    VirtualProgramOptions wanted;
    wanted.latch_time = Seconds(0.002);
    start(wanted);
    options.touch_error_mm = 0.005;  // less than 5 mm/s x 2 ms
    const auto problem = [&] {
        ExternalMachine machine(std::make_unique<TcpStream>(*parse_host_port(program->address())), options);
        for (const auto& setting : machine.report().settings) {
            if (setting.name == "touch seen within") return setting.problem;
        }
        return std::string("not told");
    };
    EXPECT_THAT(problem(), HasSubstr("raise machine.noise"));
    start(wanted);
    options.touch_pace = Pace::touch;
    EXPECT_EQ(problem(), "");
}

// --- what a program does wrong ---------------------------------------------------------------------------------------

struct Wrong {
    Kind kind;
    const char* says;
};

class ProgramThatLies : public ExternalDeviceTest, public ::testing::WithParamInterface<Wrong> {};

TEST_P(ProgramThatLies, IsNotBelieved) {
    suffer(GetParam().kind);
    ready();
    EXPECT_THAT(message_of<BadAnswer>([&] { (void)probe(); }), HasSubstr(GetParam().says));
    const std::uint64_t moves = program->moves();
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), PositionLost) << "nothing more moves";
    EXPECT_EQ(program->moves(), moves);
    EXPECT_LE(moves, 1U) << "no way back is reckoned from what it said";
}

INSTANTIATE_TEST_SUITE_P(All, ProgramThatLies,
                         ::testing::Values(Wrong{Kind::wrong_id, "answers question"}, Wrong{Kind::no_json, "says a line that is no JSON"},
                                           Wrong{Kind::touched_beside, "which is not on its way"}, Wrong{Kind::rest_beside, "but rests at"},
                                           Wrong{Kind::rest_far, "it did not stop for it"}, Wrong{Kind::seen_beside, "off its way"},
                                           Wrong{Kind::half_answer, "without all of ended, position and probe"}),
                         [](const auto& info) { return "kind_" + std::to_string(static_cast<int>(info.param.kind)); });

TEST_F(ExternalDeviceTest, AProgramThatFallsSilentIsToldToStop) {
    suffer(Kind::silent);
    ready();
    EXPECT_THAT(message_of<DeviceTimeout>([&] { (void)probe(); }), HasSubstr("is silent while a sign of life in a move"));
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), PositionLost);
}

TEST_F(ExternalDeviceTest, AMoveThatNeverEndsIsToldToStop) {
    suffer(Kind::never_ends);
    ready();
    EXPECT_THAT(message_of<DeviceTimeout>([&] { (void)device->guarded_move({19, 0, 0}, Pace::travel); }), HasSubstr("took far longer"));
}

TEST_F(ExternalDeviceTest, AProgramThatIsGoneIsAConnectionLost) {
    suffer(Kind::hang_up);
    ready();
    EXPECT_THAT(message_of<ConnectionLost>([&] { (void)probe(); }), HasSubstr("the other side ended it"));
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), PositionLost);
    ready();
    EXPECT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached) << "a new connection goes on";
}

TEST_F(ExternalDeviceTest, AnErrorInMidMoveIsNoRefusal) {
    suffer(Kind::error_in_move);
    ready();
    EXPECT_THAT(message_of<DeviceAlarm>([&] { (void)probe(); }), HasSubstr("was told to stop; it may be pressed"));
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), PositionLost);
}

TEST_F(ExternalDeviceTest, AClosedProbeAtTheEndOfAMoveIsNoClear) {
    suffer(Kind::closed_at_end);
    ready();
    EXPECT_THAT(message_of<BadAnswer>([&] {
                    (void)device->guarded_move({15, 0, 0}, Pace::travel);
                }),
                HasSubstr("no contact and a closed probe"));
    EXPECT_NEAR(tool_at().x(), 15.5, 0.01) << "it was taken back first, until the probe opened and a retract beyond";
}

TEST_F(ExternalDeviceTest, AToolThatSomebodyElseMovedIsNotMoved) {
    ready();
    program->with([](VirtualTool& t) { t.place(Point(20, 5, 0) + kOrigin); });
    EXPECT_THAT(message_of<BadAnswer>([&] { (void)probe(); }), HasSubstr("was it moved by something else?"));
    EXPECT_EQ(program->moves(), 0U);
}

TEST_F(ExternalDeviceTest, ACoarserMachineThanToldIsRefused) {
    axes.motion.resolution_mm = 0.1;
    start();
    EXPECT_THAT(message_of<DeviceError>([&] { ready(); }), HasSubstr("coarser than machine.resolution"));
}

TEST_F(ExternalDeviceTest, ARefusedMoveMovesNothingAndIsNoEnd) {
    suffer(Kind::refuses);
    ready();
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("it does not want to"));
    EXPECT_EQ(audit().moves, 0U);
    expect_touch(probe(), {kRadius, 0, 0});
}

TEST_F(ExternalDeviceTest, AStopByWhoeverElseEndsTheSession) {
    suffer(Kind::stops_by_itself);
    ready();
    EXPECT_THAT(message_of<DeviceAlarm>([&] {
                    (void)device->guarded_move({15, 0, 0}, Pace::travel);
                }),
                HasSubstr("not by Palpate, but: its emergency stop is in"));
}

TEST_F(ExternalDeviceTest, AProbeThatStaysClosedIsTold) {
    suffer(Kind::stays_closed, 2);
    ready();
    EXPECT_THAT(message_of<ProbeClosed>([&] { (void)probe(); }), HasSubstr("stays closed although the tool went back to"));
}

// --- stopping --------------------------------------------------------------------------------------------------------

TEST_F(ExternalDeviceTest, AStopEndsTheMoveAndGoesBack) {
    VirtualProgramOptions wanted;
    wanted.is_fast = false;
    start(wanted);
    options.motion.feeds.travel_mm_per_s = 20;
    ready();
    std::jthread hand([&] {
        std::this_thread::sleep_for(300ms);
        stop.request_stop();
    });
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_THAT(message_of<Stopped>([&] {
                    (void)device->guarded_move({20, 20, 0}, Pace::travel);
                }),
                HasSubstr("the tool went back to (20, 0, 0) mm"));
    EXPECT_LT(std::chrono::steady_clock::now() - begun, 5s);
    EXPECT_NEAR((tool_at() - kStart).norm(), 0, 0.005);
    EXPECT_THROW((void)device->guarded_move({20, 20, 0}, Pace::travel), Stopped);
}

TEST_F(ExternalDeviceTest, AProgramWhoseHostIsGoneStops) {
    VirtualProgramOptions wanted;
    wanted.is_fast = false;
    start(wanted);
    ready();
    // As a host that is killed in mid-move: told to move, and gone.
    stream->write(R"({"id":1000,"ask":"travel","to":[21,40,3],"feed":20,"acceleration":200,"until":"closed"})"
                  "\n");
    std::this_thread::sleep_for(200ms);
    device.reset();
    stream.reset();
    std::this_thread::sleep_for(500ms);
    EXPECT_EQ(program->abandoned(), 1U);
    EXPECT_LT(tool_at().y(), 12);
    EXPECT_EQ(audit().moves, 1U) << "it stands";
}

// --- the examples ----------------------------------------------------------------------------------------------------

class ExampleArm : public ::testing::TestWithParam<std::vector<std::string>> {};

TEST_P(ExampleArm, Probes) {
    SteadyClock clock;
    ExternalOptions options;
    options.motion.feeds = {50, 20, 5};
    options.motion.acceleration_mm_per_s2 = 1000;
    options.motion.resolution_mm = 0.005;
    ChildStream stream(GetParam());
    ExternalDevice device(stream, clock, options);
    device.make_ready();
    EXPECT_EQ(device.position(), Point(0, 0, 60));
    ASSERT_EQ(device.guarded_move({0, 0, 30}, Pace::travel).outcome, Outcome::reached);
    const MoveResult result = device.guarded_move({0, 0, 0}, Pace::probe);
    ASSERT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR((result.position - Point(0, 0, 20)).norm(), 0, 0.006);
    EXPECT_NEAR(device.position().z(), 20.5, 0.02);
    EXPECT_THROW((void)device.guarded_move({0, 0, 200}, Pace::travel), OutOfLimits);
}

INSTANTIATE_TEST_SUITE_P(All, ExampleArm,
                         ::testing::Values(std::vector<std::string>{"python3", PALPATE_SOURCE_DIR "/tools/examples/virtual_arm.py"},
                                           std::vector<std::string>{PALPATE_VIRTUAL_ARM}),
                         [](const auto& info) { return info.param.size() == 2 ? "python" : "cpp"; });

TEST(ChildStreamTest, SaysHowAProgramEnded) {
    EXPECT_THAT(message_of<DeviceError>([] { ChildStream stream({"/no/such/program"}); }), HasSubstr("cannot be started: No such file"));
    const auto end_of = [](const std::string& script) {
        ChildStream stream({"sh", "-c", script});
        return message_of<ConnectionLost>([&] {
            for (int k = 0; k < 100; ++k) (void)stream.read(100ms);
        });
    };
    EXPECT_THAT(end_of("exit 3"), HasSubstr("it ended with exit code 3"));
    EXPECT_THAT(end_of("kill -9 $$"), HasSubstr("it was ended by signal 9"));
    // One that does not end with its input is ended.
    const auto begun = std::chrono::steady_clock::now();
    { const ChildStream stream({"sleep", "1000"}); }
    EXPECT_LT(std::chrono::steady_clock::now() - begun, 10s);
}

}  // namespace
}  // namespace palpate::external_device_test
