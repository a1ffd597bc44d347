#include "tools/terminal/text_width.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/random.h"

namespace palpate::text_width_test {
namespace {

std::vector<std::string> words_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

TEST(Wrapped, LosesNoWordAndKeepsTheWidth) {
    Random random(20261129);
    for (int k = 0; k < 300; ++k) {
        std::string text = "w";
        for (std::uint64_t word = random.below(60); word > 0; --word) text += ' ' + std::string(1 + random.below(12), 'x');
        const int columns = 20 + static_cast<int>(random.below(80));
        const int indent = static_cast<int>(random.below(6));
        const std::string result = wrapped(text, columns, indent);
        ASSERT_EQ(words_of(result), words_of(text));
        std::istringstream lines(result);
        bool is_first = true;
        for (std::string line; std::getline(lines, line); is_first = false) {
            ASSERT_LE(line.size(), static_cast<std::size_t>(columns));
            if (!is_first) {
                ASSERT_EQ(line.find_first_not_of(' '), static_cast<std::size_t>(indent));
            }
        }
    }
}

TEST(Wrapped, CountsCharactersAndLeavesLongWordsAndUnknownWidthsAlone) {
    EXPECT_EQ(wrapped("a b c", 0, 2), "a b c");
    EXPECT_EQ(wrapped("εεεε εεεε", 9, 0), "εεεε εεεε");
    EXPECT_EQ(wrapped("aaaa bbbbbbbbbbbbbbb cc", 6, 2), "aaaa\n  bbbbbbbbbbbbbbb\n  cc");
    EXPECT_EQ(wrapped("", 10, 0), "");
}

}  // namespace
}  // namespace palpate::text_width_test
