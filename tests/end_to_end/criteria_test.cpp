// Sizing fields, angles and budgets in every strategy (thesis 5.3, 5.4).
#include <cmath>
#include <numbers>

#include "tests/end_to_end/subjects.h"

namespace palpate::criteria_test {
namespace {

double smallest_angle(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    double smallest = std::numbers::pi;
    for (std::size_t k = 0; k < 3; ++k) {
        const Point& at = mesh.points[t.at(k)];
        const Vector u = (mesh.points[t.at((k + 1) % 3)] - at).normalized();
        const Vector v = (mesh.points[t.at((k + 2) % 3)] - at).normalized();
        smallest = std::min(smallest, std::acos(std::clamp(u.dot(v), -1.0, 1.0)));
    }
    return smallest;
}

Options torus_options(const Strategy& strategy) {
    Options options;
    options.epsilon = 0.1;
    options.strategy = strategy;
    if (strategy.infer == Strategy::Infer::automatic) options.reach = 0.4;
    return options;
}

class Refined : public ::testing::TestWithParam<Strategy> {};

TEST_P(Refined, NearARegionOfInterest) {
    Options options = torus_options(GetParam());
    const Box box{{1.2, -0.25, -0.25}, {1.5, 0.25, 0.25}};
    options.sizing.regions = {{box, 0.025, 0.5}};
    options.min_angle = std::numbers::pi / 6;
    const FinishedRun run(subject("torus"), options);
    expect_right_result(run);
    const Result& r = run.result();
    const auto size = [&](const Point& p) {
        const Point nearest = p.cwiseMax(box.min).cwiseMin(box.max);
        return std::min(options.epsilon, 0.025 + 0.5 * (p - nearest).norm());
    };
    std::vector<Point> seeds;
    for (const Touch& touch : r.touches) {
        if (touch.role == Touch::Role::seed || touch.role == Touch::Role::seed_facet) seeds.push_back(touch.position);
    }
    std::size_t fine = 0;
    for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t) {
        const auto& corners = r.mesh.triangles[t];
        const Point centroid = (r.mesh.points[corners[0]] + r.mesh.points[corners[1]] + r.mesh.points[corners[2]]) / 3;
        // The field is known at the ball's centre, which is as near as the ball is large.
        EXPECT_LE(r.ball_radii[t], size(centroid) + 0.5 * r.ball_radii[t]);
        if (r.ball_radii[t] < 0.04) ++fine;
        const bool at_seed = std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
            return std::find(seeds.begin(), seeds.end(), r.mesh.points[v]) != seeds.end();
        });
        if (!at_seed) {
            EXPECT_GE(smallest_angle(r.mesh, corners), options.min_angle - 1e-9);
        }
    }
    EXPECT_GT(fine, 50U);
    const FinishedRun coarse(subject("torus"), torus_options(GetParam()));
    EXPECT_GT(r.samples, coarse.result().samples + 200) << "there";
    EXPECT_LT(r.samples, coarse.result().samples * 2) << "and only there";
    EXPECT_EQ(
        std::count_if(r.certificate.premises.begin(), r.certificate.premises.end(),
                      [](const Premise& p) { return p.kind == Premise::Kind::sizing_and_angles && p.state == Premise::State::checked; }),
        1);
}

TEST_P(Refined, WhereTheSurfaceBends) {
    // A long ellipsoid: it bends at its tips, where the radius of curvature is 0.125, and hardly elsewhere.
    Subject tips{"tips", ShapeSpec{EllipsoidSpec{{2, 0.5, 0.5}}}, Region(Ball{Point::Zero(), 2.3}), {}, {}};
    Options options;
    options.epsilon = 0.15;
    options.strategy = GetParam();
    if (options.strategy.infer == Strategy::Infer::automatic) options.reach = 0.125;
    options.sizing.radii_of_curvature = 0.35;
    const FinishedRun run(tips, options);
    expect_right_result(run);
    const Result& r = run.result();
    double at_tips = 0;
    double elsewhere = 0;
    for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t) {
        const double x = std::abs(r.mesh.points[r.mesh.triangles[t][0]].x());
        if (x > 1.95) at_tips = std::max(at_tips, r.ball_radii[t]);
        if (x < 0.5) elsewhere = std::max(elsewhere, r.ball_radii[t]);
    }
    EXPECT_LT(at_tips, 0.08);
    EXPECT_GT(elsewhere, 0.1);
}

TEST_P(Refined, ABudgetEndsTheRunWithWhatItKnows) {
    for (const auto& [key, budget] :
         {std::pair{"400 probes", Budget{400, {}, {}}}, {"80 mm", Budget{{}, 80, {}}}, {"200 s", Budget{{}, {}, 200}}}) {
        SCOPED_TRACE(key);
        Options options = torus_options(GetParam());
        options.budget = budget;
        const FinishedRun run(subject("torus"), options);
        const Result& r = run.result();
        EXPECT_EQ(r.certificate.status, Certificate::Status::incomplete);
        EXPECT_NE(r.certificate.statement.find(key), std::string::npos) << r.certificate.statement;
        EXPECT_EQ(run.device().unsafe_moves(), 0U);
        EXPECT_GT(r.topology.facets, 0U);
        if (budget.probes) {
            EXPECT_GE(r.cost.probes(), 400U);
            EXPECT_LE(r.cost.probes(), 410U) << "what is under way is finished";
        }
        if (budget.machine_time) {
            EXPECT_GE(estimate_machine_time(r.cost, MachineRates{}).count(), 200);
            EXPECT_LE(estimate_machine_time(r.cost, MachineRates{}).count(), 220);
            OracleTraits slow;
            slow.rates.touch = Seconds(10);
            EXPECT_LT(FinishedRun(subject("torus"), options, {}, {}, slow).result().cost.contact, 21U) << "a slow machine touches less";
        }
        if (budget.displacement) {
            EXPECT_GE(r.cost.displacement(), 80);
            EXPECT_LE(r.cost.displacement(), 95);
        }
    }
    // One that is not used up changes nothing.
    Options options = torus_options(GetParam());
    const FinishedRun free(subject("torus"), options);
    options.budget = {1'000'000, 1e9, 1e9};
    const FinishedRun run(subject("torus"), options);
    EXPECT_EQ(run.result().samples, free.result().samples);
    EXPECT_EQ(run.result().cost.probes(), free.result().cost.probes());
    expect_right_result(run);
}

INSTANTIATE_TEST_SUITE_P(Strategies, Refined, ::testing::ValuesIn(all_strategies()),
                         [](const auto& test) { return strategy_name(test.param); });

}  // namespace
}  // namespace palpate::criteria_test
