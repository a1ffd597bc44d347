// Too coarse an epsilon: a manifold of the right genus through the extra refinement of planner/DESIGN.md, "Repair", or an honest
// `incomplete`; never a silent defect.
#include "devices/device_oracle.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::coarse_test {
namespace {

void expect_right_or_incomplete(const FinishedRun& run) {
    const Result& r = run.result();
    EXPECT_EQ(run.device().unsafe_moves(), 0U);
    if (r.certificate.status == Certificate::Status::incomplete) {
        EXPECT_FALSE(r.bad_places.empty());
        for (const BadPlace& place : r.bad_places) {
            EXPECT_GT(place.epsilon_needed, 0);
            EXPECT_LE(place.epsilon_needed, run.options().epsilon);
            EXPECT_LT(run.object().distance(place.position), run.options().epsilon);
        }
    } else {
        expect_right_result(run);
    }
}

TEST(Coarse, BunnyAndGenus2) {
    for (const auto& [name, epsilon] : {std::pair{"bunny", 0.47}, {"bunny", 1.0}, {"genus2", 0.2}, {"genus2", 0.3}, {"torus", 0.4}}) {
        for (const Strategy& strategy : all_strategies()) {
            SCOPED_TRACE(std::string(name) + " " + std::to_string(epsilon) + " " + strategy_name(strategy));
            expect_right_or_incomplete(FinishedRun(subject(name), epsilon, strategy));
        }
    }
}

TEST(Coarse, TheFloorIsRespectedAndReported) {
    // A floor of 1 forbids all extra refinement: what stays bad has to be reported.
    bool seen_incomplete = false;
    for (const double epsilon : {0.47, 0.6, 0.8, 1.0, 1.3}) {
        Subject coarse = subject("bunny");
        HiddenObject object(coarse.object);
        SimulatedDevice device(object, {0, 4.8, 10});
        DeviceOracle oracle(device);
        Options options;
        options.epsilon = epsilon;
        options.refinement_floor = 1.0;
        const Result r = probe_surface(oracle, coarse.workspace, options);
        for (const Touch& touch : r.touches) EXPECT_NE(touch.role, Touch::Role::repair);
        // Bad places are defects, or touches that no facet uses.
        EXPECT_EQ(r.certificate.status == Certificate::Status::incomplete, !r.bad_places.empty());
        EXPECT_GE(r.bad_places.size(), r.topology.defects.size());
        seen_incomplete |= !r.bad_places.empty();
    }
    EXPECT_TRUE(seen_incomplete) << "no epsilon was coarse enough to test anything";
}

}  // namespace
}  // namespace palpate::coarse_test
