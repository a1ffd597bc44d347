// Runs with probes that err as real ones do: as long as the planner is told how much, and asked for a mesh that is coarse against it, the
// surface is closed and of the right kind.
#include "devices/decorators/multi_touch_device.h"
#include "devices/device_oracle.h"
#include "sim/truth.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::probe_errors_test {
namespace {

struct ErringRun {
    HiddenObject object;
    SimulatedDevice device;
    Result result;
    double touch_error;

    // `ratio`: of epsilon to the touch error, unless `epsilon` is more.
    ErringRun(const ObjectSpec& spec, const ProbeErrors& errors, double epsilon, double ratio = 20)
        : object(spec), device(object, above(), {.errors = errors}), touch_error(errors.touch_error(MotionModel{}.feeds.probe_mm_per_s)) {
        Options options;
        options.epsilon = std::max(epsilon, ratio * touch_error);
        options.strategy = Strategy::adaptive();
        OracleTraits traits;
        traits.touch_error = touch_error;
        DeviceOracle oracle(device, traits);
        result = probe_surface(oracle, workspace(), options);
    }
    [[nodiscard]] Region workspace() const {
        const Box& bounds = object.bounds();
        return Region(Ball{bounds.center(), 0.6 * bounds.diagonal()});
    }
    [[nodiscard]] Point above() const { return workspace().center() + 1.5 * workspace().radius() * Vector::UnitZ(); }

    void expect_right() const {
        EXPECT_EQ(result.topology.boundary_edges, 0U);
        EXPECT_EQ(result.topology.nonmanifold_edges, 0U);
        EXPECT_EQ(static_cast<int>(result.topology.components), object.components());
        EXPECT_EQ(result.topology.euler_characteristic, object.euler_characteristic());
        EXPECT_EQ(device.unsafe_moves(), 0U);
    }
};

const ShapeSpec kTorus{TorusSpec{20, 8}};
const ShapeSpec kBox{RoundedBoxSpec{{30, 20, 10}, 2.0}};

ProbeErrors spread(double sigma_mm, std::uint64_t seed) {
    ProbeErrors errors;
    errors.sigma_mm = sigma_mm;
    errors.seed = seed;
    return errors;
}

TEST(ErringProbes, AMicrometreAndTenOfSpreadLeaveTheTopologyAsItIs) {
    for (const ShapeSpec& shape : {kTorus, kBox}) {
        for (const double sigma : {0.001, 0.01}) {
            for (const std::uint64_t seed : {1U, 2U}) {
                SCOPED_TRACE(testing::Message() << shape.kind.index() << ", sigma " << sigma << ", seed " << seed);
                const ErringRun run(shape, spread(sigma, seed), 1.0);
                run.expect_right();
                for (const Point& p : run.result.mesh.points) EXPECT_LE(run.object.distance(p), run.touch_error);
            }
        }
    }
}

TEST(ErringProbes, LobesBendingAndBacklashShiftTheSurfaceAndLeaveItsKind) {
    ProbeErrors errors = spread(0.001, 1);
    errors.lobes_mm = 0.01;
    errors.trigger_force_n = 0.1;
    errors.compliance_across_mm_per_n = 0.05;
    errors.backlash_mm = {0.004, 0.006, 0.008};
    errors.latency = Seconds(0.001);
    for (const ShapeSpec& shape : {kTorus, kBox}) {
        SCOPED_TRACE(shape.kind.index());
        const ErringRun run(shape, errors, 1.0);
        run.expect_right();
        double farthest = 0;
        for (const Point& p : run.result.mesh.points) farthest = std::max(farthest, run.object.distance(p));
        EXPECT_LE(farthest, run.touch_error);
        EXPECT_GE(farthest, 0.01) << "the errors are there";
    }
}

TEST(ErringProbes, AMachineThatDriftsProbesASurfaceOfTheSameKind) {
    ProbeErrors errors = spread(0.001, 1);
    errors.drift_mm_per_1000_touches = {0.01, -0.005, 0.02};
    errors.drift_mm_per_hour = {0.002, 0.01, 0.004};
    errors.swing_mm = {0.002, 0.002, 0.002};
    errors.swing_period = Seconds(600);
    const ErringRun run(kTorus, errors, 1.5);
    run.expect_right();
}

}  // namespace
}  // namespace palpate::probe_errors_test
