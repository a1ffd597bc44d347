// Machines that conform, and machines that do not, in real time.
#include "devices/conformance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <thread>

#include "devices/errors.h"
#include "devices/external/external_machine.h"
#include "devices/grbl/stream_grbl_machine.h"
#include "devices/posix/serial_port.h"
#include "devices/posix/tcp_stream.h"
#include "sim/machines/external/virtual_program.h"
#include "sim/machines/grbl/grbl_host.h"
#include "sim/objects/hidden_object.h"

namespace palpate::conformance_test {
namespace {

using ::testing::HasSubstr;
using Verdict = Conformance::Verdict;

constexpr double kReach = 8.0;
const Point kStart(0, 0, 40);

class ConformanceTest : public ::testing::Test {
protected:
    ConformanceTest() {
        options.motion.feeds = {40, 20, 16};
        options.motion.acceleration_mm_per_s2 = 500;
        options.limits = Box{Point::Constant(-50), Point::Constant(50)};
        options.reach_mm = kReach;
        axes.motion = options.motion;
        axes.start = kStart;
        axes.limits = options.limits;
    }
    // By what was tried.
    std::map<std::string, Conformance> found;

    bool run(const std::function<std::unique_ptr<Machine>(const StopToken&)>& connect, const std::function<void(bool)>& press) {
        SteadyClock clock;
        ConformanceAudience audience;
        audience.tell = [&](const Conformance& c) { found[c.what] = c; };
        std::jthread finger;
        if (press) {
            audience.ask_hand = [&](ConformanceAudience::Hand hand) {
                using Hand = ConformanceAudience::Hand;
                if (hand != Hand::tap) return press(hand == Hand::hold);
                finger = std::jthread([&] {
                    std::this_thread::sleep_for(std::chrono::milliseconds(250));
                    press(true);
                    std::this_thread::sleep_for(std::chrono::milliseconds(100));
                    press(false);
                });
            };
        }
        return try_conformance(connect, clock, options, audience);
    }
    [[nodiscard]] bool all_are(Verdict verdict) const {
        return std::ranges::all_of(found, [&](const auto& each) {
            return each.second.verdict == verdict || each.first == "stops when Palpate is gone in mid-move";
        });
    }
    [[nodiscard]] std::string bad() const {
        std::string text;
        for (const auto& [what, c] : found) {
            if (c.verdict == Verdict::bad) text += what + ": " + c.why + "\n";
        }
        return text;
    }
    std::function<std::unique_ptr<Machine>(const StopToken&)> connecting_to(VirtualProgram& program) {
        return [&](const StopToken& stop) -> std::unique_ptr<Machine> {
            ExternalOptions driver{options.motion};
            for (int again = 0;; ++again) {
                try {
                    return std::make_unique<ExternalMachine>(std::make_unique<TcpStream>(*parse_host_port(program.address())), driver,
                                                             stop);
                } catch (const DeviceError&) {
                    // It sees the end of the connection before a moment later.
                    if (again == 1000) throw;
                    std::this_thread::sleep_for(std::chrono::milliseconds(2));
                }
            }
        };
    }

    ConformanceOptions options;
    HiddenObject far_away{ShapeSpec{SphereSpec{1.0}}};
    VirtualToolOptions axes;
};

TEST_F(ConformanceTest, AGrblMachineConforms) {
    VirtualTool tool(far_away, axes);
    VirtualGrbl grbl(tool, {});
    GrblHost host(grbl, {});
    const auto connect = [&](const StopToken& stop) -> std::unique_ptr<Machine> {
        return std::make_unique<StreamGrblMachine>(std::make_unique<SerialPort>(SerialPortOptions{host.client_path()}),
                                                   GrblOptions{options.motion, Point::Zero(), Homing::skip}, stop);
    };
    EXPECT_TRUE(run(connect, [&](bool pressed) { host.with([&](VirtualGrbl&) { tool.press(pressed); }); })) << bad();
    EXPECT_TRUE(all_are(Verdict::good)) << bad();
    EXPECT_EQ(found.size(), 9U);
    host.with([&](VirtualGrbl&) {
        EXPECT_EQ(tool.audit().unguarded_moves, 0U);
        EXPECT_LE((tool.position() - kStart).cwiseAbs().maxCoeff(), kReach + 0.01);
    });
}

TEST_F(ConformanceTest, AProgramConforms) {
    VirtualTool tool(far_away, axes);
    VirtualProgramOptions real_time;
    real_time.is_fast = false;
    VirtualProgram program(tool, real_time);
    EXPECT_TRUE(run(connecting_to(program), [&](bool pressed) { program.with([&](VirtualTool& t) { t.press(pressed); }); })) << bad();
    EXPECT_TRUE(all_are(Verdict::good)) << bad();
}

TEST_F(ConformanceTest, WithoutAHandTheRestIsTried) {
    VirtualTool tool(far_away, axes);
    VirtualProgramOptions real_time;
    real_time.is_fast = false;
    VirtualProgram program(tool, real_time);
    EXPECT_TRUE(run(connecting_to(program), {})) << bad();
    EXPECT_EQ(found.at("ends a move at a touch, and draws back").verdict, Verdict::skipped);
}

TEST_F(ConformanceTest, WhatIsWrongIsNamedAndEndsIt) {
    VirtualTool tool(far_away, axes);
    {
        VirtualProgramOptions wrong;
        wrong.faults = {{ProgramFault::Kind::rest_beside, 5}};
        VirtualProgram program(tool, wrong);
        EXPECT_FALSE(run(connecting_to(program), {}));
        EXPECT_THAT(found.at("goes where it is told").why, HasSubstr("which is not the target"));
        EXPECT_EQ(program.moves(), 5U);
    }
    found.clear();
    VirtualProgram fast(tool, {});
    EXPECT_FALSE(run(connecting_to(fast), {}));
    EXPECT_EQ(found.at("goes where it is told").verdict, Verdict::good);
    EXPECT_THAT(found.at("keeps its feeds").why, HasSubstr("faster than it was told"));
    EXPECT_FALSE(found.contains("makes short moves without loss"));
}

TEST_F(ConformanceTest, NothingMovesWhereTheReportHasProblems) {
    VirtualTool tool(far_away, axes);
    VirtualProgramOptions unhomed;
    unhomed.homed = false;
    VirtualProgram program(tool, unhomed);
    EXPECT_FALSE(run(connecting_to(program), {}));
    EXPECT_THAT(bad(), HasSubstr("home it by its own means"));
    EXPECT_EQ(program.moves(), 0U);
}

}  // namespace
}  // namespace palpate::conformance_test
