// The letters and numbers of one line of G-code.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

struct GrblWord {
    char letter = 'G';
    double value = 0.0;
};

struct GrblWords {
    std::vector<GrblWord> words;
    int error = 0;  // of grbl_errors.h, or 0
};

// The number at the beginning of `text`, taken off it: sign, digits, one point; no exponent, no "nan". Nothing if there is none.
[[nodiscard]] std::optional<double> take_number(std::string_view& text);

// `line` without spaces and comments, in capitals (GrblLine).
[[nodiscard]] GrblWords parse_words(std::string_view line);

// Gathers the bytes of one line as the firmware does: no white space, no comments, capitals, at most kLongest of them.
class GrblLine {
public:
    static constexpr std::size_t kLongest = 79;  // LINE_BUFFER_SIZE is 80, with the final zero

    void add(char c);
    void clear() { *this = {}; }

    [[nodiscard]] const std::string& text() const { return text_; }
    [[nodiscard]] bool is_too_long() const { return too_long_; }

private:
    enum class Comment { none, parentheses, to_the_end };

    std::string text_;
    Comment comment_ = Comment::none;
    bool too_long_ = false;
};

}  // namespace palpate
