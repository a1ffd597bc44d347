// What a part costs whose reach nobody knows: touches and way per sample, and how many facets are wrong.
#include <cmath>
#include <iostream>

#include "planner/errors.h"
#include "sim/facet_truth.h"
#include "sim/region_fit.h"
#include "tests/end_to_end/part_meshes.h"
#include "tests/end_to_end/random_parts.h"
#include "tests/end_to_end/subjects.h"
#include "tests/end_to_end/temporary_mesh.h"
#include "tests/random.h"

namespace palpate::touches_test {
namespace {

struct Part {
    std::string name;
    TriangleMesh mesh;  // empty: the subject of that name
    double epsilon = 0.0;
    // What it may cost: some 8 % above what was measured.
    double probes = 0.0;   // per sample
    double way = 0.0;      // in ε per sample
    double wrong = 0.005;  // share of all facets
    double bound = 1.42;   // samples, in those of the hexagonal bound
};

std::vector<Point> curve(int n, double turns, Point (*at)(double)) {
    std::vector<Point> points;
    for (int k = 0; k < n; ++k) points.push_back(at(kTwoPi * turns * k / n));
    return points;
}

Point on_spring(double t) { return {std::cos(t), std::sin(t), 0.6 * t / kTwoPi}; }
Point on_knot(double t) {
    return {0.5 * (std::sin(t) + 2 * std::sin(2 * t)), 0.5 * (std::cos(t) - 2 * std::cos(2 * t)), -0.6 * std::sin(3 * t)};
}

// A box of 3 × 2 × 1 with a pocket and a through hole.
TriangleMesh pocketed() {
    std::set<std::array<int, 3>> cells;
    for (int i = 0; i < 5; ++i) {
        for (int j = 0; j < 5; ++j) {
            for (int k = 0; k < 2; ++k) {
                const bool is_pocket = i == 1 && j >= 1 && j <= 3 && k == 1;
                const bool is_hole = i == 3 && j == 2;
                if (!is_pocket && !is_hole) cells.insert({i, j, k});
            }
        }
    }
    return of_cells({{{-1.5, -1.2, -0.2, 0.4, 1.1, 1.5}, {-1, -0.6, -0.3, 0.3, 0.6, 1}, {-0.5, 0, 0.5}}}, cells);
}

TriangleMesh slotted() {
    return of_cells({{{-1, -0.06, 0.06, 1}, {-0.6, 0.6}, {-0.6, -0.1, 0.5}}}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}, {2, 0, 1}});
}

const std::vector<Part>& parts() {
    static const std::vector<Part> all{
        {"torus", {}, 0.05, 1.06, 4.1},
        {"genus2", {}, 0.03, 1.06, 4.0},
        {"rounded_box", {}, 0.06, 1.06, 4.0},
        {"two_components", {}, 0.065, 1.09, 5.0},
        {"knotted_tube", tube_along(curve(400, 1, on_knot), 0.22, 40, true), 0.06, 1.13, 4.5},
        {"spring", tube_along(curve(240, 3, on_spring), 0.2, 24, false), 0.05, 1.16, 5.0},
        {"cube", box({2, 2, 2}), 0.1, 1.3, 4.8, 0.005, 1.7},
        {"cone", cone(256, 1, 2), 0.08, 1.38, 6.5, 0.005, 1.7},
        {"box_with_pocket_and_hole", pocketed(), 0.09, 1.48, 6.0, 0.005, 1.7},
        {"slot", slotted(), 0.1, 2.0, 9.5, 0.005, 1.7},
        {"plate", box({10, 10, 0.75}), 0.5, 2.3, 12.5, 0.012, 1.7},
        {"bunny_fine", {}, 0.15, 1.15, 4.6},
        {"bunny", {}, 0.25, 1.42, 6.7, 0.008},
        {"bunny_coarse", {}, 0.4, 2.8, 12.5, 0.016, 1.7},
    };
    return all;
}

struct Measured {
    double probes = 0.0;
    double way = 0.0;
    double bound = 0.0;
    double wrong = 0.0;
};

Measured measure(const FinishedRun& run) {
    const Result& r = run.result();
    const double epsilon = run.options().epsilon;
    const auto samples = static_cast<double>(r.samples);
    const auto verdicts = judge_facets(run.object(), r.mesh, r.dual_edges, epsilon);
    return {static_cast<double>(r.cost.probes()) / samples, r.cost.displacement() / epsilon / samples, samples / r.lower_bound_samples,
            static_cast<double>(std::ranges::count(verdicts, FacetVerdict::wrong)) / static_cast<double>(verdicts.size())};
}

void expect_cheap(const Part& part, double epsilon, std::uint64_t seed) {
    std::optional<TemporaryMesh> file;
    if (!part.mesh.points.empty()) file.emplace(part.mesh, part.name);
    Subject known = file ? Subject{part.name, MeshSpec{file->path()}, Region(Ball{Point::Zero(), 1}), {}, {}}
                         : subject(part.name.starts_with("bunny") ? "bunny" : part.name);
    if (file) known.workspace = fitting_workspace(HiddenObject(known.object));
    Options options;
    options.epsilon = epsilon;
    options.strategy = Strategy::adaptive();
    options.seed_rays = known.seed_rays;
    options.random_seed = seed;
    const FinishedRun run(known, options);
    expect_right_result(run);
    EXPECT_LE(run.result().max_plausible_ball_radius, epsilon);
    const Measured m = measure(run);
    std::cout << part.name << ", epsilon " << epsilon << ": " << m.probes << " probes per sample, " << m.way << " epsilon of way, "
              << m.bound << " of the bound, " << 100 * m.wrong << " % of the facets wrong\n";
    EXPECT_LE(m.probes, part.probes);
    EXPECT_LE(m.way, part.way);
    EXPECT_LE(m.wrong, part.wrong);
    EXPECT_LE(m.bound, part.bound);
}

class TouchesPerSample : public ::testing::TestWithParam<Part> {};

TEST_P(TouchesPerSample, AreHardlyMoreThanOne) { expect_cheap(GetParam(), GetParam().epsilon, 1); }

const auto kName = [](const auto& test) { return test.param.name; };

INSTANTIATE_TEST_SUITE_P(Parts, TouchesPerSample, ::testing::ValuesIn(parts()), kName);

class NightlyTouches : public ::testing::TestWithParam<Part> {};

TEST_P(NightlyTouches, AreHardlyMoreThanOne) {
    Part part = GetParam();
    part.probes *= 1.1;
    part.way *= 1.15;
    part.wrong *= 1.5;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        for (const double factor : {0.9, 1.0, 1.1}) expect_cheap(part, factor * part.epsilon, seed);
    }
}

INSTANTIATE_TEST_SUITE_P(Parts, NightlyTouches, ::testing::ValuesIn(parts()), kName);

// Parts at random, at an ε of 2.5 % of their diagonal.
TEST(NightlyRandomParts, HalfOfThemNeedFewTouches) {
    std::vector<double> probes;
    std::vector<double> ways;
    std::vector<double> wrong;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        const RandomPart part = random_part(seed);
        const TemporaryMesh file(part.mesh, "touches" + std::to_string(seed) + "_");
        const MeshSpec object{file.path()};
        const HiddenObject hidden(object);
        Options options;
        options.epsilon = 0.025 * hidden.bounds().diagonal();
        options.seed_rays = part.seed_rays;
        try {
            const FinishedRun run({part.kind, object, fitting_workspace(hidden), {}, {}}, options);
            const Measured m = measure(run);
            std::cout << seed << ", " << part.kind << ", feature " << part.feature / options.epsilon << " epsilon: " << m.probes
                      << " probes, " << m.way << " epsilon, " << 100 * m.wrong << " % wrong\n";
            probes.push_back(m.probes);
            ways.push_back(m.way);
            wrong.push_back(m.wrong);
            EXPECT_EQ(run.device().unsafe_moves(), 0U);
        } catch (const SeedError& error) {
            EXPECT_LT(part.feature, options.epsilon) << error.what();
        }
    }
    const auto quantile = [](std::vector<double>& values, double share) {
        std::ranges::sort(values);
        return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
    };
    std::cout << "probes: median " << quantile(probes, 0.5) << ", 90 % " << quantile(probes, 0.9) << "; way: median " << quantile(ways, 0.5)
              << ", 90 % " << quantile(ways, 0.9) << "; wrong: median " << quantile(wrong, 0.5) << ", 90 % " << quantile(wrong, 0.9)
              << '\n';
    EXPECT_LE(quantile(probes, 0.5), 2.0);
}

// The bound that the certificate states on the share of wrong facets is to hold in 95 of 100 runs.
TEST(NightlyAudits, TheBoundHolds) {
    int holds = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        Options options;
        options.epsilon = 0.4;
        options.random_seed = seed;
        const FinishedRun run(subject("bunny"), options);
        const Result& r = run.result();
        const auto verdicts = judge_facets(run.object(), r.mesh, r.dual_edges, options.epsilon);
        std::size_t plausible = 0;
        std::size_t wrong = 0;
        for (std::size_t t = 0; t < verdicts.size(); ++t) {
            if (r.confidences[t] == 1) continue;
            ++plausible;
            wrong += verdicts[t] == FacetVerdict::right ? 0 : 1;
        }
        const std::string& detail = r.certificate.find(Premise::Kind::inference)->detail;
        const double percent = std::stod(detail.substr(detail.find("at most ") + 8));
        holds += 100.0 * static_cast<double>(wrong) <= percent * static_cast<double>(plausible) ? 1 : 0;
    }
    std::cout << holds << " of 200 hold\n";
    EXPECT_GE(holds, 190);
}

}  // namespace
}  // namespace palpate::touches_test
