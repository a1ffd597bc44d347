// Counts and lengths in messages.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>

namespace palpate {

// "1 edge", "2 edges".
[[nodiscard]] inline std::string counted(std::size_t n, const std::string& one, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

[[nodiscard]] inline std::string no_such_point(std::int64_t index, std::size_t points, int first) {
    return "a face names point " + std::to_string(index) + ", but there are " + std::to_string(points) + ", counted from " +
           std::to_string(first);
}

// To three digits.
[[nodiscard]] inline std::string rounded_text(double x) {
    constexpr int kDigits = 3;
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x, std::chars_format::general, kDigits).ptr};
}

}  // namespace palpate
