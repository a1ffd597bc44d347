// Counts and lengths in messages.
#pragma once

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>

namespace palpate {

// "1 edge", "2 edges".
[[nodiscard]] inline std::string counted(std::size_t n, const std::string& one, const std::string& many) {
    return fmt::format("{} {}", n, n == 1 ? one : many);
}

[[nodiscard]] inline std::string no_such_point(std::int64_t index, std::size_t points, int first) {
    return fmt::format("a face names point {}, but there are {}, counted from {}", index, points, first);
}

// To three digits.
[[nodiscard]] inline std::string rounded_text(double x) {
    constexpr int kDigits = 3;
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x, std::chars_format::general, kDigits).ptr};
}

}  // namespace palpate
