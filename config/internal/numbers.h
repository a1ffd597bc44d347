// Numbers as text, independent of the locale, and exact both ways.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "config/internal/section.h"

namespace palpate::yaml {

// The value of `node`. Throws ConfigError, saying what is `allowed`, on text, on infinities and NaN, and beyond the range
// of the type.
[[nodiscard]] double read_number(const Value& node, const std::string& path, const std::string& allowed);
[[nodiscard]] std::uint64_t read_whole_number(const Value& node, const std::string& path, const std::string& allowed);

// As above, in degrees; returns radians. It computes in long double because a double of degrees cannot reach every
// double of radians: about one in nine would not survive writing and reading.
[[nodiscard]] double read_degrees(const Value& node, const Bounds& bounds, const std::string& path, const std::string& allowed);

// palpate::number_text, which throws std::invalid_argument when `value` is not finite.
[[nodiscard]] std::string number_text(double value);
// The shortest number of degrees that read_degrees turns back into `radians`. Throws as above.
[[nodiscard]] std::string degrees_text(double radians);

}  // namespace palpate::yaml
