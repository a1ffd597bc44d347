// Inference from a reach bound and growth as a front: what it saves, and that a false bound is found out (planner/DESIGN.md, "Growing").
#include <cmath>
#include <iostream>
#include <limits>

#include "sim/facet_truth.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::growth_test {
namespace {

struct Cost {
    std::string subject;
    double epsilon;
    double probes_per_sample;
    double displacement;       // in epsilon per sample
    double samples_per_bound;  // 1.9 where the aim is not on samples
};

class Growth : public ::testing::TestWithParam<Cost> {};

TEST_P(Growth, CostsLittleMoreThanOneTouchPerSample) {
    const Cost& c = GetParam();
    const FinishedRun run(subject(c.subject), c.epsilon, Strategy{});
    const Result& r = run.result();
    const auto samples = static_cast<double>(r.samples);
    EXPECT_LE(static_cast<double>(r.cost.probes()) / samples, c.probes_per_sample);
    EXPECT_LE(r.cost.displacement() / r.lower_bound_displacement, c.displacement);
    EXPECT_LE(samples / r.lower_bound_samples, c.samples_per_bound);
    EXPECT_EQ(r.certificate.status, Certificate::Status::certified);
    expect_right_result(run);
    expect_sparse(run);
}

INSTANTIATE_TEST_SUITE_P(Objects, Growth,
                         ::testing::Values(Cost{"torus", 0.064, 1.3, 7, 1.42}, Cost{"torus", 0.05, 1.1, 7, 1.42},
                                           Cost{"torus", 0.025, 1.05, 6, 1.42}, Cost{"sphere", 0.05, 1.1, 5, 1.42},
                                           Cost{"ellipsoid", 0.036, 1.3, 8, 1.42}, Cost{"genus2", 0.02, 1.3, 8, 1.42},
                                           Cost{"rounded_box", 0.03, 1.3, 8, 1.42}),
                         [](const auto& test) {
                             return test.param.subject + "_" + std::to_string(static_cast<int>(test.param.epsilon * 1000 + 0.5));
                         });

// What the certificate says that the touches allow.
double largest_bound(const Certificate& certificate) {
    const std::string& detail = certificate.find(Premise::Kind::reach)->detail;
    const std::string key = "the largest bound that the touches allow is ";
    const std::size_t at = detail.find(key);
    return at == std::string::npos ? std::numeric_limits<double>::quiet_NaN() : std::stod(detail.substr(at + key.size()));
}

TEST(FalseBound, IsRefutedAndTheMeshIsRightAllTheSame) {
    for (const auto& [name, epsilon, told, truth] :
         {std::tuple{"torus", 0.05, 0.8, 0.4}, {"genus2", 0.02, 0.4, 0.2}, {"rounded_box", 0.05, 0.6, 0.3}, {"bunny", 0.25, 2.0, 0.0}}) {
        SCOPED_TRACE(name);
        const FinishedRun run(subject(name), epsilon, Strategy{}, {}, told);
        expect_right_result(run);
        EXPECT_EQ(run.result().certificate.status, Certificate::Status::refuted);
        const Premise& reach = *run.result().certificate.find(Premise::Kind::reach);
        EXPECT_EQ(reach.state, Premise::State::refuted);
        // The evidence never rules out the truth, and says what it is.
        const double largest = largest_bound(run.result().certificate);
        EXPECT_GE(largest, truth * (1 - 1e-6)) << reach.detail;
        EXPECT_LT(largest, told);
    }
}

TEST(TrueBound, IsNeverRefuted) {
    for (const auto& [name, epsilon] :
         {std::pair{"torus", 0.1}, {"sphere", 0.3}, {"genus2", 0.06}, {"two_components", 0.08}, {"two_components", 0.075}}) {
        SCOPED_TRACE(name);
        const FinishedRun run(subject(name), epsilon, Strategy{});
        expect_right_result(run);
        EXPECT_NE(run.result().certificate.status, Certificate::Status::refuted)
            << run.result().certificate.find(Premise::Kind::reach)->detail;
        EXPECT_EQ(run.wrong_inferences(), 0U);
    }
}

// `fewer` times fewer than a million.
void expect_right_inferences(double fewer) {
    std::size_t inferences = 0;
    for (const auto& [name, epsilon] :
         {std::pair{"torus", 0.0062}, {"sphere", 0.0063}, {"genus2", 0.01}, {"ellipsoid", 0.0054}, {"rounded_box", 0.0155}}) {
        SCOPED_TRACE(name);
        const FinishedRun run(subject(name), epsilon * std::sqrt(fewer), Strategy{});
        EXPECT_EQ(run.wrong_inferences(), 0U);
        expect_right_result(run);
        inferences += run.inferences();
    }
    EXPECT_GE(static_cast<double>(inferences), 1e6 / fewer);
    std::cout << inferences << " inferences\n";
}

TEST(TrueBound, AHundredThousandInferencesAreRight) { expect_right_inferences(10); }
TEST(TrueBound, NightlyAMillionInferencesAreRight) { expect_right_inferences(1); }

TEST(Adaptive, CostsLittleWhereNobodyKnowsTheReach) {
    const FinishedRun run(subject("bunny"), 0.236, Strategy::adaptive());
    const Result& r = run.result();
    expect_right_result(run);
    EXPECT_LE(static_cast<double>(r.cost.probes()) / static_cast<double>(r.samples), 1.5);
    EXPECT_LE(r.cost.displacement() / r.lower_bound_displacement, 7);
    EXPECT_LE(static_cast<double>(r.samples) / r.lower_bound_samples, 1.6);
    // Not proven, and it says so: some of it is wrong, little.
    EXPECT_EQ(r.certificate.status, Certificate::Status::conditional);
    EXPECT_EQ(r.certificate.find(Premise::Kind::reach)->state, Premise::State::missing);
    EXPECT_EQ(r.certificate.find(Premise::Kind::inference)->state, Premise::State::missing);
    EXPECT_NE(r.certificate.statement.find("plausible only"), std::string::npos) << r.certificate.statement;
    const auto verdicts = judge_facets(run.object(), r.mesh, r.dual_edges, 0.236);
    EXPECT_LE(static_cast<double>(std::ranges::count(verdicts, FacetVerdict::wrong)), 0.008 * static_cast<double>(r.topology.facets));
    EXPECT_GT(r.cost.plausible_contact, r.topology.facets / 2);
    EXPECT_EQ(r.cost.inferred_contact, 0U);
    EXPECT_EQ(static_cast<std::uint64_t>(std::ranges::count_if(r.confidences, [](double c) { return c < 1; })), r.cost.plausible_contact);
}

TEST(Adaptive, TrustsAsFarAsItIsToldTo) {
    std::uint64_t before = 1'000'000;
    for (const double trust : {0.01, 0.0005, 0.0}) {
        Options options;
        options.epsilon = 0.3;
        options.trust = trust;
        const FinishedRun run(subject("bunny"), options);
        expect_right_result(run);
        const Result& r = run.result();
        EXPECT_LT(r.cost.plausible_contact, before) << trust;
        before = r.cost.plausible_contact;
        for (const double confidence : r.confidences) ASSERT_GE(confidence, 1 - std::min(8 * trust, 0.16) - 1e-12) << trust;
    }
    EXPECT_EQ(before, 0U) << "whatever is not proven was touched";
}

TEST(Adaptive, EndsRightOnCreasesAndAtAnyEpsilon) {
    for (const double epsilon : {0.15, 0.3, 0.47}) {
        SCOPED_TRACE(epsilon);
        const FinishedRun run(subject("bunny"), epsilon, Strategy::adaptive());
        expect_right_result(run);
        expect_sparse(run);
    }
}

TEST(Adaptive, ProvesNothingWhateverBoundIsGiven) {
    const FinishedRun run(subject("torus"), 0.05, Strategy::adaptive(), {}, 0.4);
    expect_right_result(run);
    EXPECT_EQ(run.result().certificate.status, Certificate::Status::conditional);
    EXPECT_EQ(run.wrong_inferences(), 0U);
}

TEST(FalseBound, IsNeverSaidToBeFalserThanItIs) {
    // A thin plate: the bound is lowered again and again at its rim.
    const Subject plate{"plate", ShapeSpec{RoundedBoxSpec{{2, 1.5, 0.2}, 0.1}}, Region(Ball{Point::Zero(), 1.6}), {}, {}};
    for (const double told : {0.2, 0.5}) {
        Options options;
        options.epsilon = 0.05;
        options.reach = told;
        options.audit = 1;
        const FinishedRun run(plate, options);
        expect_right_result(run);
        const Certificate& certificate = run.result().certificate;
        EXPECT_EQ(certificate.status, Certificate::Status::refuted);
        EXPECT_GE(largest_bound(certificate), 0.1 * (1 - 1e-6)) << certificate.find(Premise::Kind::reach)->detail;
        EXPECT_LT(largest_bound(certificate), told);
    }
}

TEST(Audit, EndsWhenItIsEnough) {
    Options options;
    options.epsilon = 0.05;
    options.reach = 0.4;
    options.audit = 1;
    const FinishedRun run(subject("torus"), options);
    expect_right_result(run);
    const std::string& detail = run.result().certificate.find(Premise::Kind::inference)->detail;
    EXPECT_NE(detail.find("; 300 more, drawn at random, were touched anyway, 0 of them"), std::string::npos) << detail;
}

}  // namespace
}  // namespace palpate::growth_test
