// Thin, sharp and planar parts: a right mesh, or one that names what it leaves out or could not do.
#include "planner/errors.h"
#include "planner/loop/effort.h"
#include "sim/region_fit.h"
#include "tests/end_to_end/part_meshes.h"
#include "tests/end_to_end/random_parts.h"
#include "tests/end_to_end/subjects.h"
#include "tests/end_to_end/temporary_mesh.h"
#include "tests/random.h"

namespace palpate::parts_test {
namespace {

std::vector<Strategy> four_strategies() {
    return {Strategy::thesis(),
            {Strategy::Refine::eager, Strategy::Explore::exhaustive, Strategy::Infer::none, Strategy::Travel::voronoi},
            {.infer = Strategy::Infer::none},
            Strategy::adaptive()};
}

// Closed, oriented and manifold with the object's topology; or places are named: those that the mesh leaves out (`is_fine`: it may do
// nothing else), or those where it is not right.
void expect_right_or_named(const FinishedRun& run, bool is_fine) {
    const Result& r = run.result();
    EXPECT_EQ(run.device().unsafe_moves(), 0U);
    EXPECT_LE(r.cost.probes(), Effort::kTries + 40 * r.samples);
    for (const auto* places : {&r.bad_places, &r.thin_places}) {
        for (const BadPlace& place : *places) {
            EXPECT_GT(place.epsilon_needed, 0) << place.what;
            EXPECT_LE(place.epsilon_needed, run.options().epsilon) << place.what;
        }
    }
    if (r.certificate.status == Certificate::Status::incomplete) {
        EXPECT_FALSE(is_fine) << r.certificate.statement;
        EXPECT_FALSE(r.bad_places.empty());
        EXPECT_LE(r.topology.boundary_edges + r.topology.nonmanifold_edges, 6 * r.bad_places.size());
        return;
    }
    EXPECT_TRUE(r.topology.is_closed_oriented_manifold());
    EXPECT_LE(r.max_ball_radius, run.options().epsilon);
    EXPECT_EQ(r.certificate.status, Certificate::Status::conditional);
    const bool is_true = r.topology.euler_characteristic == run.object().euler_characteristic() &&
                         static_cast<int>(r.topology.components) == run.object().components();
    EXPECT_TRUE(is_true || !is_fine) << "Euler characteristic " << r.topology.euler_characteristic << ", not "
                                     << run.object().euler_characteristic() << "; " << r.topology.components << " components";
    EXPECT_NE(r.certificate.statement.find("narrower than about epsilon"), std::string::npos);
}

// --- parts at random -------------------------------------------------------------------------------------------------

void run_part(std::uint64_t seed, const std::vector<double>& factors, const std::vector<Strategy>& strategies) {
    const RandomPart part = random_part(seed);
    const TemporaryMesh file(part.mesh, "part" + std::to_string(seed) + "_");
    const MeshSpec object{file.path()};
    const Subject subject{part.kind, object, fitting_workspace(HiddenObject(object)), {}, part.seed_rays};
    for (const double factor : factors) {
        const double epsilon = factor * part.epsilon;
        for (const Strategy& strategy : strategies) {
            SCOPED_TRACE(seed_text(seed) + ", " + part.kind + ", feature " + std::to_string(part.feature / epsilon) + " epsilon, " +
                         std::to_string(factor) + ", " + strategy_name(strategy));
            try {
                expect_right_or_named(FinishedRun(subject, epsilon, strategy), part.feature > 2 * epsilon);
            } catch (const SeedError& error) {
                EXPECT_LT(part.feature, epsilon) << error.what();  // a needle, say, that four touches that far apart do not span
            }
        }
    }
}

class RandomParts : public ::testing::TestWithParam<std::uint64_t> {};

// Every part with one strategy: all kinds meet all strategies.
TEST_P(RandomParts, EndRightOrNamed) {
    const std::uint64_t seed = GetParam();
    run_part(seed, {1.0}, {four_strategies()[seed / 11 % 4]});
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomParts, ::testing::Range<std::uint64_t>(1, 61));

class NightlyParts : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(NightlyParts, EndRightOrNamed) { run_part(GetParam(), {0.7, 1.0, 1.4}, four_strategies()); }

INSTANTIATE_TEST_SUITE_P(Seeds, NightlyParts, ::testing::Range<std::uint64_t>(1, 501));

// --- parts that users had trouble with -------------------------------------------------------------------------------

FinishedRun run_file(const std::string& name, double epsilon, const Strategy& strategy) {
    const MeshSpec object{PALPATE_TEST_DATA "/cases/" + name};
    return {Subject{name, object, fitting_workspace(HiddenObject(object)), {}, {}}, epsilon, strategy};
}

class NightlyPartsThatAreThin : public ::testing::TestWithParam<Strategy> {};

class Cases : public ::testing::TestWithParam<Strategy> {};

TEST_P(Cases, TwoPlatesWithAGapOfAThirdOfEpsilon) { expect_right_or_named(run_file("two_plates_gap0.1.off", 0.3, GetParam()), false); }

TEST_P(Cases, ASlotNarrowerThanEpsilon) { expect_right_or_named(run_file("u_slot_gap0.2.off", 0.3, GetParam()), false); }

FinishedRun run_object(const std::string& name, const ObjectSpec& object, double epsilon, const Strategy& strategy) {
    return {Subject{name, object, fitting_workspace(HiddenObject(object)), {}, {}}, epsilon, strategy};
}

void expect_effort(const FinishedRun& run) {
    expect_right_or_named(run, false);
    EXPECT_LE(static_cast<double>(run.result().cost.probes()), 25.0 * static_cast<double>(run.result().samples));
}

TEST_P(Cases, APipeWhoseWallIsThinnerThanEpsilon) {
    const TemporaryMesh file(extruded({regular(24, 2), regular(24, 1.8)}, 5), "pipe");
    expect_effort(run_object("pipe", MeshSpec{file.path()}, 0.5, GetParam()));
}

// The two sheets are farther apart than epsilon at three of it from their edge.
TEST_P(Cases, ASharpEdgeEndsClosedAtEveryEpsilon) {
    for (const double epsilon : {0.15, 0.2, 0.3, 0.4, 0.5}) {
        SCOPED_TRACE(epsilon);
        expect_right_or_named(run_file("wedge_30deg.off", epsilon, GetParam()), true);
    }
}

TEST_P(Cases, ACubeWithAReflexCorner) {
    const TemporaryMesh file(cut_cube(40), "cut_cube");
    const MeshSpec object{file.path()};
    const FinishedRun run(Subject{"cut cube", object, fitting_workspace(HiddenObject(object)), {}, {}}, 1.73, GetParam());
    expect_right_result(run);
}

TEST_P(Cases, AnExactOracleIsNeverToldThatItContradictsItself) {
    expect_right_or_named(run_object("plate", ShapeSpec{RoundedBoxSpec{{4, 4, 0.1}, 0.0}}, 0.5, GetParam()), false);
}

// The same with four and six times the surface.
TEST_P(NightlyPartsThatAreThin, EndRightOrNamed) {
    expect_effort(run_file("pipe_wall0.2.off", 0.5, GetParam()));
    expect_right_or_named(run_object("plate", ShapeSpec{RoundedBoxSpec{{10, 10, 0.1}, 0.0}}, 0.5, GetParam()), false);
}

INSTANTIATE_TEST_SUITE_P(Strategies, NightlyPartsThatAreThin, ::testing::ValuesIn(four_strategies()),
                         [](const auto& test) { return test.index == 0 ? "thesis" : strategy_name(test.param); });

INSTANTIATE_TEST_SUITE_P(Strategies, Cases, ::testing::ValuesIn(four_strategies()),
                         [](const auto& test) { return test.index == 0 ? "thesis" : strategy_name(test.param); });

}  // namespace
}  // namespace palpate::parts_test
