// tools/linuxcnc_bridge and the driver on everything that LinuxCNC was seen to do (devices/FACTS.md, "Events").
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "devices/errors.h"
#include "devices/external/external_device.h"
#include "tests/devices/message_of.h"
#include "tests/linuxcnc/fake_linuxcnc.h"

namespace palpate::bridge_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Json = nlohmann::json;
using Outcome = MoveResult::Outcome;

constexpr double kRadius = 20.0;
const Point kStart(0, 0, 40);

class LinuxCncBridge : public ::testing::Test {
protected:
    LinuxCncBridge() {
        options.motion.feeds = {100, 20, 5};
        options.motion.acceleration_mm_per_s2 = 1000;
        options.motion.overtravel_mm = 8;
        options.silence = 1s;  // of a loaded computer
    }
    ExternalDevice& connect() {
        device.reset();
        stream.reset();
        stream = machine->connect();
        device = std::make_unique<ExternalDevice>(*stream, clock, options, stop.token());
        return *device;
    }
    ExternalDevice& start(const Json& wrong = Json::object()) {
        device.reset();
        stream.reset();
        machine.reset();
        machine = std::make_unique<test::FakeLinuxCnc>(wrong);
        return connect();
    }
    ExternalDevice& ready(const Json& wrong = Json::object()) {
        start(wrong).make_ready();
        return *device;
    }
    MoveResult probe() { return device->guarded_move({0, 0, 0}, Pace::probe); }
    void expect_touch(const MoveResult& result) const {
        EXPECT_EQ(result.outcome, Outcome::contact);
        EXPECT_NEAR((result.position - Point(0, 0, kRadius)).norm(), 0, 0.021) << "a servo cycle at 20 mm/s";
        EXPECT_GT(device->position().z(), kRadius);
    }
    // Of a driver that says what is asked, one by one.
    Json ask(const std::string& question) {
        stream->write(question + "\n");
        std::string said;
        while (true) {
            said += stream->read(100ms);
            for (std::size_t end = said.find('\n'); end != std::string::npos; end = said.find('\n')) {
                const Json line = Json::parse(said.substr(0, end));
                said.erase(0, end + 1);
                if (line.contains("id")) return line;
            }
            stream->write("{\"ask\":\"alive\"}\n");
        }
    }

    ExternalOptions options;
    StopSource stop;
    SteadyClock clock;
    std::unique_ptr<test::FakeLinuxCnc> machine;
    std::unique_ptr<TcpStream> stream;
    std::unique_ptr<ExternalDevice> device;
};

TEST_F(LinuxCncBridge, TouchesAndReaches) {
    ready();
    EXPECT_EQ(device->position(), kStart);
    expect_touch(probe());
    EXPECT_EQ(device->guarded_move(kStart, Pace::travel).outcome, Outcome::reached);
    EXPECT_NEAR((device->position() - kStart).norm(), 0, 1e-9);
    expect_touch(probe());
    EXPECT_FALSE(device->state().is_probe_closed);
    EXPECT_NEAR(device->hello().latch_time.count(), 0.001, 1e-9);
}

TEST_F(LinuxCncBridge, ModesAreSetForProbingAndGivenBack) {
    ready();
    EXPECT_EQ(machine->told("mdi"), 0U) << "before a move nothing changes";
    (void)probe();
    EXPECT_EQ(machine->told("mdi G40"), 1U);
    EXPECT_EQ(machine->told("mdi G21 G8 G90 G94 G61 G80 M49"), 1U);
    EXPECT_EQ(machine->told("mdi M52 P0"), 1U);
    (void)device->guarded_move(kStart, Pace::travel);
    EXPECT_EQ(machine->told("mdi G21 G8"), 1U) << "once";
    device.reset();
    stream.reset();
    for (int k = 0; k < 100 && machine->told("mdi G64") == 0; ++k) std::this_thread::sleep_for(20ms);
    EXPECT_EQ(machine->told("mdi G64 P0.05 G21 G90 G94 G8 M48"), 1U);
    connect();
    expect_touch(probe());
    EXPECT_EQ(machine->told("mdi G21 G8"), 2U) << "for each host";
}

TEST_F(LinuxCncBridge, AModeThatIsNotTakenIsARefusal) {
    ready({{"keeps_path", true}});
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("LinuxCNC does not take G40, G21"));
    ready({{"no_mdi", true}});
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("does not change its mode"));
    EXPECT_EQ(machine->moves(), 0U);
}

TEST_F(LinuxCncBridge, AMachineInInchesIsSpokenToInMillimetres) {
    ready({{"inch", true}});
    EXPECT_NEAR(device->hello().limits.max.x(), 60, 1e-9);
    EXPECT_NEAR(device->hello().acceleration_mm_per_s2, 1000, 1e-6);
    expect_touch(probe());
    EXPECT_EQ(device->guarded_move(kStart, Pace::travel).outcome, Outcome::reached);
}

// --- before the first move -------------------------------------------------------------------------------------------

struct NotReady {
    const char* name;
    Json wrong;
    const char* says;
};

class LinuxCncThatIsNotReady : public LinuxCncBridge, public ::testing::WithParamInterface<NotReady> {};

TEST_P(LinuxCncThatIsNotReady, IsNotMoved) {
    start(GetParam().wrong);
    EXPECT_THAT(message_of<DeviceAlarm>([&] { device->make_ready(); }), HasSubstr(GetParam().says));
    // Nor by a host that does not ask.
    EXPECT_THAT(ask(R"({"id":1000,"ask":"move_guarded","to":[0,0,0],"feed":5,"acceleration":100,"until":"closed"})").value("error", ""),
                Not(::testing::IsEmpty()));
    EXPECT_EQ(machine->moves(), 0U);
}

INSTANTIATE_TEST_SUITE_P(All, LinuxCncThatIsNotReady,
                         ::testing::Values(NotReady{"estop", {{"state", "estop"}}, "the emergency stop is in"},
                                           NotReady{"off", {{"state", "off"}}, "the machine is off"},
                                           NotReady{"unhomed", {{"unhomed", true}}, "is not homed"},
                                           NotReady{"g54", {{"g54", true}}, "coordinate system in use, G54"},
                                           NotReady{"rotation", {{"rotation", true}}, "shifted or turned"},
                                           NotReady{"g92", {{"g92", true}}, "G92.1"}, NotReady{"tool", {{"tool", true}}, "G49"},
                                           NotReady{"spindle", {{"spindle", true}}, "M5"}, NotReady{"mist", {{"mist", true}}, "M9"},
                                           NotReady{"joint", {{"joint_fault", true}}, "joint 0 has a fault"}),
                         [](const auto& info) { return info.param.name; });

TEST_F(LinuxCncBridge, IsHomedWhenAskedTo) {
    options.homing = Homing::run;
    ready({{"unhomed", true}});
    EXPECT_TRUE(device->state().is_homed);
    EXPECT_EQ(machine->told("home"), 1U);
    expect_touch(probe());
    start({{"unhomed", true}, {"home_fails", true}});
    EXPECT_THAT(message_of<DeviceAlarm>([&] { device->make_ready(); }), HasSubstr("joint 0 home switch not found"));
    EXPECT_EQ(machine->moves(), 0U);
}

TEST_F(LinuxCncBridge, BeyondTheLimitsAndWithAClosedProbeNothingMoves) {
    ready();
    EXPECT_THROW((void)device->guarded_move({0, 0, 61}, Pace::travel), OutOfLimits);
    EXPECT_THAT(ask(R"({"id":1000,"ask":"travel","to":[0,0,61],"feed":5,"acceleration":100,"until":"closed"})")["error"].get<std::string>(),
                HasSubstr("Probe move on line 0 would exceed Z's positive limit"));
    machine->hand("press");
    EXPECT_THAT(ask(R"({"id":1001,"ask":"travel","to":[0,0,50],"feed":5,"acceleration":100,"until":"closed"})")["error"].get<std::string>(),
                HasSubstr("the probe is closed"));
    EXPECT_THROW((void)probe(), ProbeClosed);
    machine->hand("release");
    expect_touch(probe());
}

// --- in a move -------------------------------------------------------------------------------------------------------

struct InMove {
    const char* name;
    Json wrong;
    const char* says;
};

class LinuxCncInAMove : public LinuxCncBridge, public ::testing::WithParamInterface<InMove> {};

TEST_P(LinuxCncInAMove, EndsTheSessionWithTheReason) {
    Json wrong = GetParam().wrong;
    ready(wrong);
    EXPECT_THAT(message_of<DeviceAlarm>([&] { (void)device->guarded_move({0, 0, 25}, Pace::probe); }), HasSubstr(GetParam().says));
    EXPECT_THROW((void)device->guarded_move(kStart, Pace::travel), PositionLost);
    EXPECT_EQ(machine->moves(), 1U) << "and nothing moves after it";
}

INSTANTIATE_TEST_SUITE_P(All, LinuxCncInAMove,
                         ::testing::Values(InMove{"estop", {{"estop_in_move", 1}}, "the emergency stop is in"},
                                           InMove{"off", {{"off_in_move", 1}}, "the machine is off"},
                                           InMove{"manual", {{"manual_in_move", 1}}, "somebody else commands LinuxCNC"},
                                           InMove{"pause", {{"pause_in_move", 1}}, "LinuxCNC is paused"},
                                           InMove{"held", {{"held", 1}}, "it stood still in a move"},
                                           InMove{"second_command", {{"second_mdi", 1}}, "somebody else commands LinuxCNC"},
                                           InMove{"task_died", {{"task_died", 1}}, "LinuxCNC's task or motion has died"},
                                           InMove{"motion_died", {{"motion_died", 1}}, "it stood still in a move"},
                                           InMove{"short", {{"short", 1}}, "ended it short of its target"}),
                         [](const auto& info) { return info.param.name; });

TEST_F(LinuxCncBridge, ALatchOffTheWayOrNoneIsNoTouch) {
    ready({{"beside", 1}});
    EXPECT_THAT(message_of<DeviceAlarm>([&] { (void)probe(); }), HasSubstr("off the way"));
    ready({{"no_latch", 1}});
    EXPECT_THAT(message_of<DeviceAlarm>([&] { (void)probe(); }), HasSubstr("short of its target"));
}

// It leaves what an earlier one has latched, which may lie on the way.
TEST_F(LinuxCncBridge, AMoveThatNeverBeginsIsNoTouch) {
    ready({{"never_begins", 4}});
    expect_touch(probe());  // and off it
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("LinuxCNC did not move"));
    expect_touch(probe());
}

TEST_F(LinuxCncBridge, ABounceAfterATouchIsATouch) {
    ready({{"bounce", 1}});
    expect_touch(probe());
}

TEST_F(LinuxCncBridge, AnErrorBeforeAnythingMovesIsARefusal) {
    ready({{"error", 1}});
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("joint 1 following error"));
    expect_touch(probe());
    // Another program beside it may have taken the words.
    ready({{"error", 1}, {"mute", true}});
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("LinuxCNC did not move"));
}

TEST_F(LinuxCncBridge, AProbeThatClosesAsAMoveBeginsIsATouchThereAndStaysClosed) {
    ready({{"closed_at_start", 1}});
    EXPECT_THAT(message_of<ProbeClosed>([&] { (void)probe(); }), HasSubstr("stays closed although the tool went back"));
    EXPECT_EQ(device->position(), kStart);
}

TEST_F(LinuxCncBridge, AfterAnEmergencyStopTheMachineCountsAsNotHomed) {
    ready({{"estop_in_move", 1}});
    EXPECT_THROW((void)probe(), DeviceAlarm);
    machine->hand("on");
    connect();
    EXPECT_FALSE(device->state().is_homed) << "LinuxCNC says that it is";
    EXPECT_THAT(message_of<DeviceAlarm>([&] { device->make_ready(); }), HasSubstr("is not homed"));
    options.homing = Homing::run;
    connect().make_ready();
    EXPECT_EQ(machine->told("unhome"), 1U);
    expect_touch(probe());
    // Between two hosts, too, and homed by hand.
    device.reset();
    stream.reset();
    machine->hand("estop");
    std::this_thread::sleep_for(200ms);
    machine->hand("on");
    std::this_thread::sleep_for(200ms);
    options.homing = Homing::require;
    EXPECT_THROW(connect().make_ready(), DeviceAlarm);
    machine->hand("unhome 0");
    std::this_thread::sleep_for(200ms);
    machine->hand("home");
    std::this_thread::sleep_for(200ms);
    EXPECT_FALSE(device->state().is_homed) << "one joint of three was homed since";
    machine->hand("unhome");
    std::this_thread::sleep_for(200ms);
    machine->hand("home");
    std::this_thread::sleep_for(200ms);
    device->make_ready();
}

TEST_F(LinuxCncBridge, AStopAbortsAndGoesBack) {
    ready();
    std::jthread hand([&] {
        std::this_thread::sleep_for(300ms);
        stop.request_stop();
    });
    EXPECT_THAT(message_of<Stopped>([&] {
                    (void)device->guarded_move({40, 0, 40}, Pace::probe);
                }),
                HasSubstr("the tool went back to (0, 0, 40) mm"));
    EXPECT_EQ(machine->told("abort"), 1U);
}

TEST_F(LinuxCncBridge, WhoTakesItOutOfMdiHasIt) {
    ready();
    (void)device->guarded_move({0, 0, 41}, Pace::probe);
    machine->hand("manual");
    EXPECT_THAT(message_of<DeviceRefused>([&] { (void)probe(); }), HasSubstr("it is theirs until a new session begins"));
    connect();
    expect_touch(probe());
}

// --- hosts -----------------------------------------------------------------------------------------------------------

TEST_F(LinuxCncBridge, AHostThatIsGoneOrSilentIsAnAbort) {
    const std::string move = R"({"id":1000,"ask":"travel","to":[40,0,40],"feed":10,"acceleration":200,"until":"closed"})"
                             "\n";
    for (const bool is_gone : {true, false}) {
        ready();
        stream->write(move);
        std::this_thread::sleep_for(100ms);
        EXPECT_EQ(machine->told("abort"), 0U);
        if (is_gone) {
            device.reset();
            stream.reset();
        }
        std::this_thread::sleep_for(is_gone ? 150ms : 500ms);
        EXPECT_EQ(machine->told("abort"), 1U) << is_gone;
        if (is_gone) {
            connect();
            EXPECT_LT(device->position().x(), 4) << "it stands where it was aborted, and serves the next";
            EXPECT_EQ(device->guarded_move(kStart, Pace::travel).outcome, Outcome::reached);
        }
    }
}

TEST_F(LinuxCncBridge, ASecondHostIsToldThatThereIsOne) {
    ready();
    // As from another computer: here a second one is refused before it connects.
    ChildStream other({"bash", "-c", fmt::format("exec 3<>/dev/tcp/127.0.0.1/{}; cat <&3 & exec cat >&3", machine->port())});
    const std::string says = message_of<DeviceError>([&] { const ExternalDevice second(other, clock, options); });
    EXPECT_THAT(says, HasSubstr("it is driven by 127.0.0.1:"));
    expect_touch(probe());
}

TEST_F(LinuxCncBridge, WhatIsNoQuestionEndsTheConnection) {
    for (const std::string& line :
         {std::string("GET / HTTP/1.1\n"), std::string("[]\n"), std::string("{\"id\":3}\n"), std::string("{\"id\":0,\"ask\":\"state\"}\n"),
          std::string(50000, '[') + "\n", std::string(100000, 'x')}) {
        start();
        stream->write(line);
        EXPECT_THROW(
            {
                for (int k = 0; k < 100; ++k) (void)stream->read(20ms);
            },
            ConnectionLost);
        connect();
    }
    EXPECT_THAT(ask(R"({"id":9,"ask":"dance"})")["error"].get<std::string>(), HasSubstr("not known"));
    for (const char* to : {"[1,2]", "\"up\"", "[1,2,NaN]", "[1,2,null]", "[1,2,1e300]", "[1,2,true]"}) {
        const Json answer = ask(std::string(R"({"id":10,"ask":"travel","feed":5,"acceleration":1,"until":"closed","to":)") + to + "}");
        EXPECT_THAT(answer["error"].get<std::string>(), HasSubstr("a move needs")) << to;
    }
    EXPECT_EQ(machine->moves(), 0U);
}

TEST_F(LinuxCncBridge, EndsWithItsLinuxCnc) {
    ready();
    machine->end();
    EXPECT_THROW((void)probe(), ConnectionLost);
}

}  // namespace
}  // namespace palpate::bridge_test
