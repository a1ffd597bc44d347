// What somebody meant who mistyped a word.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace palpate {

// The one of `words` with the fewest slips of the finger between it and `typed`, the first of equals; empty if two do not suffice.
[[nodiscard]] std::string_view nearest_word(std::string_view typed, std::span<const std::string_view> words);

// For a message: `; did you mean "epsilon"?`, or nothing if no word is near.
[[nodiscard]] std::string proposal(std::string_view nearest);
// The same for what is nearest of `words`.
[[nodiscard]] std::string did_you_mean(std::string_view typed, std::span<const std::string_view> words);

}  // namespace palpate
