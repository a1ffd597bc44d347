// What somebody at a terminal sees, types and is asked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "devices/session/journal.h"
#include "planner/number_text.h"
#include "tests/tools/session_rig.h"
#include "tests/tools/terminal_rig.h"

namespace palpate::at_terminal_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Not;

class AtTerminal : public SessionRig {
protected:
    AtTerminal() { write("part.yaml", "grbl: {port: " + port().string() + "}\n  homing: run\n  probe_proof: first_touch"); }

    // A shell's, with the program's path as $0.
    [[nodiscard]] static std::vector<std::string> shell(const std::string& command) {
        return {"/bin/sh", "-c", command, PALPATE_EXECUTABLE};
    }
};

TEST_F(AtTerminal, WhatWasTypedBeforeTheQuestionIsNoAnswer) {
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "s"});
    terminal.type("yes\n");
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.watch(500ms);
    EXPECT_EQ(machine.audit().moves, 0U);
    terminal.type("no\n");
    EXPECT_EQ(terminal.wait(), 2);
    EXPECT_THAT(terminal.said, HasSubstr("not confirmed; nothing has moved"));
    EXPECT_EQ(machine.audit().moves, 0U);
    EXPECT_FALSE(fs::exists(folder_ / "s")) << "nothing is left of what never began";
}

TEST_F(AtTerminal, TheQuestionComesToTheTerminalWhereverOutputGoes) {
    PortMachine machine(port());
    TypedAt terminal(folder_, shell("\"$0\" probe part.yaml -o s >out 2>err </dev/null"));
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    for (const char* shown : {"machine    Grbl", "limits     (-15, -15, -15) mm to (15, 15, 15) mm", "feeds      ",
                              "workspace  around (0, 0, 0) mm", "first move to", "effort     about "}) {
        EXPECT_THAT(terminal.said, HasSubstr(shown));
    }
    EXPECT_EQ(machine.audit().moves, 0U);
    terminal.type("yes\n");
    EXPECT_EQ(terminal.wait(), 0) << read("err");
    EXPECT_THAT(read("err"), Not(HasSubstr("Type yes")));
    EXPECT_THAT(read("out"), HasSubstr("certificate"));
    expect_safe(machine);
}

TEST_F(AtTerminal, WhatWasTypedBlindlyIsNoAnswer) {
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "s"});
    terminal.type(TypedAt::kCtrlS);
    std::this_thread::sleep_for(1s);
    terminal.type("yes\n");
    std::this_thread::sleep_for(100ms);
    terminal.type(TypedAt::kCtrlQ);
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.watch(500ms);
    EXPECT_EQ(machine.audit().moves, 0U);
    terminal.type(TypedAt::kCtrlC);
    EXPECT_EQ(terminal.wait(), 3);
    EXPECT_THAT(terminal.said, HasSubstr("stopped at the question; nothing has moved"));
    EXPECT_EQ(machine.audit().moves, 0U);
}

TEST_F(AtTerminal, CtrlZAtTheQuestionAsksAgainAfterwards) {
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "s"});
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.type(TypedAt::kCtrlZ);
    ASSERT_TRUE(terminal.stops(5s));
    terminal.type("yes\n");
    terminal.said.clear();
    terminal.send(SIGCONT);
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.watch(300ms);
    EXPECT_EQ(machine.audit().moves, 0U);
    terminal.type("yes\n");
    EXPECT_EQ(terminal.wait(), 0) << terminal.said;
}

// As with `xterm -e palpate`: nobody could bring it back.
TEST_F(AtTerminal, WithoutAShellAboveCtrlZStopsNothing) {
    PortMachine machine(port());
    Process session = start(probe("s"));
    for (int k = 0; k < 5; ++k) {
        std::this_thread::sleep_for(100ms);
        session.send(SIGTSTP);
    }
    EXPECT_EQ(session.wait(), 0) << read("out.txt");
    expect_safe(machine);
}

// The first move is the one that was shown.
TEST_F(AtTerminal, TheMoveThatIsShownIsTheFirst) {
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "s"});
    ASSERT_TRUE(terminal.wait_for("let the machine move: ")) << terminal.said;
    terminal.type("yes\n");
    ASSERT_EQ(terminal.wait(), 0) << terminal.said;
    const Journal journal = read_journal(folder_ / "s/journal.jsonl");
    EXPECT_THAT(terminal.said, HasSubstr(point_text(journal.moves.front().target)));
}

TEST_F(AtTerminal, WithoutATerminalNobodyIsAskedAndNothingMoves) {
    PortMachine machine(port());
    EXPECT_EQ(run({"probe", "part.yaml", "-o", "s"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("--yes"));
    EXPECT_EQ(machine.audit().moves, 0U);
    EXPECT_FALSE(fs::exists(folder_ / "s"));
}

// Ctrl-S: the screen stands, the machine and a stop do not.
TEST_F(AtTerminal, AHeldTerminalHoldsUpNothing) {
    {
        PortMachine machine(port());
        TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "held", "--yes"});
        ASSERT_TRUE(terminal.wait_for("samples")) << terminal.said;
        terminal.type(TypedAt::kCtrlS);
        for (int k = 0; k < 2000 && !fs::exists(folder_ / "held/summary.json"); ++k) std::this_thread::sleep_for(10ms);
        EXPECT_TRUE(fs::exists(folder_ / "held/summary.json"));
        terminal.type(TypedAt::kCtrlQ);
        EXPECT_EQ(terminal.wait(), 0) << terminal.said;
        EXPECT_THAT(terminal.said, HasSubstr("certificate"));
    }
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "stopped", "--yes"});
    ASSERT_TRUE(terminal.wait_for("samples")) << terminal.said;
    terminal.type(TypedAt::kCtrlS);
    std::this_thread::sleep_for(50ms);
    const auto begin = std::chrono::steady_clock::now();
    terminal.send(SIGTERM);
    EXPECT_EQ(terminal.ended(), 3);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
    expect_safe(machine);
}

TEST_F(AtTerminal, APipeThatNobodyReadsHoldsUpNothing) {
    PortMachine machine(port());
    // The reader never reads; 64 KiB fit into the pipe.
    TypedAt terminal(folder_, shell("mkfifo full; sleep 100 <full & reader=$!; exec 2>full; head -c 65536 /dev/zero >&2; "
                                    "\"$0\" probe part.yaml -o s --yes >out; code=$?; kill $reader; exit $code"));
    EXPECT_EQ(terminal.wait(), 0) << terminal.said;
    EXPECT_THAT(read("out"), HasSubstr("certificate"));
}

TEST_F(AtTerminal, LinesFitTheWindowAndBarsStayApart) {
    PortMachine machine(port());
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "s", "--yes"}, 60);
    ASSERT_EQ(terminal.wait(), 0) << terminal.said;
    std::size_t certificate = terminal.said.find("certificate");
    ASSERT_NE(certificate, std::string::npos);
    std::istringstream lines(terminal.said.substr(terminal.said.find("samples        ")));
    for (std::string line; std::getline(lines, line);) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.find(' ', 30) == std::string::npos) continue;  // one word cannot be broken
        EXPECT_LE(line.size(), 60U) << line;
    }
}

TEST_F(AtTerminal, ProgressBeginsWithTheFirstMoveAndTellsTheTimeLeft) {
    VirtualGrblOptions options;
    PortMachine machine(port(), options);
    std::ofstream(folder_ / "part.yaml", std::ios::app) << "";
    TypedAt terminal(folder_, {"probe", "part.yaml", "-o", "s", "--yes", "--set", "probing.epsilon=0.5"}, 120);
    ASSERT_TRUE(terminal.wait_for(" samples")) << terminal.said;
    EXPECT_LT(read_journal(folder_ / "s/journal.jsonl").moves.size(), 40U);
    EXPECT_EQ(terminal.wait(), 0) << terminal.said;
    EXPECT_THAT(terminal.said, HasSubstr(" left"));
}

TEST_F(AtTerminal, EventsAreOneJsonObjectPerLineAndTheLastIsTheResult) {
    PortMachine machine(port());
    TypedAt terminal(folder_, shell("\"$0\" probe part.yaml -o s --yes --json >events 2>err"));
    ASSERT_EQ(terminal.wait(), 0) << read("err");
    std::ifstream events(folder_ / "events");
    nlohmann::json event;
    int progress = 0;
    for (std::string line; std::getline(events, line);) {
        event = nlohmann::json::parse(line);
        progress += event.at("event") == "progress";
    }
    EXPECT_GT(progress, 0);
    ASSERT_EQ(event.at("event"), "result");
    EXPECT_EQ(event.at("summary"), nlohmann::json::parse(read("s/summary.json")));

    TypedAt refused(folder_, shell("\"$0\" probe nowhere.yaml -o t --yes --json >events 2>err"));
    EXPECT_EQ(refused.wait(), 2);
    event = nlohmann::json::parse(read("events"));
    EXPECT_EQ(event.at("event"), "error");
    EXPECT_EQ(event.at("exit_code"), 2);
}

TEST_F(AtTerminal, QuietSaysNothingButTheResult) {
    PortMachine machine(port());
    TypedAt terminal(folder_, shell("\"$0\" probe part.yaml -o s --yes --quiet >out 2>err"));
    ASSERT_EQ(terminal.wait(), 0) << read("err");
    EXPECT_EQ(read("err"), "");
    EXPECT_THAT(read("out"), HasSubstr("certificate"));
}

}  // namespace
}  // namespace palpate::at_terminal_test
