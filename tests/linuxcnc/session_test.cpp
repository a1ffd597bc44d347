// A LinuxCNC that runs (rig.ini), whose HAL hides a torus: started by `run`, in whose folder this is. One of its components counts what
// must never happen (audit).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "devices/errors.h"
#include "devices/external/external_device.h"
#include "devices/posix/child_stream.h"
#include "devices/posix/tcp_stream.h"
#include "tests/devices/message_of.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"

namespace palpate::session_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Outcome = MoveResult::Outcome;

constexpr double kMajor = 10.0;  // mm, of the torus in rig.hal
constexpr double kMinor = 5.0;
constexpr double kServo = 0.001;  // s
constexpr double kProbe = 50.0;   // mm/s
constexpr const char* kAddress = "127.0.0.1:5010";

double distance_to_torus(const Point& p) { return std::hypot(std::hypot(p.x(), p.y()) - kMajor, p.z()) - kMinor; }

// What a command says on its standard output.
std::string output_of(const std::string& command) {
    ChildStream stream({"sh", "-c", command});
    std::string said;
    try {
        while (true) said += stream.read(100ms);
    } catch (const ConnectionLost&) {
        return said;
    }
}

double pin(const std::string& name) {
    return std::stod(output_of("halcmd getp audit." + name + " | tr -d '\\n' | sed 's/FALSE/0/;s/TRUE/1/'"));
}

bool wait_until(const std::function<bool()>& holds) {
    for (int k = 0; k < 2000; ++k) {
        if (holds()) return true;
        std::this_thread::sleep_for(10ms);
    }
    return false;
}

class RealLinuxCnc : public SessionRig {
protected:
    RealLinuxCnc() {
        std::ofstream(folder_ / "part.yaml")
            << "machine:\n  external: {address: \"" << kAddress << "\", silence: 1}\n"
            << "  homing: run\n  origin: [0, 0, -30]\n  limits: {min: [-22, -22, -22], max: [22, 22, 32]}\n"
               "  feeds: {travel: 200, probe: 50, touch: 5}\n  acceleration: 5000\n  latency: 0.003\n"
               "  overtravel: 6\n  retract: 0.5\n  noise: 0.05\n  probe_proof: first_touch\n"
               "  touch: {confirm: false}\n"
               "workspace: {ball: {center: [0, 0, 0], radius: 18}}\nprobing: {epsilon: 3}\n";
        options.motion.feeds = {200, kProbe, 5};
        options.motion.acceleration_mm_per_s2 = 5000;
        options.motion.latency = Seconds(0.003);
        options.motion.overtravel_mm = 6;
        options.origin = Point(0, 0, -30);
        options.homing = Homing::run;
        options.silence = 1s;
    }
    void SetUp() override {
        ASSERT_TRUE(wait_until([] { return output_of("halcmd getp audit.looks 2>/dev/null") != ""; })) << output_of("cat linuxcnc.log");
        bridge = std::make_unique<ChildStream>(
            std::vector<std::string>{"sh", "-c",
                                     std::string(PALPATE_SOURCE_DIR "/tools/linuxcnc_bridge --silence 1 --listen ") + kAddress +
                                         " & cat >/dev/null; kill $!; wait $!"});
        std::string said;
        ASSERT_TRUE(wait_until([&] { return (said += bridge->read(0ms)).find("listens") != std::string::npos; }));
        switch_on();
        arm(true);
    }
    void TearDown() override {
        device.reset();
        stream.reset();
        bridge.reset();
        arm(false);
        EXPECT_GT(pin("looks"), 100) << "the audit has looked";
        EXPECT_EQ(pin("unguarded"), 0);
        EXPECT_EQ(pin("outside"), 0);
        EXPECT_LT(pin("deepest"), kProbe * kProbe / (2 * 5000) + 3 * kServo * kProbe) << "it stops for a touch, and travels into none";
    }
    static void arm(bool is_armed) { output_of(std::string("halcmd setp audit.armed ") + (is_armed ? "1" : "0")); }
    // As the operator, at LinuxCNC's own panel.
    static void switch_on() {
        output_of(
            "/usr/bin/python3 -c 'import linuxcnc as l; c = l.command()\n"
            "for state in (l.STATE_ESTOP_RESET, l.STATE_ON): c.state(state); c.wait_complete(5)'");
    }
    static void set(const std::string& signal, bool on) { output_of("halcmd sets " + signal + (on ? " 1" : " 0")); }
    ExternalDevice& connect() {
        device.reset();
        stream.reset();
        stream = std::make_unique<TcpStream>(*parse_host_port(kAddress));
        device = std::make_unique<ExternalDevice>(*stream, clock, options);
        return *device;
    }

    ExternalOptions options;
    SteadyClock clock;
    std::unique_ptr<ChildStream> bridge;
    std::unique_ptr<TcpStream> stream;
    std::unique_ptr<ExternalDevice> device;
};

TEST_F(RealLinuxCnc, TouchesWhereThePartIsWithinAServoCycle) {
    connect().make_ready();
    EXPECT_NEAR((device->position() - Point(0, 0, 30)).norm(), 0, 1e-6);
    Random random(11);
    double worst = 0;
    for (int k = 0; k < 25; ++k) {
        // Around the torus, then at it: the ways outside are free.
        const double turn = random.uniform(0, 2 * M_PI);
        const double tilt = random.uniform(-1.2, 1.2);
        const Point core(kMajor * std::cos(turn), kMajor * std::sin(turn), 0);
        const Point outside = core + 8 * Point(std::cos(tilt) * std::cos(turn), std::cos(tilt) * std::sin(turn), std::sin(tilt));
        const auto go = [&](const Point& p) {
            ASSERT_EQ(device->guarded_move(p, Pace::travel).outcome, Outcome::reached) << k << ' ' << p.transpose();
        };
        const double height = tilt < 0 ? -15 : 15;
        go({device->position().x(), device->position().y(), 15});
        go({20, 20, 15});
        go({20, 20, height});
        go({outside.x(), outside.y(), height});
        go(outside);
        const MoveResult touch = device->guarded_move(core, Pace::probe);
        ASSERT_EQ(touch.outcome, Outcome::contact);
        worst = std::max(worst, std::abs(distance_to_torus(touch.position)));
        EXPECT_GT(distance_to_torus(device->position()), 0.3) << "it drew back";
        go(outside);
        go({outside.x(), outside.y(), height});
        go({20, 20, height});
        go({20, 20, 15});
    }
    EXPECT_LT(worst, 1.01 * kServo * kProbe);
    RecordProperty("worst_um", static_cast<int>(1000 * worst));
}

TEST_F(RealLinuxCnc, ItsEventsAreSeenForWhatTheyAre) {
    connect().make_ready();
    ASSERT_EQ(device->guarded_move({20, 20, 20}, Pace::travel).outcome, Outcome::reached);

    set("finger", true);
    ASSERT_TRUE(wait_until([&] { return device->state().is_probe_closed; }));
    EXPECT_THAT(message_of<ProbeClosed>([&] {
                    (void)device->guarded_move({20, 20, 0}, Pace::probe);
                }),
                HasSubstr("is closed where a move begins"));
    set("finger", false);
    ASSERT_TRUE(wait_until([&] { return !device->state().is_probe_closed; }));
    ASSERT_EQ(device->guarded_move({20, 20, 19}, Pace::probe).outcome, Outcome::reached);

    EXPECT_THROW((void)device->guarded_move({20, 20, 91}, Pace::probe), OutOfLimits);

    std::jthread button([] {
        std::this_thread::sleep_for(200ms);
        set("button", false);
    });
    EXPECT_THAT(message_of<DeviceAlarm>([&] {
                    (void)device->guarded_move({20, -20, 19}, Pace::probe);
                }),
                HasSubstr("the emergency stop is in"));
    button.join();
    EXPECT_THAT(message_of<DeviceAlarm>([&] { connect().make_ready(); }), HasSubstr("the emergency stop is in"));
    set("button", true);
    switch_on();
    EXPECT_FALSE(connect().state().is_homed) << "LinuxCNC itself says that it is";
    device->make_ready();
    EXPECT_TRUE(device->state().is_homed);
    ASSERT_EQ(device->guarded_move({device->position().x(), device->position().y(), 20}, Pace::travel).outcome, Outcome::reached);
    ASSERT_EQ(device->guarded_move({kMajor, 0, 20}, Pace::travel).outcome, Outcome::reached);
    const MoveResult touch = device->guarded_move({kMajor, 0, 0}, Pace::probe);
    ASSERT_EQ(touch.outcome, Outcome::contact);
    EXPECT_NEAR((touch.position - Point(kMajor, 0, kMinor)).norm(), 0, 1.01 * kServo * kProbe);
    ASSERT_EQ(device->guarded_move({kMajor, 0, 30}, Pace::travel).outcome, Outcome::reached);
}

TEST_F(RealLinuxCnc, ASessionThatIsKilledIsResumedAndFindsTheHole) {
    Process first = start(probe("S"));
    ASSERT_TRUE(wait_until([&] {
        return fs::exists(folder_ / "S" / "journal.jsonl") && fs::file_size(folder_ / "S" / "journal.jsonl") > 8000;
    })) << read("out.txt");
    first.send(SIGKILL);
    EXPECT_EQ(first.wait(), 128 + SIGKILL);
    ASSERT_EQ(run(resume("S")), 0) << read("out.txt");
    const nlohmann::json summary = nlohmann::json::parse(read("S/summary.json"));
    EXPECT_EQ(summary["euler_characteristic"], 0);
    EXPECT_EQ(summary["components"], 1);
    EXPECT_EQ(summary["boundary_edges"], 0);
    EXPECT_EQ(summary["nonmanifold_edges"], 0);
    EXPECT_GT(summary["probes"]["total"], 150);
    EXPECT_EQ(summary["probes"]["failed"], 0);
    // Every touch is where the torus is.
    std::istringstream touches(read("S/touches.csv"));
    std::string line;
    std::getline(touches, line);
    int count = 0;
    for (; std::getline(touches, line); ++count) {
        Point p;
        int number = 0;
        ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lf,%lf,%lf", &number, &p.x(), &p.y(), &p.z()), 4);
        EXPECT_LT(std::abs(distance_to_torus(p)), 1.01 * kServo * kProbe) << line;
    }
    EXPECT_GT(count, 150);
}

}  // namespace
}  // namespace palpate::session_test
