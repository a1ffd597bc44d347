// Every object, at two epsilons, with every combination of refine and explore, and with inference.
#include "sim/truth.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::matrix_test {
namespace {

struct Case {
    std::string subject;
    double epsilon = 0.0;
    Strategy strategy;
};

std::vector<Case> all_cases() {
    std::vector<Case> cases;
    for (const Subject& s : subjects()) {
        for (const double epsilon : s.epsilons) {
            for (const Strategy& strategy : all_strategies()) cases.push_back({s.name, epsilon, strategy});
        }
    }
    return cases;
}

class Matrix : public ::testing::TestWithParam<Case> {};

TEST_P(Matrix, EndsWithTheTruth) {
    const Case& c = GetParam();
    const FinishedRun run(subject(c.subject), c.epsilon, c.strategy);
    expect_right_result(run);
    expect_sparse(run);
    expect_true_records(run);

    if (c.strategy.infer == Strategy::Infer::automatic && run.object().reach()) {
        EXPECT_NE(run.result().certificate.status, Certificate::Status::refuted) << "the bound is true";
    }

    const TruthSampling sampling{20'000, 20'000};
    const Truth truth = measure_truth(run.object(), run.result().mesh, sampling, 1);
    const double bound = lower_bound_samples(truth.area, c.epsilon);
    EXPECT_LE(static_cast<double>(run.result().samples), 1.9 * bound);
    if (truth.reach && c.epsilon <= kMaxEpsilonPerReach * *truth.reach) {
        const bool told = c.strategy.infer != Strategy::Infer::adaptive;
        EXPECT_EQ(run.result().certificate.status, told ? Certificate::Status::certified : Certificate::Status::conditional);
        EXPECT_LE(truth.hausdorff, 1.5 * c.epsilon * c.epsilon / *truth.reach);
    }
}

INSTANTIATE_TEST_SUITE_P(Objects, Matrix, ::testing::ValuesIn(all_cases()), [](const auto& test) {
    const Case& c = test.param;
    std::string epsilon = std::to_string(c.epsilon).substr(0, 6);
    std::replace(epsilon.begin(), epsilon.end(), '.', '_');
    return c.subject + "_" + epsilon + "_" + strategy_name(c.strategy);
});

}  // namespace
}  // namespace palpate::matrix_test
