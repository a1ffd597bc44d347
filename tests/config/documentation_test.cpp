// config/README.md and the examples against what the reader accepts.
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "config/key_docs.h"
#include "config/reader.h"
#include "config/writer.h"
#include "tests/config/support.h"

namespace palpate::documentation_test {
namespace {

std::string row(const KeyDoc& doc) {
    return "| `" + doc.key + "` | " + doc.type + " | " + (doc.unit.empty() ? "–" : doc.unit) + " | " + doc.default_value + " | " +
           doc.range + " | " + doc.meaning + " |";
}

TEST(Documentation, ReadmeHasExactlyTheRowsThatAreDeclared) {
    std::vector<std::string> expected;
    std::string all;
    for (const KeyDoc& doc : documented_keys()) {
        expected.push_back(row(doc));
        all += expected.back() + "\n";
    }
    std::vector<std::string> found;
    const std::string text = test::contents(std::filesystem::path(PALPATE_CONFIG_DIR) / "README.md");
    const std::size_t table = text.find("## Every key");
    ASSERT_NE(table, std::string::npos);
    std::istringstream readme(text.substr(table));
    for (std::string line; std::getline(readme, line);) {
        if (line.rfind("| `", 0) == 0) {
            found.push_back(line);
        }
    }
    EXPECT_EQ(found, expected) << "put these rows into config/README.md:\n" << all;
}

TEST(Documentation, EveryKeyIsDescribedOnceAndInFull) {
    std::set<std::string> keys;
    for (const KeyDoc& doc : documented_keys()) {
        EXPECT_TRUE(keys.insert(doc.key).second) << doc.key;
        EXPECT_FALSE(doc.type.empty() || doc.default_value.empty() || doc.range.empty() || doc.meaning.empty()) << doc.key;
    }
    for (const char* key : {"object.mesh", "object.shape.union.parts", "workspace.box.max", "probing.epsilon", "probing.strategy.refine",
                            "probing.seed_rays[].from", "random_seed"}) {
        EXPECT_EQ(keys.count(key), 1U) << key;
    }
}

TEST(Documentation, ExamplesAreRead) {
    std::set<std::string> names;
    for (const std::filesystem::path& file : test::example_files()) {
        const SessionConfig config = read_config(file);
        names.insert(file.filename().string());
        EXPECT_TRUE(config.object.has_value()) << file;
        EXPECT_FALSE(std::holds_alternative<AutoWorkspace>(config.workspace)) << file;
        EXPECT_EQ(config.probing.strategy, config.probing.reach ? Strategy{} : Strategy::adaptive()) << file;
        // So that the guarantees of planner/DESIGN.md, "Guarantees" apply.
        EXPECT_TRUE(!config.probing.reach || config.probing.epsilon <= 0.16 * *config.probing.reach) << file;
    }
    EXPECT_EQ(names, (std::set<std::string>{"box.yaml", "bunny.yaml", "genus2.yaml", "torus.yaml", "two_components.yaml"}));
}

TEST(Documentation, ExamplesOfMachinesAreRead) {
    for (const char* name : {"grbl.yaml", "modbus.yaml"}) {
        const SessionConfig config = read_config(std::filesystem::path(PALPATE_CONFIG_DIR) / "machines" / name);
        ASSERT_TRUE(config.machine) << name;
        EXPECT_EQ(std::holds_alternative<GrblSpec>(config.machine->connection), std::string(name) == "grbl.yaml");
        EXPECT_FALSE(config.object) << "which a real machine has itself, and which another folder has not: " << name;
        EXPECT_GT(config.traits().touch_error, 0);
    }
    const SessionConfig external = read_config(std::filesystem::path(PALPATE_CONFIG_DIR) / "machines/external.yaml");
    EXPECT_EQ(std::get<ExternalSpec>(external.machine->connection).command.front(), "python3");
    const SessionConfig linuxcnc = read_config(std::filesystem::path(PALPATE_CONFIG_DIR) / "machines/linuxcnc.yaml");
    EXPECT_EQ(std::get<ExternalSpec>(linuxcnc.machine->connection).address, "127.0.0.1:5010");
}

// The block in the README is a file that works as it stands.
TEST(Documentation, ReadmesExampleIsRead) {
    const std::string readme = test::contents(std::filesystem::path(PALPATE_CONFIG_DIR) / "README.md");
    const std::string fence = "```yaml\n";
    const std::size_t begin = readme.find(fence);
    ASSERT_NE(begin, std::string::npos);
    const std::size_t end = readme.find("```", begin + fence.size());
    const test::TemporaryFolder folder;
    const SessionConfig config = read_config(folder.write("example.yaml", readme.substr(begin + fence.size(), end - begin - fence.size())));
    EXPECT_EQ(config.probing.epsilon, 0.05);
    EXPECT_EQ(config.probing.seed_rays.size(), 1U);
}

}  // namespace
}  // namespace palpate::documentation_test
