// MaintainedDelaunay::is_valid after every insertion, and records against the ray caster while a run is under way.
#include "planner/motion/probed_space.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::invariants_test {
namespace {

class Invariants : public ::testing::TestWithParam<Strategy> {};

TEST_P(Invariants, HoldAfterEveryInsertion) {
    for (const auto& [name, epsilon] : {std::pair{"torus", 0.16}, {"genus2", 0.2}, {"two_components", 0.2}, {"bunny", 0.8}}) {
        SCOPED_TRACE(name);
        std::size_t insertions = 0;
        std::string first_wrong;
        const auto look = [&](const ProbedSpace& space) {
            ++insertions;
            std::string why;
            if (first_wrong.empty() && !space.is_valid(&why)) first_wrong = "after insertion " + std::to_string(insertions) + ": " + why;
        };
        const FinishedRun run(subject(name), epsilon, GetParam(), {}, std::nullopt, look);
        EXPECT_EQ(first_wrong, "");
        EXPECT_GT(insertions, 50U);
        expect_true_records(run);
    }
}

INSTANTIATE_TEST_SUITE_P(Strategies, Invariants, ::testing::ValuesIn(all_strategies()),
                         [](const auto& test) { return strategy_name(test.param); });

}  // namespace
}  // namespace palpate::invariants_test
