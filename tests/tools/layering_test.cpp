// The arrows of planner/DESIGN.md, "Folders and arrows", read off the includes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace palpate::layering_test {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = PALPATE_SOURCE_DIR;

// What a folder may include besides itself. A folder stands for those below it, unless they have rows of their own.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"planner", {}},
    {"planner/delaunay", {"planner"}},
    {"planner/inference", {"planner", "planner/delaunay"}},
    {"planner/plausibility", {"planner", "planner/delaunay", "planner/inference"}},
    {"planner/motion", {"planner", "planner/delaunay", "planner/inference"}},
    {"planner/tolerance", {"planner", "planner/curved"}},
    {"planner/loop", {"planner", "planner/delaunay", "planner/inference", "planner/plausibility", "planner/motion", "planner/tolerance"}},
    {"planner/part", {"planner"}},
    {"planner/curved", {"planner"}},
    {"planner/baselines", {"planner"}},
    {"devices", {"planner"}},
    {"devices/calibration", {"devices", "planner"}},
    {"devices/decorators", {"devices", "planner"}},
    {"devices/external", {"devices", "devices/posix", "planner"}},
    {"devices/grbl", {"devices", "devices/posix", "planner"}},
    {"devices/modbus", {"devices", "devices/posix", "planner"}},
    {"devices/posix", {"devices", "planner"}},
    {"devices/session", {"devices", "devices/calibration", "devices/decorators", "planner"}},
    {"sim", {"sim/objects", "sim/probe", "devices", "planner"}},
    {"sim/objects", {"planner"}},
    {"sim/probe", {"devices/calibration", "planner"}},
    {"sim/tool", {"sim/objects", "planner"}},
    {"sim/machines", {"sim", "sim/objects", "sim/probe", "devices", "devices/modbus", "planner"}},
    {"config",
     {"sim/objects", "sim/probe", "devices", "devices/calibration", "devices/grbl", "devices/modbus", "devices/posix", "devices/session",
      "planner"}},
    {"tools/terminal", {"devices", "devices/session", "planner"}},
    {"tools/formats", {"planner"}},
    {"tools/view", {"planner"}},
    {"tools", {"tools/terminal",      "tools/formats",      "tools/view",       "config",       "sim",
               "sim/objects",         "sim/probe",          "sim/tool",         "sim/machines", "devices",
               "devices/calibration", "devices/decorators", "devices/external", "devices/grbl", "devices/modbus",
               "devices/posix",       "devices/session",    "planner",          "planner/part", "planner/curved",
               "planner/baselines"}},
};
// The one door from a top folder into the room below it.
const std::map<std::string, std::set<std::string>> kDoors = {
    {"planner/probe_surface.cc", {"planner/loop"}},
};
constexpr std::size_t kMostSources = 15;  // in a folder; tools/ has one for every command

// What a line includes; empty if it is no include.
std::string included_path(const std::string& line) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#' || line.find("include", hash) == std::string::npos) return {};
    const std::size_t open = line.find_first_of("<\"", hash);
    if (open == std::string::npos) return {};
    return line.substr(open + 1, line.find_first_of(">\"", open + 1) - open - 1);
}

bool is_source(const fs::path& file) { return file.extension() == ".h" || file.extension() == ".cc"; }
bool is_ours(const std::string& path) {
    const std::string top = path.substr(0, path.find('/'));
    return top == "tests" || kMayInclude.contains(top);
}
std::string folder_of(const std::string& path) { return fs::path(path).parent_path().string(); }

// The row that a folder falls under.
std::string row_of(std::string folder) {
    while (!kMayInclude.contains(folder) && !folder.empty()) folder = folder_of(folder);
    return folder;
}
bool is_within(const std::string& path, const std::string& folder) { return path == folder || path.starts_with(folder + "/"); }

struct Include {
    std::string from;  // file
    std::string to;
    int line = 0;

    [[nodiscard]] std::string text() const { return from + ":" + std::to_string(line) + " includes " + to; }
};

const std::vector<Include>& includes() {
    static const std::vector<Include> all = [] {
        std::vector<Include> found;
        for (const char* top : {"planner", "devices", "sim", "config", "tools"}) {
            for (const auto& entry : fs::recursive_directory_iterator(kSource / top)) {
                if (!is_source(entry.path())) continue;
                std::ifstream file(entry.path());
                std::string line;
                for (int number = 1; std::getline(file, line); ++number) {
                    const std::string to = included_path(line);
                    if (is_ours(to)) found.push_back({fs::relative(entry.path(), kSource).string(), to, number});
                }
            }
        }
        return found;
    }();
    return all;
}

TEST(Layering, FoldersIncludeOnlyWhatTheyMay) {
    EXPECT_GT(includes().size(), 500U) << "the test looks at the wrong folder";
    for (const Include& include : includes()) {
        EXPECT_TRUE(fs::exists(kSource / include.to)) << include.text() << ", which does not exist";
        const std::string from = row_of(folder_of(include.from));
        const std::string to = row_of(folder_of(include.to));
        ASSERT_FALSE(from.empty() || to.empty()) << include.text();
        if (from == to || kMayInclude.at(from).contains(to)) continue;
        const auto door = kDoors.find(include.from);
        EXPECT_TRUE(door != kDoors.end() && door->second.contains(to)) << include.text() << ", but " << from << " may not know " << to;
    }
}

// An internal header is for the folder that `internal` lies in, and those below it.
TEST(Layering, InternalHeadersStayInTheirFolder) {
    for (const Include& include : includes()) {
        const std::size_t at = include.to.find("/internal/");
        if (at == std::string::npos) continue;
        EXPECT_TRUE(is_within(folder_of(include.from), include.to.substr(0, at))) << include.text();
    }
}

// Of files, whatever folders they lie in.
TEST(Layering, NoHeaderIncludesItselfInACircle) {
    std::map<std::string, std::set<std::string>> open;
    for (const Include& include : includes()) {
        if (fs::path(include.from).extension() == ".h") open[include.from].insert(include.to);
    }
    // Headers that include nothing that is still open go, until nothing changes.
    for (bool changes = true; changes;) {
        changes = false;
        for (auto it = open.begin(); it != open.end();) {
            const bool is_free = std::ranges::none_of(it->second, [&](const std::string& to) { return open.contains(to); });
            it = is_free ? open.erase(it) : std::next(it);
            changes |= is_free;
        }
    }
    std::vector<std::string> circle;
    for (const auto& [file, to] : open) circle.push_back(file);
    EXPECT_THAT(circle, testing::IsEmpty());
}

// Of rows: an arrow both ways would be one.
TEST(Layering, NoTwoFoldersKnowEachOther) {
    std::map<std::string, std::set<std::string>> arrows;
    for (const Include& include : includes()) {
        const std::string from = row_of(folder_of(include.from));
        const std::string to = row_of(folder_of(include.to));
        if (from != to && !kDoors.contains(include.from)) arrows[from].insert(to);
    }
    for (const auto& [from, to] : arrows) {
        for (const std::string& other : to) EXPECT_FALSE(arrows[other].contains(from)) << from << " and " << other << " include each other";
    }
}

TEST(Layering, FoldersAreSmall) {
    std::map<std::string, std::size_t> sources;
    for (const char* top : {"planner", "devices", "sim", "config"}) {
        for (const auto& entry : fs::recursive_directory_iterator(kSource / top)) {
            if (entry.path().extension() == ".cc") ++sources[fs::relative(entry.path(), kSource).parent_path().string()];
        }
    }
    for (const auto& [folder, count] : sources) EXPECT_LE(count, kMostSources) << folder;
}

TEST(Layering, PublicHeadersDoNotShowCgal) {
    const std::set<std::string> rooms = {"planner/delaunay", "planner/inference", "planner/plausibility",
                                         "planner/motion",   "planner/tolerance", "planner/loop"};
    for (const char* top : {"planner", "devices", "sim", "config"}) {
        for (const auto& entry : fs::recursive_directory_iterator(kSource / top)) {
            const std::string file = fs::relative(entry.path(), kSource).string();
            if (entry.path().extension() != ".h" || file.find("/internal/") != std::string::npos || rooms.contains(folder_of(file)))
                continue;
            std::ifstream in(entry.path());
            const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
            EXPECT_EQ(text.find("#include <CGAL"), std::string::npos) << file;
        }
    }
}

}  // namespace
}  // namespace palpate::layering_test
