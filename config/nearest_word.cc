#include "config/nearest_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace palpate {
namespace {

// Two slips of the finger are still the same word, if it is long enough.
constexpr std::size_t kMaxTypos = 2;
// Longer ones are no slip; their distance costs the product of both lengths.
constexpr std::size_t kMaxLetters = 64;

// Levenshtein's: how many letters to insert, remove or replace.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row[b.size()];
}

}  // namespace

std::string_view nearest_word(std::string_view typed, std::span<const std::string_view> words) {
    std::string_view nearest;
    std::size_t typos = kMaxTypos + 1;
    for (const std::string_view word : words) {
        const std::size_t distance = edit_distance(typed.substr(0, kMaxLetters), word);
        if (distance < typos && distance < word.size()) {
            typos = distance;
            nearest = word;
        }
    }
    return nearest;
}

std::string proposal(std::string_view nearest) { return nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest); }

std::string did_you_mean(std::string_view typed, std::span<const std::string_view> words) { return proposal(nearest_word(typed, words)); }

}  // namespace palpate
