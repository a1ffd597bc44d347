// A probe that dies, misses touches or is pressed by hand, through the program itself on a serial port: what the operator sees, and what is
// left.
#include <gmock/gmock.h>
#include <poll.h>
#include <pty.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "devices/session/journal.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"
#include "tests/tools/terminal_rig.h"

namespace palpate::probe_life_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Json = nlohmann::json;

VirtualToolOptions watched_axes() {
    VirtualToolOptions options = axes();
    options.probe_feed_mm_per_s = options.motion.feeds.probe_mm_per_s;
    return options;
}

class ProbeLife : public SessionRig {};

TEST_F(ProbeLife, AProbeThatDiesEndsTheSessionWhichIsResumedRightOnceItWorks) {
    constexpr std::uint64_t kSeed = 191;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    std::uint64_t probes = 0;
    {
        PortMachine machine(port());
        ASSERT_EQ(run(probe("reference")), 0) << read("out.txt");
        probes = machine.probes();
    }
    for (int moment = 0; moment < 6; ++moment) {
        const std::uint64_t at = 1 + random.below(probes * 3 / 4);
        SCOPED_TRACE("at move " + std::to_string(at) + " of " + std::to_string(probes));
        const std::string session = "dead_" + std::to_string(moment);
        {
            VirtualGrblOptions options;
            options.faults = {{VirtualFault::Kind::dead_probe, VirtualFault::When::probe, static_cast<double>(at), 0, {}}};
            PortMachine machine(port(), options, watched_axes());
            ASSERT_EQ(run(probe(session)), 3) << read("out.txt");
            EXPECT_THAT(read("out.txt"),
                        ::testing::AnyOf(HasSubstr("does not close any more"), HasSubstr("nothing shows that the probe works")));
            EXPECT_THAT(read("out.txt"), HasSubstr("palpate resume " + session));
            EXPECT_EQ(machine.audit().fast_moves_inside, 0U);
            EXPECT_EQ(machine.audit().unguarded_moves + machine.audit().outside_limits, 0U);
        }
        // It is mended; the tool is where it stopped.
        VirtualToolOptions there = watched_axes();
        there.start = kOrigin + read_journal(folder_ / session / "journal.jsonl").last_rest();
        PortMachine machine(port(), {}, there);
        ASSERT_EQ(run(resume(session)), 0) << read("out.txt");
        EXPECT_EQ(read(session + "/mesh.ply"), read("reference/mesh.ply")) << "nothing of what it found free was believed";
        expect_safe(machine);
    }
}

TEST_F(ProbeLife, TouchesThatAreMissedLeaveTheTopologyAsItIs) {
    for (const double rate : {0.01, 0.05}) {
        for (const char* strategy : {"default", "adaptive"}) {
            SCOPED_TRACE(std::to_string(rate) + " " + strategy);
            VirtualGrblOptions options;
            options.miss_rate = rate;
            PortMachine machine(port(), options, watched_axes());
            const std::string session = std::string(strategy) + std::to_string(rate);
            auto words = probe(session);
            words.insert(words.end(), {"--set", std::string("probing.strategy=") + strategy});
            ASSERT_EQ(run(words), 0) << read("out.txt");
            const Json summary = Json::parse(read(session + "/summary.json"));
            EXPECT_EQ(summary.at("euler_characteristic"), 2);
            EXPECT_EQ(summary.at("boundary_edges"), 0);
            EXPECT_EQ(summary.at("nonmanifold_edges"), 0);
            if (rate > 0.02) {
                EXPECT_GT(summary.at("probes").at("checks"), 0);
            }
            EXPECT_EQ(machine.audit().fast_moves_inside, 0U);
        }
    }
}

TEST_F(ProbeLife, TheWayHomeIsShortAndInTheAccountAndInTheJournal) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("home")), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("straight out of the workspace and around it to where it began"));
    const Journal journal = read_journal(folder_ / "home/journal.jsonl");
    EXPECT_EQ(journal.last_rest(), journal.header.start);
    const Json summary = Json::parse(read("home/summary.json"));
    const double home = summary.at("displacement").at("home");
    // Off the part, out, half around at most, and up to where it began.
    EXPECT_GT(home, 7.0);
    EXPECT_LE(home, 2 * (2 * 7 + 3.2 * 7 + 7));
    std::size_t last = journal.confirmed_moves();
    double way = 0;
    for (std::size_t k = last; k < journal.moves.size(); ++k) way += (journal.moves[k].rest - journal.rest_before(k)).norm();
    EXPECT_NEAR(way, home, 1.0) << "from the last contact, but for the retract and what came before the end";
}

// The virtual machine is another process, whose probe a signal presses.
class ByHand : public SessionRig {
protected:
    ByHand() {
        write("part.yaml", "grbl: {port: " + port().string() + "}\n  homing: run");
        std::ofstream(folder_ / "part.yaml", std::ios::app) << "object: {shape: {sphere: {radius: 5}}}\n";
        fs::create_directory(folder_ / "vm");
        machine_.emplace(folder_ / "vm",
                         std::vector<std::string>{"vm", "../part.yaml", "--grbl", port().string(), "--fast", "--audit", "audit"});
        for (int k = 0; k < 200 && !fs::exists(port()); ++k) std::this_thread::sleep_for(20ms);
    }
    ~ByHand() override { (void)end(); }
    // The machine's own account.
    Json end() {
        if (!machine_) return {};
        machine_->send(SIGINT);
        (void)machine_->wait();
        machine_.reset();
        return Json::parse(read("vm/audit"));
    }
    std::optional<Process> machine_;
};

TEST_F(ByHand, ASessionAtATerminalBeginsOnceTheProbeWasSeenToCloseAndToOpen) {
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "part"});
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.type("yes\n");
    ASSERT_TRUE(terminal.wait_for("(Enter: stop): ")) << terminal.said;
    machine_->send(SIGUSR1);
    ASSERT_TRUE(terminal.wait_for("it opened: it works")) << terminal.said;
    EXPECT_EQ(terminal.wait(), 0) << terminal.said;
    EXPECT_EQ(end().at("unsafe_moves"), 0);
}

TEST_F(ByHand, NothingMovesWithoutThat) {
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "part"});
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.type("yes\n");
    ASSERT_TRUE(terminal.wait_for("(Enter: stop): ")) << terminal.said;
    terminal.type("\n");
    EXPECT_EQ(terminal.wait(), 3);
    EXPECT_THAT(terminal.said, HasSubstr("the probe was not seen to close and to open; nothing has moved"));
    EXPECT_EQ(end().at("moves"), 0);
}

TEST_F(ByHand, CheckAsksForItToo) {
    for (const bool presses : {true, false}) {
        TypedAt terminal(folder_, {"check", "part.yaml"});
        ASSERT_TRUE(terminal.wait_for("(Enter: go on without): ")) << terminal.said;
        presses ? machine_->send(SIGUSR1) : terminal.type("\n");
        EXPECT_EQ(terminal.wait(), presses ? 0 : 2) << terminal.said;
        EXPECT_THAT(terminal.said, HasSubstr(presses ? "probe works: yes" : "probe works: not shown"));
    }
    EXPECT_EQ(end().at("moves"), 0);
}

}  // namespace
}  // namespace palpate::probe_life_test
