// Sessions that are stopped, paused, killed and cut off: nothing is lost, nothing is pressed on, and all of them end with the same bytes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "devices/session/journal.h"
#include "sim/machines/modbus/virtual_modbus.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"
#include "tests/tools/terminal_rig.h"

namespace palpate::interrupted_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::HasSubstr;

class Interrupted : public SessionRig {
protected:
    Interrupted() { write("part.yaml", "grbl: {port: " + port().string() + "}\n  homing: run\n  probe_proof: first_touch"); }

    void run_reference() {
        PortMachine machine(port());
        const auto begin = Clock::now();
        ASSERT_EQ(run(probe("reference")), 0) << read("out.txt");
        whole_ = Clock::now() - begin;
        mesh_ = read("reference/mesh.ply");
        touches_ = read("reference/touches.csv");
    }
    void expect_same(const std::string& session) const {
        EXPECT_EQ(read(session + "/mesh.ply"), mesh_);
        EXPECT_EQ(read(session + "/touches.csv"), touches_) << "a touch was lost, or is there twice";
    }

    // So many sessions, each met by a random one of all that may happen to it.
    void interrupt(int sessions);

    std::chrono::duration<double> whole_{};
    std::string mesh_;
    std::string touches_;
};

TEST_F(Interrupted, CtrlBackslashStopsAsCtrlCDoes) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    for (const char* key : {TypedAt::kCtrlC, TypedAt::kCtrlBackslash}) {
        PortMachine machine(port());
        const std::string name = key == TypedAt::kCtrlC ? "c" : "backslash";
        TypedAt terminal(folder_, {"probe", "part.yaml", "-o", name, "--yes"});
        wait_for_probes(machine, 30);
        terminal.type(key);
        EXPECT_EQ(terminal.wait(), 3) << terminal.said;
        EXPECT_THAT(terminal.said, HasSubstr("stopped"));
        EXPECT_EQ(run(resume(name)), 0) << read("out.txt");
        expect_same(name);
        expect_safe(machine);
    }
}

TEST_F(Interrupted, CtrlZBringsTheToolToRestAndTheSessionGoesOnAfterwards) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "part", "--yes"});
    for (std::uint64_t probes = 20; probes <= 100; probes += 20) {
        wait_for_probes(machine, probes);
        terminal.type(TypedAt::kCtrlZ);
        ASSERT_TRUE(terminal.stops(5s)) << terminal.said;
        bool rests = false;
        machine.host().with([&](VirtualGrbl& grbl) { rests = !grbl.is_busy(); });
        EXPECT_TRUE(rests);
        const std::uint64_t moves = machine.audit().moves;
        std::this_thread::sleep_for(probes == 100 ? 5s : 100ms);
        EXPECT_EQ(machine.audit().moves, moves);
        terminal.send(SIGCONT);
    }
    EXPECT_EQ(terminal.wait(), 0) << terminal.said;
    expect_same("part");
    EXPECT_EQ(read_journal(folder_ / "part/journal.jsonl").resumptions.size(), 0U) << "it was one session";
    expect_safe(machine);
}

TEST_F(Interrupted, AMachineThatSomebodyMovedDuringThePauseIsNoticed) {
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "part", "--yes"});
    wait_for_probes(machine, 40);
    terminal.type(TypedAt::kCtrlZ);
    ASSERT_TRUE(terminal.stops(5s)) << terminal.said;
    ASSERT_TRUE(machine.place_by_hand(kAbove));
    const std::uint64_t moves = machine.audit().moves;
    terminal.send(SIGCONT);
    EXPECT_EQ(terminal.wait(), 3);
    EXPECT_THAT(terminal.said, HasSubstr("after it: something else moved it"));
    EXPECT_EQ(machine.audit().moves, moves);
    EXPECT_EQ(run(resume("part")), 0) << read("out.txt");
    expect_safe(machine);
}

// A Modbus controller that hears no heartbeat stops by itself, and disables its drives.
TEST_F(Interrupted, AModbusSessionRestsAndGoesOnToo) {
    const HiddenObject object(ShapeSpec{SphereSpec{kRadius}});
    VirtualModbusOptions options;
    options.tool = axes();
    options.speedup = 100;
    VirtualModbus modbus(object, options, VirtualModbusTcp{});
    write("modbus.yaml", "modbus: {tcp: {host: 127.0.0.1, port: " + std::to_string(std::get<ModbusTcp>(modbus.link().where).port) +
                             "}}\n  probe_proof: first_touch");
    const auto audit = [&] { return modbus.with_controller([](const VirtualModbusController& c) { return c.tool().audit(); }); };
    TypedAt terminal(folder_, {"probe", "modbus.yaml", "-o", "part", "--yes", "--set", "probing.epsilon=3"});
    for (const int signal : {SIGTSTP, SIGSTOP, SIGTSTP}) {
        const std::uint64_t before = audit().moves;
        for (int k = 0; k < 20'000 && audit().moves < before + 15; ++k) std::this_thread::sleep_for(1ms);
        terminal.send(signal);
        ASSERT_TRUE(terminal.stops(5s)) << terminal.said;
        std::this_thread::sleep_for(3s);
        terminal.send(SIGCONT);
    }
    EXPECT_EQ(terminal.wait(), 0) << terminal.said;
    EXPECT_EQ(audit().unguarded_moves + audit().outside_limits + audit().unsafe_moves, 0U);
    EXPECT_EQ(read_journal(folder_ / "part/journal.jsonl").resumptions.size(), 0U) << "it was one session";
}

// Nothing can be done before SIGSTOP; what the machine said meanwhile is read afterwards.
TEST_F(Interrupted, AProcessThatWasStoppedGoesOn) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    PortMachine machine(port());
    Process session = start(probe("part"));
    for (const std::uint64_t probes : {20U, 60U, 90U}) {
        wait_for_probes(machine, probes);
        session.send(SIGSTOP);
        std::this_thread::sleep_for(5s);
        session.send(SIGCONT);
    }
    EXPECT_EQ(session.wait(), 0) << read("out.txt");
    expect_same("part");
    expect_safe(machine);
}

void Interrupted::interrupt(int sessions) {
    constexpr std::uint64_t kSeed = 22;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    ASSERT_NO_FATAL_FAILURE(run_reference());
    enum class How { kill, term, quit, pause, hold, full_disk, moved, unplugged };
    constexpr int kWays = 8;
    std::chrono::duration<double> slowest{0};
    std::array<int, kWays> met{};
    for (int k = 0; k < sessions; ++k) {
        const auto how = static_cast<How>(random.below(kWays));
        std::string name = "session_" + std::to_string(k);
        SCOPED_TRACE(name + ", way " + std::to_string(static_cast<int>(how)));
        PortMachine machine(port());
        const double moment = random.uniform(0.05, 0.9);
        int code = 0;
        if (how == How::full_disk) {
            const auto size = static_cast<rlim_t>(moment * static_cast<double>(fs::file_size(folder_ / "reference/journal.jsonl")));
            code = start(probe(name), size).wait();
        } else {
            TypedAt terminal(folder_, {"probe", "part.yaml", "-o", name, "--yes"});
            std::this_thread::sleep_for(moment * whole_);
            const auto begin = Clock::now();
            switch (how) {
                case How::kill:
                    terminal.send(SIGKILL);
                    break;
                case How::term:
                    terminal.send(SIGTERM);
                    break;
                case How::quit:
                    terminal.type(TypedAt::kCtrlBackslash);
                    break;
                case How::pause:
                    terminal.type(TypedAt::kCtrlZ);
                    if (terminal.stops(5s)) terminal.send(SIGCONT);
                    break;
                case How::hold:
                    terminal.type(TypedAt::kCtrlS);
                    std::this_thread::sleep_for(20ms);
                    terminal.send(SIGTERM);
                    break;
                case How::moved:
                    if (fs::exists(folder_ / name)) fs::rename(folder_ / name, folder_ / (name + "_elsewhere"));
                    if (!fs::exists(folder_ / name)) name += "_elsewhere";
                    break;
                case How::unplugged:
                    machine.host().unplug();
                    break;
                case How::full_disk:
                    break;
            }
            code = how == How::hold ? terminal.ended() : terminal.wait();
            if (how == How::term || how == How::quit || how == How::hold)
                slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - begin));
            if (how == How::unplugged) machine.host().plug_in();
            if (code != 0) ++met[static_cast<std::size_t>(how)];
            if (how == How::pause) {
                ASSERT_EQ(code, 0) << terminal.said;
                ++met[static_cast<std::size_t>(how)];
            }
        }
        if (how == How::full_disk && code != 0) ++met[static_cast<std::size_t>(how)];
        const bool has_begun = fs::exists(folder_ / name / "journal.jsonl") && fs::file_size(folder_ / name / "journal.jsonl") > 0;
        if (code != 0) {
            ASSERT_EQ(run(has_begun ? resume(name) : probe(name)), 0) << read("out.txt");
        }
        expect_same(name);
        expect_safe(machine);
        ASSERT_FALSE(HasFailure());
    }
    EXPECT_GT(std::accumulate(met.begin(), met.end(), 0), sessions / 2) << "the others were over by then";
    EXPECT_LT(slowest.count(), 5.0);
    std::cout << "slowest stop: " << slowest.count() << " s\n";
}

TEST_F(Interrupted, InEveryWayItEndsWithTheSameBytes) { interrupt(12); }
TEST_F(Interrupted, NightlyAHundredTimes) { interrupt(100); }

}  // namespace
}  // namespace palpate::interrupted_test
