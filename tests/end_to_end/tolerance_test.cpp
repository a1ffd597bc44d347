// Runs with a tolerance: how near the curved surface comes to the object, and what that costs.
#include <gtest/gtest.h>

#include <iostream>
#include <optional>
#include <string>

#include "planner/curved/curved_surface.h"
#include "sim/region_fit.h"
#include "sim/truth.h"
#include "tests/end_to_end/part_meshes.h"
#include "tests/end_to_end/subjects.h"
#include "tests/end_to_end/temporary_mesh.h"

namespace palpate::tolerance_test {
namespace {

struct Wanted {
    std::string subject;
    double epsilon = 0.0;    // mm
    double tolerance = 0.0;  // mm
    // What it may come to: some 15 % above what was measured. The bunny misses its tolerance at facets that the certificate counts.
    std::uint64_t probes = 0;
    double p99 = 0.0;  // mm
    double max = 0.0;  // mm
};

class Tolerance : public ::testing::TestWithParam<Wanted> {};

TEST_P(Tolerance, IsMetWithFewTouches) {
    const Wanted& wanted = GetParam();
    std::optional<TemporaryMesh> file;
    Subject known{wanted.subject, MeshSpec{}, Region(Ball{Point::Zero(), 1}), {}, {}};
    if (wanted.subject == "cube") {
        file.emplace(box({2, 2, 2}), "tolerance_cube");
        known.object = MeshSpec{file->path()};
        known.workspace = fitting_workspace(HiddenObject(known.object));
    } else {
        known = subject(wanted.subject);
    }
    Options options;
    options.epsilon = wanted.epsilon;
    options.tolerance = wanted.tolerance;
    options.strategy = Strategy::adaptive();
    options.seed_rays = known.seed_rays;
    const FinishedRun run(known, options);
    const Result& r = run.result();
    expect_right_result(run);
    const CurvedSurface curved = curve({r.mesh, {}, {}}, {wanted.epsilon});
    const SurfaceDistances truth = measure_surface(run.object(), curved.mesh, 30'000, 1);
    ASSERT_TRUE(r.deviation);
    const DeviationEvidence& d = *r.deviation;
    std::cout << wanted.subject << ", epsilon " << wanted.epsilon << ", tolerance " << wanted.tolerance << ": " << r.samples << " samples, "
              << r.cost.probes() << " probes, " << r.cost.displacement() << " mm; 99 % within " << truth.p99 << ", all within " << truth.max
              << "; foretold " << d.foretold << ", " << d.unmet_facets << " facets unmet, " << d.beyond << " of " << d.audited
              << " beyond, the worst by " << d.worst << "\n";
    EXPECT_LE(truth.p99, wanted.p99);
    EXPECT_LE(truth.max, wanted.max);
    EXPECT_LE(r.cost.probes(), wanted.probes);
    const Premise* premise = r.certificate.find(Premise::Kind::deviation);
    ASSERT_NE(premise, nullptr);
    EXPECT_EQ(premise->holds(), d.unmet_facets == 0 && d.beyond == 0 && d.foretold <= d.tolerance) << premise->detail;
}

INSTANTIATE_TEST_SUITE_P(
    Objects, Tolerance,
    ::testing::Values(Wanted{"torus", 0.25, 0.003, 410, 0.003, 0.0034}, Wanted{"cube", 0.35, 0.005, 500, 0.005, 0.017},
                      Wanted{"genus2", 0.15, 0.003, 1180, 0.0036, 0.0096}, Wanted{"rounded_box", 0.25, 0.004, 460, 0.0048, 0.0083},
                      Wanted{"two_components", 0.2, 0.004, 220, 0.004, 0.008}, Wanted{"bunny", 0.6, 0.1, 1900, 0.1, 0.19}),
    [](const auto& test) { return test.param.subject + "_" + std::to_string(static_cast<int>(test.param.tolerance * 1e4 + 0.5)); });

TEST(NoTolerance, AsksForNothing) {
    const FinishedRun run(subject("torus"), 0.2, Strategy::adaptive());
    EXPECT_FALSE(run.result().deviation);
    EXPECT_EQ(run.result().certificate.find(Premise::Kind::deviation), nullptr);
}

}  // namespace
}  // namespace palpate::tolerance_test
