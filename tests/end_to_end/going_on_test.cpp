// Runs that go on from the touches of an earlier one (planner/DESIGN.md, "Going on").
#include <gtest/gtest.h>

#include <cstring>
#include <iostream>

#include "planner/errors.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::going_on_test {
namespace {

// As if the object had moved by `shift` since.
std::vector<EarlierTouch> touches_of(const Result& result, const Vector& shift = Vector::Zero()) {
    std::vector<EarlierTouch> touches;
    for (const Touch& touch : result.touches) touches.push_back({touch.position - shift, touch.from - shift, touch.sample.has_value()});
    return touches;
}

Options adaptive(const Subject& subject, double epsilon) {
    Options options;
    options.epsilon = epsilon;
    options.strategy = Strategy::adaptive();
    options.seed_rays = subject.seed_rays;
    return options;
}

// How many of its own touches are where an earlier one was.
std::size_t again(const Result& result) {
    std::size_t again = 0;
    for (const Touch& touch : result.touches) {
        if (touch.role == Touch::Role::earlier) continue;
        again += std::ranges::any_of(result.touches, [&](const Touch& earlier) {
            return earlier.role == Touch::Role::earlier && (earlier.position - touch.position).norm() < 1e-9;
        });
    }
    return again;
}

struct Step {
    std::string subject;
    double epsilon = 0.0;  // mm
    // What may be touched, of what the earlier run touched: at the same epsilon (audits, mostly); then at 0.7 of it, of what a new run
    // touches. Some 15 % above what was measured.
    double same = 0.0;
    double finer = 0.0;
};

class GoingOn : public ::testing::TestWithParam<Step> {};

TEST_P(GoingOn, NothingIsTouchedAgain) {
    const Subject& known = subject(GetParam().subject);
    Options options = adaptive(known, GetParam().epsilon);
    const FinishedRun first(known, options);
    options.earlier = touches_of(first.result());
    const FinishedRun same(known, options);
    expect_right_result(same);
    ASSERT_TRUE(same.result().earlier);
    const EarlierEvidence& evidence = *same.result().earlier;
    EXPECT_EQ(evidence.touches, first.result().touches.size());
    EXPECT_EQ(evidence.checked, 3U);
    EXPECT_LT(evidence.worst, 1e-9);
    EXPECT_GE(same.result().samples, first.result().samples);
    EXPECT_LE(again(same.result()), 3U);
    EXPECT_TRUE(same.result().certificate.find(Premise::Kind::earlier_touches)->holds());

    options.epsilon *= 0.7;
    const FinishedRun finer(known, options);
    expect_right_result(finer);
    EXPECT_LE(again(finer.result()), 3U);
    options.earlier.clear();
    const FinishedRun anew(known, options);
    const auto probes = [](const FinishedRun& run) { return static_cast<double>(run.result().cost.probes()); };
    std::cout << known.name << ": " << probes(first) << " probes; at the same epsilon " << probes(same) << ", of them " << evidence.checked
              << " checks; at 0.7 of it " << probes(finer) << ", a new run " << probes(anew) << "; way "
              << finer.result().cost.displacement() << ", new " << anew.result().cost.displacement() << '\n';
    EXPECT_LE(probes(same) / probes(first), GetParam().same);
    EXPECT_LE(probes(finer) / probes(anew), GetParam().finer);
    EXPECT_LT(finer.result().cost.displacement(), anew.result().cost.displacement());
}

INSTANTIATE_TEST_SUITE_P(Objects, GoingOn,
                         ::testing::Values(Step{"torus", 0.1, 0.08, 0.95}, Step{"genus2", 0.05, 0.08, 0.95},
                                           Step{"two_components", 0.075, 0.12, 0.95}, Step{"rounded_box", 0.1, 0.12, 0.95},
                                           Step{"bunny", 0.25, 0.12, 0.95}),
                         [](const auto& test) { return test.param.subject; });

TEST(GoingOn, WithABoundOnTheReach) {
    const Subject& known = subject("torus");
    Options options = adaptive(known, 0.06);
    options.strategy = Strategy{};
    options.reach = 0.39;
    const FinishedRun first(known, options);
    options.earlier = touches_of(first.result());
    const FinishedRun same(known, options);
    expect_right_result(same);
    EXPECT_EQ(same.result().certificate.status, Certificate::Status::certified);
    EXPECT_LE(again(same.result()), 3U);
    EXPECT_LT(same.result().cost.probes(), first.result().cost.probes() / 4);
}

// As a journal has them: nobody says which were samples.
TEST(GoingOn, FromTouchesAloneAndFromSomeOfThem) {
    const Subject& known = subject("genus2");
    Options options = adaptive(known, 0.05);
    const FinishedRun first(known, options);
    std::vector<EarlierTouch> touches = touches_of(first.result());
    for (EarlierTouch& touch : touches) touch.is_sample = false;
    for (const double share : {1.0, 0.5, 0.05}) {
        SCOPED_TRACE(share);
        options.earlier.assign(touches.begin(), touches.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(touches.size())));
        const FinishedRun run(known, options);
        expect_right_result(run);
        EXPECT_LE(again(run.result()), 3U);
        EXPECT_LE(run.result().cost.probes(), (1.25 - share) * static_cast<double>(first.result().cost.probes()));
    }
}

TEST(GoingOn, TheSameBytesEveryTime) {
    const Subject& known = subject("torus");
    Options options = adaptive(known, 0.15);
    const FinishedRun first(known, options);
    options.earlier = touches_of(first.result());
    options.tolerance = 0.0005;
    const FinishedRun one(known, options);
    const FinishedRun other(known, options);
    ASSERT_EQ(one.result().touches.size(), other.result().touches.size());
    for (std::size_t k = 0; k < one.result().touches.size(); ++k) {
        ASSERT_EQ(std::memcmp(one.result().touches[k].position.data(), other.result().touches[k].position.data(), 3 * sizeof(double)), 0);
    }
    EXPECT_EQ(one.result().mesh.triangles, other.result().mesh.triangles);
}

// A shift in any direction shows at one of three places.
TEST(GoingOn, APartThatHasMovedIsRefused) {
    const Subject& known = subject("torus");
    Options options = adaptive(known, 0.15);
    const FinishedRun first(known, options);
    for (const Vector& shift : {Vector(0.05, 0, 0), Vector(0, 0.05, 0), Vector(0, 0, -0.05), Vector(0.03, -0.03, 0.03)}) {
        SCOPED_TRACE(shift.transpose());
        options.earlier = touches_of(first.result(), shift);
        EXPECT_THROW(FinishedRun(known, options), ContradictionError);
    }
}

// A flat-sided object, whose flat sides show no shift along them: one that the places touched do not show must not be called checked.
TEST(GoingOn, ABoxThatHasMovedIsRefusedOrNotVouchedFor) {
    const Subject& known = subject("rounded_box");
    const Options options = adaptive(known, 0.25);
    const FinishedRun first(known, options);
    int refused = 0;
    for (int k = 0; k < 12; ++k) {
        Options on = options;
        Vector shift = Vector::Zero();
        shift[k % 3] = (k % 2 == 0 ? 1 : -1) * (k < 6 ? 0.05 : 0.2);
        on.earlier = touches_of(first.result(), shift);
        SCOPED_TRACE(shift.transpose());
        try {
            const FinishedRun run(known, on);
            EXPECT_NE(run.result().certificate.find(Premise::Kind::earlier_touches)->state, Premise::State::checked);
        } catch (const ContradictionError&) {
            ++refused;
        } catch (const SeedError&) {
            ++refused;
        }
    }
    EXPECT_GE(refused, 10);
}

// Within the box alone it becomes finer.
TEST(GoingOn, OnlyInABox) {
    const Subject& known = subject("torus");
    Options options = adaptive(known, 0.15);
    const FinishedRun first(known, options);
    options.earlier = touches_of(first.result());
    const Box box{{0.5, -0.6, -0.5}, {1.5, 0.6, 0.5}};
    options.tolerance = 0.0004;
    options.tolerance_box = box;
    const FinishedRun run(known, options);
    expect_right_result(run);
    std::size_t within = 0;
    std::size_t outside = 0;
    for (const Touch& touch : run.result().touches) {
        if (touch.role == Touch::Role::earlier || !touch.sample) continue;
        (box.contains(touch.position, 0.15) ? within : outside) += 1;
    }
    std::cout << within << " new samples in the box, " << outside << " outside\n";
    EXPECT_GT(within, 50U);
    // A sixth of the surface has most of them; the others are audits, and what they lead to.
    EXPECT_LT(outside, within / 2);
}

}  // namespace
}  // namespace palpate::going_on_test
