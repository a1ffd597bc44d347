// The arrows of DESIGN section 8, read off the includes.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

namespace palpate {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"planner", {"planner"}},
    {"devices", {"devices", "planner"}},
    {"sim", {"sim", "devices", "planner"}},
    {"config", {"config", "sim", "devices", "planner"}},
    {"tools", {"tools", "config", "sim", "devices", "planner"}},
};

// What a line includes; empty if it is no include.
std::string included_path(const std::string& line) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#' || line.find("include", hash) == std::string::npos) return {};
    const std::size_t open = line.find_first_of("<\"", hash);
    if (open == std::string::npos) return {};
    return line.substr(open + 1, line.find_first_of(">\"", open + 1) - open - 1);
}

TEST(Layering, FoldersIncludeOnlyWhatTheyMay) {
    std::size_t ours = 0;
    for (const auto& [folder, allowed] : kMayInclude) {
        for (const auto& entry : fs::recursive_directory_iterator(fs::path(PALPATE_SOURCE_DIR) / folder)) {
            if (entry.path().extension() != ".h" && entry.path().extension() != ".cc") continue;
            std::ifstream file(entry.path());
            std::string line;
            for (int number = 1; std::getline(file, line); ++number) {
                const std::string included = included_path(line);
                const std::string target = included.substr(0, included.find('/'));
                if (target == "tests") ADD_FAILURE() << entry.path() << ":" << number << ": includes a test";
                if (!kMayInclude.contains(target)) continue;
                ++ours;
                EXPECT_TRUE(allowed.contains(target)) << entry.path() << ":" << number << ": " << folder << " may not include " << included;
                if (target != folder) {
                    EXPECT_EQ(included.find("internal/"), std::string::npos) << entry.path() << ":" << number << ": internal to " << target;
                }
                EXPECT_TRUE(fs::exists(fs::path(PALPATE_SOURCE_DIR) / included)) << entry.path() << ":" << number;
            }
        }
    }
    EXPECT_GT(ours, 50U) << "the test looks at the wrong folder";
}

TEST(Layering, PublicHeadersDoNotShowCgal) {
    for (const auto& [folder, allowed] : kMayInclude) {
        for (const auto& entry : fs::directory_iterator(fs::path(PALPATE_SOURCE_DIR) / folder)) {
            if (entry.path().extension() != ".h") continue;
            std::ifstream file(entry.path());
            const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
            EXPECT_EQ(text.find("#include <CGAL"), std::string::npos) << entry.path();
        }
    }
}

}  // namespace
}  // namespace palpate
