// Counts and lengths in messages.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <string>

namespace palpate {

// "1 edge", "2 edges".
[[nodiscard]] inline std::string counted(std::size_t n, const std::string& one, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

// To three digits.
[[nodiscard]] inline std::string rounded_text(double x) {
    constexpr int kDigits = 3;
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x, std::chars_format::general, kDigits).ptr};
}

}  // namespace palpate
