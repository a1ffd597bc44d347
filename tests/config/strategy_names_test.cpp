#include "config/strategy_names.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace palpate::strategy_names_test {
namespace {

TEST(StrategyNames, EveryCombinationReadsBackFromItsOwnName) {
    std::set<std::string> names;
    for (std::size_t refine = 0; refine < strategy_words<Strategy::Refine>().size(); ++refine) {
        for (std::size_t explore = 0; explore < strategy_words<Strategy::Explore>().size(); ++explore) {
            for (std::size_t infer = 0; infer < strategy_words<Strategy::Infer>().size(); ++infer) {
                for (std::size_t travel = 0; travel < strategy_words<Strategy::Travel>().size(); ++travel) {
                    const Strategy strategy{static_cast<Strategy::Refine>(refine), static_cast<Strategy::Explore>(explore),
                                            static_cast<Strategy::Infer>(infer), static_cast<Strategy::Travel>(travel)};
                    EXPECT_EQ(parse_strategy(to_string(strategy)), strategy) << to_string(strategy);
                    names.insert(to_string(strategy));
                }
            }
        }
    }
    EXPECT_EQ(names.size(), 32U);
    EXPECT_TRUE(names.contains("thesis"));
    EXPECT_TRUE(names.contains("adaptive"));
    EXPECT_TRUE(names.contains("default"));
    EXPECT_TRUE(names.contains("eager+closure+none+voronoi"));
}

TEST(StrategyNames, WordsFollowTheEnumerators) {
    EXPECT_EQ(to_word(Strategy::Refine::exhaustive), "exhaustive");
    EXPECT_EQ(to_word(Strategy::Refine::eager), "eager");
    EXPECT_EQ(to_word(Strategy::Explore::exhaustive), "exhaustive");
    EXPECT_EQ(to_word(Strategy::Explore::closure), "closure");
    EXPECT_EQ(to_word(Strategy::Infer::none), "none");
    EXPECT_EQ(to_word(Strategy::Infer::reach), "reach");
    EXPECT_EQ(to_word(Strategy::Infer::adaptive), "adaptive");
    EXPECT_EQ(to_word(Strategy::Infer::automatic), "auto");
    EXPECT_EQ(to_word(Strategy::Travel::voronoi), "voronoi");
    EXPECT_EQ(to_word(Strategy::Travel::free_space), "free_space");
}

TEST(StrategyNames, KnowsTheNamedStrategiesAndLongForms) {
    EXPECT_EQ(parse_strategy("thesis"), Strategy::thesis());
    EXPECT_EQ(parse_strategy("default"), Strategy{});
    EXPECT_EQ(parse_strategy("exhaustive+exhaustive+none+voronoi"), Strategy::thesis());
    EXPECT_EQ(parse_strategy("eager+closure"), Strategy{});
    EXPECT_EQ(parse_strategy("eager+closure+auto"), Strategy{});
    EXPECT_EQ(parse_strategy("eager+closure+reach").infer, Strategy::Infer::reach);
    EXPECT_EQ(parse_strategy("eager+closure+auto+free_space"), Strategy{});
    EXPECT_EQ(parse_strategy("eager+exhaustive+none"),
              (Strategy{Strategy::Refine::eager, Strategy::Explore::exhaustive, Strategy::Infer::none, Strategy::Travel::free_space}));
}

TEST(StrategyNames, RefusesEverythingElseAndListsWhatIsAllowed) {
    const std::vector<std::pair<std::string, std::string>> names = {{"", ""},
                                                                    {"+", ""},
                                                                    {"eager", ""},
                                                                    {"Thesis", "thesis"},
                                                                    {"adaptiv", "adaptive"},
                                                                    {"eager+", ""},
                                                                    {"closure+eager", ""},
                                                                    {"eager+closur", "closure"},
                                                                    {"eager+closure+reech", "reach"},
                                                                    {"eager+closure+", ""},
                                                                    {"eager+closure+none+voronoi+none", ""},
                                                                    {" eager+closure", "eager"}};
    for (const auto& [name, proposed] : names) {
        const std::string proposal = proposed.empty() ? "" : "; did you mean \"" + proposed + "\"?";
        try {
            (void)parse_strategy(name);
            ADD_FAILURE() << "accepted '" << name << "'";
        } catch (const std::invalid_argument& error) {
            EXPECT_EQ(std::string(error.what()),
                      "unknown strategy '" + name + "'" + proposal +
                          "; allowed: default, thesis, adaptive, or refine+explore[+infer[+travel]] with refine exhaustive|eager, "
                          "explore exhaustive|closure, infer none|reach|adaptive|auto, travel voronoi|free_space");
        }
    }
}

}  // namespace
}  // namespace palpate::strategy_names_test
