#include "sim/machines/grbl/internal/grbl_words.h"

#include <charconv>

#include "sim/machines/grbl/internal/grbl_errors.h"

namespace palpate {
namespace {

bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Sign, digits, one point; no exponent: E is a letter of its own. Empty if there is no digit.
std::string_view number_at(std::string_view text) {
    std::size_t end = 0;
    if (!text.empty() && (text[0] == '+' || text[0] == '-')) ++end;
    int digits = 0;
    bool point = false;
    for (; end < text.size(); ++end) {
        if (is_digit(text[end])) {
            ++digits;
        } else if (text[end] == '.' && !point) {
            point = true;
        } else {
            break;
        }
    }
    return digits > 0 ? text.substr(0, end) : std::string_view();
}

}  // namespace

std::optional<double> take_number(std::string_view& text) {
    const std::string_view number = number_at(text);
    if (number.empty()) return std::nullopt;
    double value = 0.0;
    const std::size_t sign = number[0] == '+' ? 1 : 0;  // which from_chars does not take
    std::from_chars(number.data() + sign, number.data() + number.size(), value);
    text.remove_prefix(number.size());
    return value;
}

GrblWords parse_words(std::string_view line) {
    GrblWords result;
    while (!line.empty()) {
        if (!is_letter(line[0])) return {{}, kExpectedLetter};
        const char letter = line[0];
        line.remove_prefix(1);
        const std::optional<double> value = take_number(line);
        if (!value) return {{}, kBadNumber};
        result.words.push_back({letter, *value});
    }
    return result;
}

void GrblLine::add(char c) {
    if (comment_ == Comment::to_the_end) return;
    if (comment_ == Comment::parentheses) {
        if (c == ')') comment_ = Comment::none;
        return;
    }
    if (c == '(') {
        comment_ = Comment::parentheses;
    } else if (c == ';') {
        comment_ = Comment::to_the_end;
    } else if (c > ' ' && c != '/') {
        if (text_.size() >= kLongest) {
            too_long_ = true;
        } else {
            text_ += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
        }
    }
}

}  // namespace palpate
