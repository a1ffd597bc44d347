#include "config/strategy_names.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace palpate {
namespace {

TEST(StrategyNames, EveryCombinationReadsBackFromItsOwnName) {
    std::set<std::string> names;
    for (std::size_t refine = 0; refine < strategy_words<Strategy::Refine>().size(); ++refine) {
        for (std::size_t explore = 0; explore < strategy_words<Strategy::Explore>().size(); ++explore) {
            const Strategy strategy{static_cast<Strategy::Refine>(refine), static_cast<Strategy::Explore>(explore), {}, {}};
            EXPECT_EQ(parse_strategy(to_string(strategy)), strategy) << to_string(strategy);
            names.insert(to_string(strategy));
        }
    }
    EXPECT_EQ(names, (std::set<std::string>{"thesis", "eager+closure", "eager+exhaustive", "exhaustive+closure"}));
}

TEST(StrategyNames, WordsFollowTheEnumerators) {
    EXPECT_EQ(to_word(Strategy::Refine::exhaustive), "exhaustive");
    EXPECT_EQ(to_word(Strategy::Refine::eager), "eager");
    EXPECT_EQ(to_word(Strategy::Explore::exhaustive), "exhaustive");
    EXPECT_EQ(to_word(Strategy::Explore::closure), "closure");
    EXPECT_EQ(to_word(Strategy::Infer::none), "none");
    EXPECT_EQ(to_word(Strategy::Travel::voronoi), "voronoi");
}

TEST(StrategyNames, KnowsTheNamedStrategiesAndLongForms) {
    EXPECT_EQ(parse_strategy("thesis"), Strategy::thesis());
    EXPECT_EQ(parse_strategy("default"), Strategy{});
    EXPECT_EQ(parse_strategy("exhaustive+exhaustive"), Strategy::thesis());
    EXPECT_EQ(parse_strategy("eager+closure+none"), Strategy{});
    EXPECT_EQ(parse_strategy("eager+closure+none+voronoi"), Strategy{});
}

TEST(StrategyNames, RefusesEverythingElseAndListsWhatIsAllowed) {
    for (const char* name :
         {"", "+", "eager", "Thesis", "eager+", "closure+eager", "eager+closure+", "eager+closure+none+voronoi+none", " eager+closure"}) {
        try {
            (void)parse_strategy(name);
            ADD_FAILURE() << "accepted '" << name << "'";
        } catch (const std::invalid_argument& error) {
            EXPECT_EQ(std::string(error.what()),
                      "unknown strategy '" + std::string(name) +
                          "'; allowed: thesis, default, or refine+explore[+infer[+travel]] with refine exhaustive|eager, "
                          "explore exhaustive|closure, infer none, travel voronoi");
        }
    }
}

}  // namespace
}  // namespace palpate
