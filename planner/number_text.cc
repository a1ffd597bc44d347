#include "planner/number_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace palpate {

void append_number(std::string& text, double x) {
    if (x == 0 && std::signbit(x)) {
        text += "-0.0";
        return;
    }
    std::array<char, 32> digits{};  // the longest double takes 24
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr;
    text.append(digits.data(), end);
}

std::string number_text(double x, const char* unit) {
    std::string text;
    append_number(text, x);
    return text + unit;
}

std::string point_text(const Point& p) {
    constexpr int kDigits = 7;
    std::array<char, 64> text{};  // three times up to 14: "-1.234567e-308"
    char* end = text.data();
    char* const last = text.data() + text.size();
    for (int axis = 0; axis < 3; ++axis) {
        for (const char c : std::string_view(axis == 0 ? "(" : ", ")) *end++ = c;
        end = std::to_chars(end, last, p[axis], std::chars_format::general, kDigits).ptr;
    }
    return std::string(text.data(), end) + ") mm";
}

}  // namespace palpate
