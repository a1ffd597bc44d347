// The words for the four options of planner/DESIGN.md, "Strategy", in files, tables and on the command line.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "planner/options.h"

namespace palpate {

// All words of an option, in the order of its enumerators: strategy_words<E>()[static_cast<std::size_t>(value)].
template <class Option>
[[nodiscard]] std::span<const std::string_view> strategy_words();
template <>
[[nodiscard]] std::span<const std::string_view> strategy_words<Strategy::Refine>();
template <>
[[nodiscard]] std::span<const std::string_view> strategy_words<Strategy::Explore>();
template <>
[[nodiscard]] std::span<const std::string_view> strategy_words<Strategy::Infer>();
template <>
[[nodiscard]] std::span<const std::string_view> strategy_words<Strategy::Travel>();

template <class Option>
[[nodiscard]] std::string_view to_word(Option value) {
    return strategy_words<Option>()[static_cast<std::size_t>(value)];
}

// The strategies that have a name: default, thesis, adaptive.
[[nodiscard]] std::span<const std::string_view> strategy_names();
[[nodiscard]] const Strategy& named_strategy(std::size_t index);

// Short name for tables: "thesis", or refine+explore, such as "eager+closure", with "+infer+travel" where these are not
// the defaults. parse_strategy(to_string(s)) == s for all s.
[[nodiscard]] std::string to_string(const Strategy& strategy);

// A named strategy, or two to four words refine+explore[+infer[+travel]]; what is left out takes its default.
// Throws std::invalid_argument that lists what is allowed.
[[nodiscard]] Strategy parse_strategy(std::string_view name);

}  // namespace palpate
