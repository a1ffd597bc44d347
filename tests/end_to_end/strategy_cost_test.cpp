// What the default strategy is for.
#include "tests/end_to_end/subjects.h"

namespace palpate::strategy_cost_test {
namespace {

TEST(StrategyCost, EagerClosureNeedsHalfTheProbesOfTheThesisOnATorus) {
    const FinishedRun thesis(subject("torus"), 0.05, Strategy::thesis());
    const FinishedRun eager(subject("torus"), 0.05,
                            {Strategy::Refine::eager, Strategy::Explore::closure, Strategy::Infer::none, Strategy::Travel::voronoi});
    EXPECT_LE(static_cast<double>(eager.result().cost.probes()), 0.5 * static_cast<double>(thesis.result().cost.probes()));
    expect_right_result(thesis);
    expect_right_result(eager);
}

}  // namespace
}  // namespace palpate::strategy_cost_test
