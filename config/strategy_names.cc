#include "config/strategy_names.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <vector>

#include "config/nearest_word.h"

namespace palpate {

namespace {

// In the order of the enumerators.
constexpr std::array<std::string_view, 2> kRefineWords{"exhaustive", "eager"};
constexpr std::array<std::string_view, 2> kExploreWords{"exhaustive", "closure"};
constexpr std::array<std::string_view, 4> kInferWords{"none", "reach", "adaptive", "auto"};
constexpr std::array<std::string_view, 2> kTravelWords{"voronoi", "free_space"};

constexpr std::array<std::string_view, 3> kNames{"default", "thesis", "adaptive"};
constexpr std::array<Strategy, 3> kNamed{Strategy{}, Strategy::thesis(), Strategy::adaptive()};

// `word`, of `name`, is none of `words`.
[[noreturn]] void fail(std::string_view name, std::string_view word, std::span<const std::string_view> words) {
    throw std::invalid_argument(fmt::format(
        "unknown strategy '{}'{}; allowed: default, thesis, adaptive, or refine+explore[+infer[+travel]] with refine {}, explore "
        "{}, infer {}, travel {}",
        name, did_you_mean(word, words), fmt::join(kRefineWords, "|"), fmt::join(kExploreWords, "|"), fmt::join(kInferWords, "|"),
        fmt::join(kTravelWords, "|")));
}

template <class Option>
Option from_word(std::string_view word, std::string_view name) {
    const auto words = strategy_words<Option>();
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] == word) {
            return static_cast<Option>(i);
        }
    }
    fail(name, word, words);
}

std::vector<std::string_view> split(std::string_view name) {
    std::vector<std::string_view> words;
    while (true) {
        const std::size_t plus = name.find('+');
        words.push_back(name.substr(0, plus));
        if (plus == std::string_view::npos) {
            return words;
        }
        name.remove_prefix(plus + 1);
    }
}

}  // namespace

template <>
std::span<const std::string_view> strategy_words<Strategy::Refine>() {
    return kRefineWords;
}
template <>
std::span<const std::string_view> strategy_words<Strategy::Explore>() {
    return kExploreWords;
}
template <>
std::span<const std::string_view> strategy_words<Strategy::Infer>() {
    return kInferWords;
}
template <>
std::span<const std::string_view> strategy_words<Strategy::Travel>() {
    return kTravelWords;
}

std::span<const std::string_view> strategy_names() { return kNames; }
const Strategy& named_strategy(std::size_t index) { return kNamed.at(index); }

std::string to_string(const Strategy& strategy) {
    for (std::size_t k = 0; k < kNamed.size(); ++k) {
        if (strategy == kNamed[k]) return std::string(kNames[k]);
    }
    return fmt::format("{}+{}+{}+{}", to_word(strategy.refine), to_word(strategy.explore), to_word(strategy.infer),
                       to_word(strategy.travel));
}

Strategy parse_strategy(std::string_view name) {
    for (std::size_t k = 0; k < kNamed.size(); ++k) {
        if (name == kNames[k]) return kNamed[k];
    }
    Strategy strategy;
    const std::vector<std::string_view> words = split(name);
    if (words.size() < 2 || words.size() > 4) {
        fail(name, name, kNames);
    }
    strategy.refine = from_word<Strategy::Refine>(words[0], name);
    strategy.explore = from_word<Strategy::Explore>(words[1], name);
    if (words.size() > 2) {
        strategy.infer = from_word<Strategy::Infer>(words[2], name);
    }
    if (words.size() > 3) {
        strategy.travel = from_word<Strategy::Travel>(words[3], name);
    }
    return strategy;
}

}  // namespace palpate
