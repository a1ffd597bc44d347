// Whose folder it is, and what is never overwritten.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/session_rig.h"

namespace palpate::folder_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class SessionFolders : public SessionRig {
protected:
    void write_torus(const std::string& name, const std::string& more = "") const {
        std::ofstream(folder_ / name) << "object: {shape: {torus: {major: 1, minor: 0.4}}}\nprobing: {epsilon: 0.3}\n" << more;
    }
};

TEST_F(SessionFolders, ASimulationReplacesNoJournalEvenWhenForced) {
    write_torus("torus.yaml");
    PortMachine machine(port());
    Process session = start(probe("part"));
    wait_for_probes(machine, 20);
    EXPECT_EQ(run({"simulate", "torus.yaml", "-o", "part", "--force"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("another process works in it"));
    EXPECT_EQ(session.wait(), 0);
    const std::string journal = read("part/journal.jsonl");
    const std::string config = read("part/config.yaml");
    EXPECT_EQ(run({"simulate", "torus.yaml", "-o", "part", "--force"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("never overwritten"));
    EXPECT_EQ(read("part/journal.jsonl"), journal);
    EXPECT_EQ(read("part/config.yaml"), config);
    EXPECT_EQ(run({"resume", "part", "--replay"}), 0) << read("out.txt");
}

TEST_F(SessionFolders, WhatARunReadsItDoesNotOverwrite) {
    write_torus("config.yaml");
    const std::string config = read("config.yaml");
    EXPECT_EQ(run({"simulate", "config.yaml", "-o", ".", "--force"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("config.yaml: is read by this run"));
    EXPECT_EQ(read("config.yaml"), config);
    // A mesh by another name for the same file.
    fs::create_directory(folder_ / "out");
    fs::copy_file(std::string(PALPATE_TEST_DATA) + "/cases/asc_name_facet.stl", folder_ / "mesh.stl");
    fs::create_hard_link(folder_ / "mesh.stl", folder_ / "out/mesh.ply");
    std::ofstream(folder_ / "part.yaml") << "object: {mesh: mesh.stl}\nprobing: {epsilon: 6}\n";
    const std::string mesh = read("mesh.stl");
    EXPECT_EQ(run({"simulate", "part.yaml", "-o", "out", "--force"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("mesh.stl: is read by this run"));
    EXPECT_EQ(read("mesh.stl"), mesh);
}

TEST_F(SessionFolders, ProbeTakesAwayNothingThatItDidNotWrite) {
    fs::create_directory(folder_ / "mine");
    fs::rename(folder_ / "part.yaml", folder_ / "mine/config.yaml");
    const std::string config = read("mine/config.yaml");
    EXPECT_EQ(run({"probe", "mine/config.yaml", "-o", "mine"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("is read by this run"));
    EXPECT_EQ(read("mine/config.yaml"), config);
    fs::create_directory(folder_ / "other");
    std::ofstream(folder_ / "other/config.yaml") << "somebody else's";
    EXPECT_EQ(run({"probe", "mine/config.yaml", "-o", "other"}), 2);
    EXPECT_EQ(read("other/config.yaml"), "somebody else's");
    EXPECT_EQ(run({"probe", "mine/config.yaml", "-o", "a/b/c"}), 3) << "no port";
    EXPECT_FALSE(fs::exists(folder_ / "a")) << "nor do folders stay that it made";
}

TEST_F(SessionFolders, TwoRunsIntoOneFolderAreNotMixed) {
    write_torus("torus.yaml");
    Process first = start({"simulate", "torus.yaml", "-o", "s", "--set", "probing.epsilon=0.03"});
    while (!fs::exists(folder_ / "s")) std::this_thread::sleep_for(1ms);
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(run({"simulate", "torus.yaml", "-o", "s"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("another process works in it"));
    first.send(SIGINT);
    EXPECT_EQ(first.wait(), 3);
    EXPECT_FALSE(fs::exists(folder_ / "s")) << "nothing is left of a simulation that was stopped";
    EXPECT_EQ(run({"simulate", "torus.yaml", "-o", "s"}), 0) << read("out.txt");
}

TEST_F(SessionFolders, AFolderThatIsDeletedIsNoticedAtTheNextLine) {
    PortMachine machine(port());
    Process session = start(probe("part"));
    wait_for_probes(machine, 20);
    fs::remove_all(folder_ / "part");
    EXPECT_EQ(session.wait(), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr("was deleted while the session ran"));
    EXPECT_LT(machine.probes(), 200U);
    expect_safe(machine);
}

TEST_F(SessionFolders, AFolderThatIsMovedIsResumedWhereItIs) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("whole")), 0) << read("out.txt");
    Process session = start(probe("part"));
    const std::uint64_t before = machine.probes();
    wait_for_probes(machine, before + 20);
    fs::rename(folder_ / "part", folder_ / "a b's");
    EXPECT_EQ(session.wait(), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr("was moved while the session ran"));
    EXPECT_EQ(run(resume("a b's")), 0) << read("out.txt");
    EXPECT_EQ(read("a b's/mesh.ply"), read("whole/mesh.ply"));
    expect_safe(machine);
}

TEST_F(SessionFolders, HintsCanBeCopiedIntoAShell) {
    PortMachine machine(port());
    Process session = start(probe("it's one"));
    wait_for_probes(machine, 20);
    session.send(SIGINT);
    EXPECT_EQ(session.wait(), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr(R"(palpate resume 'it'\''s one')"));
}

TEST_F(SessionFolders, TheJournalMayBeNamedInPlaceOfItsFolder) {
    PortMachine machine(port());
    Process session = start(probe("part"));
    wait_for_probes(machine, 20);
    session.send(SIGINT);
    EXPECT_EQ(session.wait(), 3);
    EXPECT_EQ(run(resume("part/journal.jsonl")), 0) << read("out.txt");
    EXPECT_TRUE(fs::exists(folder_ / "part/mesh.ply"));
}

TEST_F(SessionFolders, AnotherVirtualMachineDoesNotTakeALinkOver) {
    std::ofstream(folder_ / "part.yaml", std::ios::app) << "object: {shape: {sphere: {radius: 5}}}\n";
    fs::create_directory(folder_ / "vm");
    Process first(folder_ / "vm", {"vm", "../part.yaml", "--grbl", port().string(), "--fast"});
    for (int k = 0; k < 500 && !fs::exists(port()); ++k) std::this_thread::sleep_for(10ms);
    const fs::path leads_to = fs::read_symlink(port());
    EXPECT_EQ(run({"vm", "part.yaml", "--grbl", port().string(), "--fast"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("a virtual machine that runs"));
    EXPECT_EQ(fs::read_symlink(port()), leads_to);
    EXPECT_EQ(run(probe("s")), 0) << read("out.txt");
    // What one that was killed left is taken over.
    first.send(SIGKILL);
    (void)first.wait();
    Process second(folder_ / "vm", {"vm", "../part.yaml", "--grbl", port().string(), "--fast"});
    for (int k = 0; k < 500 && (!fs::exists(port()) || read("vm/out.txt").empty()); ++k) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(run(probe("t")), 0) << read("out.txt");
    second.send(SIGINT);
    EXPECT_EQ(second.wait(), 0);
}

TEST_F(SessionFolders, ABudgetCanBeRaisedAndTheSessionGoesOn) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("whole")), 0) << read("out.txt");
    const std::uint64_t whole = machine.probes();
    std::vector<std::string> words = probe("part");
    words.insert(words.end(), {"--set", "probing.budget.probes=40"});
    ASSERT_EQ(run(words), 4) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("palpate resume part --set probing.budget.probes=80"));
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=30"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("can be raised only"));
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=40"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("the session's budget already"));
    const std::string finished = read("part/journal.jsonl");
    EXPECT_EQ(run({"resume", "part", "--set", "probing.budget.probes=60"}), 2) << "nobody agreed";
    EXPECT_EQ(read("part/journal.jsonl"), finished);
    EXPECT_EQ(run({"resume", "part", "--replay"}), 4) << read("out.txt");
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=60"}), 4) << read("out.txt");
    const std::uint64_t before = machine.probes();
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=null"}), 0) << read("out.txt");
    EXPECT_LT(machine.probes() - before, whole) << "what was touched is not touched again";
    const auto triangles = [](const std::string& ply) { return ply.substr(ply.find("element vertex")); };
    EXPECT_EQ(triangles(read("part/mesh.ply")), triangles(read("whole/mesh.ply")));
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=9999"}), 2) << "it has come to its own end";
    const std::string mesh = read("part/mesh.ply");
    EXPECT_EQ(run({"resume", "part", "--replay"}), 0) << read("out.txt");
    EXPECT_EQ(read("part/mesh.ply"), mesh);
    expect_safe(machine);
}

TEST_F(SessionFolders, ALargerBudgetIsNoWayAroundTheConfigurationsDigest) {
    PortMachine machine(port());
    std::vector<std::string> words = probe("part");
    words.insert(words.end(), {"--set", "probing.budget.probes=400"});
    Process session = start(words);
    wait_for_probes(machine, 40);
    session.send(SIGINT);
    ASSERT_EQ(session.wait(), 3);
    std::string config = read("part/config.yaml");
    config.replace(config.find("retract: 0.2"), 12, "retract: 0.3");
    std::ofstream(folder_ / "part/config.yaml") << config;
    const std::uint64_t moves = machine.audit().moves;
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=500"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("was changed since the session began"));
    EXPECT_EQ(machine.audit().moves, moves);
}

TEST_F(SessionFolders, ADamageBeforeABudgetWasRaisedIsSalvagedToo) {
    PortMachine machine(port());
    std::vector<std::string> words = probe("part");
    words.insert(words.end(), {"--set", "probing.budget.probes=40"});
    ASSERT_EQ(run(words), 4) << read("out.txt");
    ASSERT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=60"}), 4) << read("out.txt");
    std::string journal = read("part/journal.jsonl");
    std::size_t line = 0;
    for (int k = 0; k < 20; ++k) line = journal.find('\n', line) + 1;
    journal[line + 20] ^= 1;
    std::ofstream(folder_ / "part/journal.jsonl", std::ios::binary) << journal;
    words = resume("part");
    words.emplace_back("--salvage");
    EXPECT_EQ(run(words), 4) << read("out.txt");
    EXPECT_EQ(run({"resume", "part", "--yes", "--set", "probing.budget.probes=null"}), 0) << read("out.txt");
    expect_safe(machine);
}

TEST_F(SessionFolders, ADamagedJournalGoesOnFromItsLastGoodLine) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("whole")), 0) << read("out.txt");
    Process session = start(probe("part"));
    const std::uint64_t before = machine.probes();
    wait_for_probes(machine, before + 60);
    session.send(SIGINT);
    ASSERT_EQ(session.wait(), 3);
    std::string journal = read("part/journal.jsonl");
    std::size_t line = 0;
    for (int k = 0; k < 30; ++k) line = journal.find('\n', line) + 1;
    journal[line + 20] ^= 1;
    std::ofstream(folder_ / "part/journal.jsonl", std::ios::binary) << journal;
    EXPECT_EQ(run(resume("part")), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("journal.jsonl:31: "));
    EXPECT_THAT(read("out.txt"), HasSubstr("--salvage"));
    EXPECT_EQ(read("part/journal.jsonl"), journal) << "nothing is cut off unasked";
    std::vector<std::string> words = resume("part");
    words.emplace_back("--salvage");
    machine.move_out_by_hand();
    EXPECT_EQ(run(words), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("30 line(s) are left"));
    EXPECT_EQ(read("part/journal.damaged1.jsonl"), journal);
    EXPECT_EQ(read("part/mesh.ply"), read("whole/mesh.ply"));
    expect_safe(machine);
}

}  // namespace
}  // namespace palpate::folder_test
