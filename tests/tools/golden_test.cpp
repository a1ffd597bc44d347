// The same configuration and seed give the same bytes as they did when tests/data/golden.txt was written. Whoever means to change what a
// run does writes it anew, and says why:
//     PALPATE_WRITE_GOLDEN=1 build/dev/tests/tools/tools_machine_tests --gtest_filter='Golden.*'
#include <cstdlib>
#include <map>
#include <sstream>

#include "devices/session/journal.h"
#include "tests/tools/session_rig.h"

namespace palpate::golden_test {
namespace {

const fs::path kRecord = fs::path(PALPATE_TEST_DATA) / "golden.txt";

// By session and file: length and digest.
using Record = std::map<std::string, std::string>;

Record read_record() {
    Record record;
    std::ifstream in(kRecord);
    for (std::string line; std::getline(in, line);) {
        const std::size_t space = line.find(' ');
        if (!line.starts_with('#') && space != std::string::npos) record[line.substr(0, space)] = line.substr(space + 1);
    }
    return record;
}

void write_record(const Record& record) {
    std::ofstream out(kRecord);
    out << "# Session and file, its length in bytes, its digest. Written by tests/tools/golden_test.cpp.\n";
    for (const auto& [file, sum] : record) out << file << ' ' << sum << '\n';
}

class Golden : public SessionRig {
protected:
    void note(const std::string& session) {
        for (const char* file : {"config.yaml", "mesh.ply", "touches.csv", "journal.jsonl"}) {
            if (!fs::exists(folder_ / session / file)) continue;
            std::string text = read(fs::path(session) / file);
            // The last line of a journal tells how long the planner took.
            if (std::string(file) == "journal.jsonl") text.resize(text.rfind('\n', text.size() - 2) + 1);
            seen_[session + "/" + file] = std::to_string(text.size()) + " " + digest(text);
        }
    }
    void simulate(const std::string& session, const std::string& object, const std::vector<std::string>& settings) {
        std::vector<std::string> words = {"simulate", std::string(PALPATE_SOURCE_DIR) + "/config/examples/" + object + ".yaml", "-o",
                                          session, "--no-picture"};
        for (const std::string& setting : settings) {
            words.emplace_back("--set");
            words.push_back(setting);
        }
        ASSERT_EQ(run(words), 0) << session << ": " << read("out.txt");
        note(session);
    }

    Record seen_;
};

TEST_F(Golden, SessionsGiveTheBytesThatAreRecorded) {
    for (const std::string object : {"torus", "box", "genus2", "two_components"}) {
        const std::string epsilon = "probing.epsilon=" + std::string(object == "torus" ? "0.1" : "0.15");
        simulate(object + "-default", object, {epsilon});
        simulate(object + "-adaptive", object, {epsilon, "probing.strategy=adaptive", "random_seed=7"});
        simulate(object + "-thesis", object, {epsilon, "probing.strategy=thesis"});
    }
    simulate("torus-walks", "torus", {"probing.epsilon=0.1", "probing.strategy.infer=none"});
    simulate("torus-coarse", "torus", {"probing.epsilon=0.4"});
    simulate("genus2-sized", "genus2", {"probing.epsilon=0.2", "probing.sizing.radii_of_curvature=0.3", "probing.min_angle=25"});

    // A name that is no path on this computer: the journal tells it.
    write("machine.yaml", "grbl: {port: tty}\n  homing: run");
    PortMachine machine(port());
    ASSERT_EQ(run({"probe", "machine.yaml", "-o", "machine", "--yes", "--no-picture"}), 0) << read("out.txt");
    note("machine");

    if (std::getenv("PALPATE_WRITE_GOLDEN") != nullptr) return write_record(seen_);
    const Record expected = read_record();
    EXPECT_EQ(expected.size(), seen_.size());
    for (const auto& [file, sum] : seen_) {
        const auto found = expected.find(file);
        ASSERT_NE(found, expected.end()) << file;
        EXPECT_EQ(sum, found->second) << file;
    }
}

}  // namespace
}  // namespace palpate::golden_test
