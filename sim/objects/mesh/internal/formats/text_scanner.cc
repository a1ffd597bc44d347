#include "sim/objects/mesh/internal/formats/text_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "sim/objects/errors.h"
#include "sim/objects/mesh/internal/polygon_soup.h"

namespace palpate {
namespace {

bool blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// std::from_chars takes no plus sign.
std::string_view without_plus(std::string_view word) {
    const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+';
    return plus ? word.substr(1) : word;
}

// Of a number that is not zero.
bool is_below_one(std::string_view number) {
    const std::size_t e = std::min(number.find_first_of("eE"), number.size());
    std::int64_t exponent = 0;
    if (e < number.size()) {
        const std::string_view text = without_plus(number.substr(e + 1));
        if (std::from_chars(text.data(), text.data() + text.size(), exponent).ec != std::errc()) return text.starts_with('-');
    }
    const std::string_view mantissa = number.substr(0, e);
    const auto point = static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size()));
    const auto first = static_cast<std::int64_t>(mantissa.find_first_of("123456789"));
    const std::int64_t places = first < point ? point - first : point - first + 1;  // 1.0 has 1, 0.1 has 0
    return exponent <= -places;
}

}  // namespace

TextScanner::TextScanner(std::string_view text, Rules rules) : text_(text), rules_(rules) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text_.starts_with(kByteOrderMark)) position_ = kByteOrderMark.size();
}

std::size_t TextScanner::line_end_at(std::size_t position) const {
    if (position >= text_.size()) return 0;
    if (text_[position] == '\n') return 1;
    if (text_[position] != '\r') return 0;
    return position + 1 < text_.size() && text_[position + 1] == '\n' ? 2 : 1;
}

void TextScanner::end_line(std::size_t bytes) {
    position_ += bytes;
    ++line_;
}

void TextScanner::skip_blanks() {
    while (position_ < text_.size()) {
        const char c = text_[position_];
        if (blank(c)) {
            ++position_;
        } else if (rules_.comments && c == '#') {
            while (position_ < text_.size() && line_end_at(position_) == 0) ++position_;
        } else if (const std::size_t bytes = line_end_at(position_ + 1); rules_.continued && c == '\\' && bytes > 0) {
            end_line(1 + bytes);
        } else {
            return;
        }
    }
}

std::string_view TextScanner::word_on_line() {
    skip_blanks();
    word_line_ = line_;
    const std::size_t begin = position_;
    while (position_ < text_.size() && !blank(text_[position_]) && line_end_at(position_) == 0) {
        const char c = text_[position_];
        const bool number = c == '#' && position_ > begin && text_[position_ - 1] == '.';  // 1.#QNAN is none, but no comment either
        if ((rules_.comments && c == '#' && !number) || (rules_.continued && c == '\\' && line_end_at(position_ + 1) > 0)) break;
        ++position_;
    }
    return text_.substr(begin, position_ - begin);
}

std::string_view TextScanner::word() {
    while (true) {
        const std::string_view found = word_on_line();
        if (!found.empty() || position_ >= text_.size()) return found;
        end_line(line_end_at(position_));
    }
}

bool TextScanner::at_line_end() {
    skip_blanks();
    return position_ >= text_.size() || line_end_at(position_) > 0;
}

void TextScanner::skip_line() {
    while (!at_line_end()) word_on_line();
    if (position_ < text_.size()) end_line(line_end_at(position_));
}

void TextScanner::skip_line_as_written() {
    const bool continued = std::exchange(rules_.continued, false);
    skip_line();
    rules_.continued = continued;
}

double TextScanner::coordinate(std::string_view word) const {
    const std::string_view digits = without_plus(word);
    double value = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool whole_word = !digits.empty() && end == digits.data() + digits.size();
    // Out of range is infinite, or so small that it is zero.
    if (whole_word && error == std::errc::result_out_of_range && is_below_one(digits)) return 0.0;
    if (!whole_word || error != std::errc() || !(std::abs(value) <= kLargestCoordinate)) refuse_word(word, "a coordinate");
    return value;
}

std::int64_t TextScanner::whole(std::string_view word, std::string_view expected) const {
    const std::string_view digits = without_plus(word);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) refuse_word(word, expected);
    return value;
}

std::size_t TextScanner::count(std::string_view word, std::string_view expected) const {
    const std::int64_t value = whole(word, expected);
    if (value < 0) refuse_word(word, expected);
    return static_cast<std::size_t>(value);
}

void TextScanner::refuse_word(std::string_view word, std::string_view expected) const {
    const std::string end = position_ >= text_.size() ? "the file ends" : "the line ends";
    refuse(fmt::format("{} where {} was expected", word.empty() ? end : quoted_word(word), expected));
}

void TextScanner::refuse(const std::string& what) const { throw ObjectError(fmt::format("line {}: {}", word_line_, what)); }

std::size_t count_lines(TextScanner in) {
    std::size_t lines = 0;
    for (; !in.word().empty(); ++lines) in.skip_line();
    return lines;
}

bool equal_words(std::string_view word, std::string_view lower_case) { return std::ranges::equal(word, lower_case, {}, lower); }

std::string lower_case(std::string_view word) {
    std::string result(word);
    std::ranges::transform(result, result.begin(), lower);
    return result;
}

std::string quoted_word(std::string_view word) {
    constexpr std::size_t kLongest = 30;
    std::string text(word.substr(0, kLongest));
    std::ranges::replace_if(
        text, [](unsigned char c) { return c < 0x20 || c > 0x7E; }, '?');
    return fmt::format("'{}{}'", text, word.size() > kLongest ? "..." : "");
}

}  // namespace palpate
