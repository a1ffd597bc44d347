// What comments and documents refer to exists: files, and headings of the design documents.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace palpate::references_test {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = PALPATE_SOURCE_DIR;

struct Text {
    std::string file;  // from the root
    std::string content;
};

const std::vector<Text>& texts() {
    static const std::vector<Text> all = [] {
        std::vector<Text> found;
        const auto add = [&](const fs::path& path) {
            static const std::set<std::string> kKinds = {".h", ".cc", ".cpp", ".md", ".txt", ".yaml", ".cff", ""};
            if (!fs::is_regular_file(path) || !kKinds.contains(path.extension().string())) return;
            std::ifstream in(path);
            found.push_back({fs::relative(path, kSource).string(), {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()}});
        };
        for (const auto& entry : fs::directory_iterator(kSource)) add(entry.path());
        for (const char* top : {"planner", "devices", "sim", "config", "tools", "tests"}) {
            for (const auto& entry : fs::recursive_directory_iterator(kSource / top)) {
                if (entry.path().string().find("/data/") == std::string::npos &&
                    entry.path().string().find("/corpora/") == std::string::npos)
                    add(entry.path());
            }
        }
        return found;
    }();
    return all;
}

// Calls visit(file, match) for every match in all texts but this one.
template <typename Visit>
void for_each_match(const std::regex& pattern, const Visit& visit) {
    for (const Text& text : texts()) {
        if (text.file == "tests/tools/references_test.cpp") continue;
        for (std::sregex_iterator it(text.content.begin(), text.content.end(), pattern); it != std::sregex_iterator(); ++it) {
            visit(text.file, *it);
        }
    }
}

std::set<std::string> headings_of(const fs::path& document) {
    std::set<std::string> headings;
    std::ifstream in(document);
    for (std::string line; std::getline(in, line);) {
        const std::size_t text = line.find_first_not_of('#');
        if (line.starts_with('#') && text != std::string::npos) headings.insert(line.substr(text + 1));
    }
    return headings;
}

TEST(References, DesignIsCitedByFileAndHeading) {
    std::size_t cited = 0;
    // A quotation may go on in the next line of a comment.
    const std::regex pattern("([a-z]+/(?:DESIGN|FACTS)\\.md),[ \n/]*\"([^\"]+)\"");
    for_each_match(pattern, [&](const std::string& file, const std::smatch& match) {
        ++cited;
        EXPECT_TRUE(headings_of(kSource / match[1].str()).contains(match[2])) << file << ": " << match[0];
    });
    EXPECT_GT(cited, 60U) << "the test looks at the wrong files";
    for_each_match(
        std::regex("(DESIGN|DEVICES|FACTS) (section|chapter)|\\bDEVICES\\b"),
        [](const std::string& file, const std::smatch& match) { ADD_FAILURE() << file << ": " << match[0] << " names no heading"; });
}

TEST(References, LinksInDocumentsLeadSomewhere) {
    for_each_match(std::regex("\\]\\(([^)#: ]*)(#[^) ]*)?\\)"), [](const std::string& file, const std::smatch& match) {
        if (!file.ends_with(".md")) return;
        const fs::path document = match[1].length() > 0 ? fs::path(file).parent_path() / match[1].str() : fs::path(file);
        ASSERT_TRUE(fs::exists(kSource / document)) << file << ": " << match[0];
        if (match[2].length() == 0) return;
        const auto anchor_of = [](const std::string& heading) {
            std::string anchor = "#";
            for (const char c : heading) {
                if (c == ' ' || c == '-') anchor += '-';
                if (std::isalnum(static_cast<unsigned char>(c)) != 0) anchor += static_cast<char>(std::tolower(c));
            }
            return anchor;
        };
        const std::set<std::string> headings = headings_of(kSource / document);
        EXPECT_TRUE(std::ranges::any_of(headings, [&](const std::string& h) { return anchor_of(h) == match[2].str(); }))
            << file << ": " << match[0];
    });
}

TEST(References, SourceFilesThatAreNamedExist) {
    std::set<std::string> names;
    for (const Text& text : texts()) names.insert(fs::path(text.file).filename().string());
    for_each_match(std::regex("(?:^|[^\\w/.<-])((?:planner|devices|sim|config|tools|tests)/[\\w/]+\\.(?:h|cc|cpp|md))\\b"),
                   [](const std::string& file, const std::smatch& match) {
                       if (file == "CHANGELOG.md") return;  // tells of the past
                       EXPECT_TRUE(fs::exists(kSource / match[1].str())) << file << ": " << match[1];
                   });
    // By its name alone, in a comment: "(advancing_front.h)".
    for_each_match(std::regex("//[^\n]*[ (`]([a-z]\\w+\\.h)\\b"), [&](const std::string& file, const std::smatch& match) {
        EXPECT_TRUE(names.contains(match[1])) << file << ": " << match[1];
    });
}

}  // namespace
}  // namespace palpate::references_test
