// Damaged configurations: whatever is in the file, the reader returns or throws ConfigError.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <random>

#include "config/reader.h"
#include "config/writer.h"
#include "tests/config/support.h"

namespace palpate::fuzz_test {
namespace {

using Random = std::mt19937_64;
using namespace std::string_literals;

constexpr std::chrono::milliseconds kBudget{2000};

// What tends to hurt YAML readers and number parsers.
const std::array kTokens{"{"s,
                         "["s,
                         "}"s,
                         "]"s,
                         ": "s,
                         ":"s,
                         ", "s,
                         "- "s,
                         "? "s,
                         "\n"s,
                         "\n  "s,
                         "\t"s,
                         "&a "s,
                         "*a"s,
                         "<<: *a"s,
                         "!!str "s,
                         "!x "s,
                         "---\n"s,
                         "...\n"s,
                         "%YAML 3\n"s,
                         ".nan"s,
                         "-.inf"s,
                         "1e999"s,
                         "-0"s,
                         "0x1p3"s,
                         "null"s,
                         "~"s,
                         "\""s,
                         "'"s,
                         "\\x"s,
                         "|\n"s,
                         ">-\n"s,
                         "#"s,
                         "\0"s,
                         "\xff\xfe"s,
                         "\xef\xbb\xbf"s,
                         "\xc3"s,
                         "@"s,
                         "`"s,
                         "torus"s,
                         "union"s,
                         "parts"s,
                         "epsilon"s,
                         "thesis"s,
                         "18446744073709551616"s,
                         "1e-400"s,
                         "{a: [{b: c}]}"s};

std::size_t below(Random& random, std::size_t bound) { return bound == 0 ? 0 : static_cast<std::size_t>(random() % bound); }

void mutate(std::string& text, const std::string& other, Random& random) {
    const std::size_t at = below(random, text.size() + 1);
    const std::size_t length = std::min(below(random, 40), text.size() - at);
    switch (random() % 6) {
        case 0:
            text.insert(at, 1, static_cast<char>(random() & 0xFFU));
            break;
        case 1:
            text.erase(at, length);
            break;
        case 2:
            text.insert(below(random, text.size() + 1), text.substr(at, length));
            break;
        case 3:
            text.replace(at, length, other.substr(below(random, other.size()), length));
            break;
        default:
            text.insert(at, kTokens[below(random, kTokens.size())]);
    }
}

// Reads; whatever is accepted also survives being written and read again.
void check(const test::TemporaryFolder& folder, const std::string& text, const std::vector<std::string>& overrides) {
    try {
        const SessionConfig config = read_config(folder.write("fuzz.yaml", text), overrides);
        const SessionConfig back = read_config(folder.write("again.yaml", write_config(config)));
        EXPECT_TRUE(test::identical(config, back)) << write_config(config);
    } catch (const ConfigError& error) {
        EXPECT_NE(std::string(error.what()).find(": "), std::string::npos) << error.what();
    }
}

TEST(Fuzz, DamagedExamplesThrowConfigErrorAndNothingElse) {
    const std::uint64_t seed = test::logged_seed();
    Random random(seed);
    const test::TemporaryFolder folder;
    std::vector<std::string> corpus;
    for (const std::filesystem::path& file : test::example_files()) {
        corpus.push_back(test::contents(file));
    }
    const auto end = std::chrono::steady_clock::now() + kBudget;
    while (std::chrono::steady_clock::now() < end) {
        std::string text = corpus[below(random, corpus.size())];
        for (std::size_t count = 1 + below(random, 4); count > 0; --count) {
            mutate(text, corpus[below(random, corpus.size())], random);
        }
        std::vector<std::string> overrides;
        if (random() % 4 == 0) {
            overrides.emplace_back("probing.strategy.refine=eager");
            mutate(overrides.back(), text, random);
        }
        SCOPED_TRACE("seed " + std::to_string(seed) + ", overrides " + (overrides.empty() ? "none" : overrides.front()) + ", text:\n" +
                     text);
        ASSERT_NO_FATAL_FAILURE(check(folder, text, overrides));
        ASSERT_FALSE(HasFailure());
    }
}

// Each of these has brought down a YAML reader somewhere.
TEST(Fuzz, HugeAndDeepTextsAreRefusedInBoundedTime) {
    const test::TemporaryFolder folder;
    const auto repeat = [](const std::string& part, int count) {
        std::string text;
        for (int i = 0; i < count; ++i) {
            text += part;
        }
        return text;
    };
    std::string staircase;
    for (int i = 0; i < 400; ++i) {
        staircase += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
    }
    const std::vector<std::string> texts{repeat("[", 200000),
                                         repeat("{", 200000),
                                         repeat("{a: ", 200000),
                                         repeat("- ", 200000),
                                         repeat("? ", 200000),
                                         repeat("[{", 100000),
                                         staircase,
                                         repeat("a: &x [*x, *x]\n", 1000),
                                         repeat("a", 2000000),
                                         repeat("\"", 100001),
                                         repeat("object: {shape: {union: {parts: [", 1) + repeat("{union: {parts: [", 100)};
    for (const std::string& text : texts) {
        EXPECT_THROW((void)read_config(folder.write("huge.yaml", text)), ConfigError) << text.substr(0, 40);
        EXPECT_THROW((void)read_config(test::example_files().front(), {"object=" + text}), ConfigError) << text.substr(0, 40);
    }
    EXPECT_THROW((void)read_config(test::example_files().front(), {repeat("a.", 100000) + "a=1"}), ConfigError);
}

}  // namespace
}  // namespace palpate::fuzz_test
