#include "devices/internal/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

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

std::string place_text(const Point& p) { return "(" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ")"; }

}  // namespace palpate
