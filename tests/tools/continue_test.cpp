// `palpate continue`, as a user runs it: after a simulation, after a session on a machine, and after one that was stopped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/session_rig.h"
#include "tools/earlier_session.h"

namespace palpate::continue_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class Continue : public SessionRig {
protected:
    Continue() { std::ofstream(folder_ / "ball.yaml") << "object: {shape: {sphere: {radius: 5}}}\nprobing: {epsilon: 1.2}\n"; }
    [[nodiscard]] Json summary(const std::string& session) const { return Json::parse(read(session + "/summary.json")); }
    [[nodiscard]] std::vector<std::string> from(const std::string& session, const std::string& to,
                                                std::vector<std::string> more = {}) const {
        std::vector<std::string> words = {"continue", session, "-o", to, "--no-picture", "--yes"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
};

TEST_F(Continue, ASimulationGoesOn) {
    ASSERT_EQ(run({"simulate", "ball.yaml", "-o", "a", "--no-picture"}), 0) << read("out.txt");
    const std::string before = read("a/touches.csv") + read("a/config.yaml");
    ASSERT_EQ(run(from("a", "b", {"--tolerance", "0.005"})), 0) << read("out.txt");
    EXPECT_EQ(read("a/touches.csv") + read("a/config.yaml"), before);
    EXPECT_EQ(read("b/earlier.csv"), read("a/touches.csv"));
    EXPECT_EQ(summary("b").at("earlier").at("checked"), 3);
    EXPECT_EQ(summary("b").at("tolerance").at("wanted"), 0.005);
    EXPECT_LT(summary("b").at("probes").at("total"), summary("a").at("probes").at("total"));
    EXPECT_GT(summary("b").at("samples"), summary("a").at("samples"));
    // And on, from what both touched.
    ASSERT_EQ(run(from("b", "c", {"--epsilon", "0.9"})), 0) << read("out.txt");
    EXPECT_EQ(summary("c").at("earlier").at("touches"), parse_touches(read("b/touches.csv"), "").size());
    EXPECT_EQ(summary("c").at("epsilon"), 0.9);
    // The folder is a session like any other: the same again, from its own configuration.
    ASSERT_EQ(run({"simulate", "c/config.yaml", "-o", "d", "--no-picture"}), 0) << read("out.txt");
    EXPECT_EQ(read("d/mesh.ply"), read("c/mesh.ply"));
    EXPECT_EQ(read("d/touches.csv"), read("c/touches.csv"));
}

TEST_F(Continue, InABoxAlone) {
    ASSERT_EQ(run({"simulate", "ball.yaml", "-o", "a", "--no-picture"}), 0) << read("out.txt");
    ASSERT_EQ(run(from("a", "b", {"--epsilon", "0.6", "--box", "3,-2,-2", "6,2,2"})), 0) << read("out.txt");
    std::size_t near = 0;
    std::size_t far = 0;
    for (const EarlierTouch& touch : parse_touches(read("b/touches.csv"), "b")) (touch.position.x() > 1 ? near : far) += 1;
    EXPECT_GT(near, far);
    EXPECT_EQ(summary("b").at("epsilon"), 1.2);
}

TEST_F(Continue, WhatCannotBeGoneOnFromIsRefusedWithAReason) {
    ASSERT_EQ(run({"simulate", "ball.yaml", "-o", "a", "--no-picture"}), 0) << read("out.txt");
    const auto refused = [&](const std::vector<std::string>& words, const std::string& why) {
        EXPECT_EQ(run(words), 2);
        EXPECT_THAT(read("out.txt"), HasSubstr(why));
    };
    refused(from("nowhere", "b"), "nowhere: holds no config.yaml; give the folder of a session");
    refused(from("a", "a"), "is read by this run");
    refused(from("a", "b", {"--box", "0,0,0", "1,1,1"}), "--box: says where, but not what");
    refused(from("a", "b", {"--epsilon", "1", "--box", "2,2,2", "1,1,1"}), "--box: the second corner is not above");
    refused(from("a", "b", {"--tolerance", "2"}), "tolerance must be below epsilon");
    refused(from("a", "b", {"--set", "probing.strategy.infer=none"}), "infer: none concludes nothing from earlier touches");
    std::ofstream(folder_ / "a/touches.csv", std::ios::app) << "9,1,2,x,4,5,6,crossing,\n";
    refused(from("a", "b"), "z is \"x\"; allowed: a finite number (mm)");
    EXPECT_FALSE(fs::exists(folder_ / "b"));
}

TEST_F(Continue, ASessionOnAMachineGoesOnAndIsResumed) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("a")), 0) << read("out.txt");
    const std::uint64_t first = machine.probes();
    ASSERT_EQ(run(from("a", "b", {"--epsilon", "1.5"})), 0) << read("out.txt");
    EXPECT_EQ(summary("b").at("earlier").at("checked"), 3);
    EXPECT_LT(machine.probes() - first, 3 * first);
    // Killed and resumed it leaves the same.
    Process process = start(from("a", "c", {"--epsilon", "1.5"}));
    wait_for_probes(machine, machine.probes() + 40);
    process.send(SIGKILL);
    EXPECT_EQ(process.wait(), 128 + SIGKILL);
    ASSERT_EQ(run(resume("c")), 0) << read("out.txt");
    EXPECT_EQ(read("c/mesh.ply"), read("b/mesh.ply"));
    expect_safe(machine);
}

// As the program itself suggests.
TEST_F(Continue, ItsBudgetCanBeRaised) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("a")), 0) << read("out.txt");
    ASSERT_EQ(run(from("a", "b", {"--epsilon", "1.2", "--set", "probing.budget.probes=30"})), 4) << read("out.txt");
    std::vector<std::string> raised = resume("b");
    raised.insert(raised.end(), {"--set", "probing.budget.probes=2000"});
    EXPECT_EQ(run(raised), 0) << read("out.txt");
    ASSERT_EQ(run(from("a", "c", {"--epsilon", "1.2"})), 0) << read("out.txt");
    EXPECT_EQ(read("b/mesh.ply").substr(read("b/mesh.ply").find("element")), read("c/mesh.ply").substr(read("c/mesh.ply").find("element")));
    expect_safe(machine);
}

TEST_F(Continue, NothingIsLostOfASessionThatWentOnAndWasStopped) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("a")), 0) << read("out.txt");
    Process process = start(from("a", "b", {"--epsilon", "0.8"}));
    wait_for_probes(machine, machine.probes() + 60);
    process.send(SIGINT);
    ASSERT_EQ(process.wait(), 3) << read("out.txt");
    machine.move_out_by_hand();
    ASSERT_EQ(run(from("b", "c")), 0) << read("out.txt");
    EXPECT_GT(summary("c").at("earlier").at("touches"), summary("a").at("samples"));
    expect_safe(machine);
}

TEST_F(Continue, AStoppedSessionGoesOnFromItsJournal) {
    PortMachine machine(port());
    std::vector<std::string> words = probe("a");
    words.insert(words.end(), {"--set", "probing.epsilon=1"});
    Process process = start(words);
    wait_for_probes(machine, 250);
    process.send(SIGINT);
    ASSERT_EQ(process.wait(), 3) << read("out.txt");
    ASSERT_FALSE(fs::exists(folder_ / "a/touches.csv"));
    EXPECT_EQ(run(from("a", "b")), 2) << "a new session begins outside";
    EXPECT_FALSE(fs::exists(folder_ / "b"));
    machine.move_out_by_hand();
    ASSERT_EQ(run(from("a", "b")), 0) << read("out.txt");
    EXPECT_GT(summary("b").at("earlier").at("touches"), 20);
    // What was touched until then may all lie on one side.
    EXPECT_GE(summary("b").at("earlier").at("checked"), 1);
    EXPECT_EQ(summary("b").at("earlier").at("directions"), summary("b").at("earlier").at("checked"));
    EXPECT_EQ(summary("b").at("components"), 1);
    expect_safe(machine);
}

TEST_F(Continue, APartThatHasMovedStopsItBeforeAnythingIsWritten) {
    {
        PortMachine machine(port());
        ASSERT_EQ(run(probe("a")), 0) << read("out.txt");
    }
    VirtualToolOptions moved = axes();
    moved.origin += Vector(0.1, 0.1, 0.1);
    PortMachine machine(port(), {}, moved);
    EXPECT_EQ(run(from("a", "b")), 3) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("the object has moved since the earlier run"));
    EXPECT_FALSE(fs::exists(folder_ / "b/mesh.ply"));
    expect_safe(machine);
}

}  // namespace
}  // namespace palpate::continue_test
