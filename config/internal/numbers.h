// Numbers as text, independent of the locale, and exact both ways.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "config/internal/tree.h"

namespace palpate::yaml {

struct Bounds {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_included = true;  // high always is

    [[nodiscard]] bool contain(double value) const { return (low_included ? value >= low : value > low) && value <= high; }
    [[nodiscard]] std::string text() const;  // "greater than 0"
};
constexpr Bounds kPositive{0.0, std::numeric_limits<double>::infinity(), false};
constexpr Bounds kNotNegative{0.0};
// No part is a kilometre large, and the squares and cubes of what is stay far within doubles.
constexpr double kFarthest_mm = 1e6;
constexpr Bounds kLength{0.0, kFarthest_mm, false};
constexpr Bounds kLengthOrZero{0.0, kFarthest_mm};
constexpr Bounds kCoordinate{-kFarthest_mm, kFarthest_mm};

[[nodiscard]] std::string with_unit(const std::string& range, std::string_view unit);  // "greater than 0 (mm)"

// What a message about a value says beside the value: its full key, and what would be allowed.
struct Spot {
    std::string path;
    std::string allowed;
};
[[noreturn]] void refuse(const Value& node, const Spot& spot, const std::string& why);

// The value of `node`. Throws ConfigError on text, on infinities and NaN, beyond the range of the type and out of bounds.
[[nodiscard]] double read_number(const Value& node, const Bounds& bounds, const Spot& spot);
[[nodiscard]] std::uint64_t read_whole_number(const Value& node, std::uint64_t low, std::uint64_t high, const Spot& spot);

// As above, in degrees; returns radians. It computes in long double because a double of degrees cannot reach every
// double of radians: about one in nine would not survive writing and reading.
[[nodiscard]] double read_degrees(const Value& node, const Bounds& bounds, const Spot& spot);

// palpate::number_text, which throws std::invalid_argument when `value` is not finite.
[[nodiscard]] std::string number_text(double value);
// The shortest number of degrees that read_degrees turns back into `radians`. Throws as above.
[[nodiscard]] std::string degrees_text(double radians);

}  // namespace palpate::yaml
