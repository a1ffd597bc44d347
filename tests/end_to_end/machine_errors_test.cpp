// What a machine adds to an exact ray caster, one thing at a time: numbers of three decimals, a retract after every touch, touches
// that cannot be measured. The planner must come to the same topology.
#include <set>

#include "devices/device_oracle.h"
#include "sim/truth.h"
#include "tests/end_to_end/subjects.h"
#include "tests/random.h"

namespace palpate::machine_errors_test {
namespace {

constexpr double kResolution_mm = 0.001;

// Rounds what it is told and what it tells, rests before what it touched, and now and then cannot measure a touch.
class RoughDevice final : public ProbeDevice {
public:
    RoughDevice(ProbeDevice& exact, double retract, double failing = 0, std::uint64_t seed = 1)
        : exact_(exact), retract_(retract), failing_(failing), random_(seed) {}

    [[nodiscard]] Point position() const override { return exact_.position(); }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        const Point start = exact_.position();
        MoveResult result = exact_.guarded_move(rounded(target), pace);
        if (result.outcome == MoveResult::Outcome::reached) return {result.outcome, target};
        const Point touched = result.position;
        const double length = (start - touched).norm();
        if (length > 0) (void)exact_.guarded_move(rounded(touched + std::min(retract_, length) / length * (start - touched)), Pace::travel);
        const bool fails = pace == Pace::probe && (random_.chance(failing_) || (hole && (touched - *hole).norm() < hole_radius));
        failed += fails ? 1 : 0;
        return {fails ? MoveResult::Outcome::failed : MoveResult::Outcome::contact, rounded(touched)};
    }
    void stop() override { exact_.stop(); }

    std::size_t failed = 0;
    std::optional<Point> hole;  // around which nothing can be measured
    double hole_radius = 0;

private:
    [[nodiscard]] static Point rounded(const Point& p) { return (p / kResolution_mm).array().round() * kResolution_mm; }

    ProbeDevice& exact_;
    const double retract_;
    const double failing_;
    Random random_;
};

struct RoughRun {
    HiddenObject object;
    SimulatedDevice exact;
    RoughDevice device;
    Result result;

    RoughRun(const Subject& subject, double epsilon, const Strategy& strategy, double retract, double failing = 0,
             std::optional<Point> hole = {}, double hole_radius = 0)
        : object(subject.object),
          exact(object, subject.workspace.nearest_boundary(subject.workspace.center() + 2 * subject.workspace.radius() * Vector::UnitZ())),
          device(exact, retract, failing) {
        device.hole = hole;
        device.hole_radius = hole_radius;
        Options options;
        options.epsilon = epsilon;
        options.strategy = strategy;
        options.seed_rays = subject.seed_rays;
        if (strategy.infer == Strategy::Infer::automatic) options.reach = object.reach();
        DeviceOracle oracle(device, {.touch_error = 2 * kResolution_mm, .retract = retract, .overtravel = {}, .rates = {}});
        result = probe_surface(oracle, subject.workspace, options);
    }
};

TEST(MachineErrors, ThreeDecimalsAndARetractLeaveTheTopologyAsItIs) {
    for (const Subject& subject : subjects()) {
        const double epsilon = subject.epsilons.front();
        for (const Strategy& strategy : all_strategies()) {
            for (const double retract : {0.0, 0.3}) {
                SCOPED_TRACE(subject.name + ", " + strategy_name(strategy) + ", retract " + std::to_string(retract));
                const RoughRun run(subject, epsilon, strategy, retract);
                EXPECT_EQ(run.result.topology.euler_characteristic, run.object.euler_characteristic());
                EXPECT_EQ(static_cast<int>(run.result.topology.components), run.object.components());
                EXPECT_EQ(run.result.topology.boundary_edges, 0U);
                EXPECT_EQ(run.result.topology.nonmanifold_edges, 0U);
                EXPECT_NE(run.result.certificate.status, Certificate::Status::refuted) << "the bound is true, only the touches are rough";
                EXPECT_EQ(run.exact.unsafe_moves(), 0U);
                if (retract == 0.0) continue;  // Hausdorff distances take longest
                const FinishedRun direct(subject, epsilon, strategy);
                const auto hausdorff = [&](const Result& r) { return measure_truth(run.object, r.mesh, TruthSampling{}, 1).hausdorff; };
                // What ε leaves, ε² / reach where that is known, and the resolution.
                EXPECT_LE(hausdorff(run.result),
                          1.5 * hausdorff(direct.result()) + 4 * kResolution_mm + (run.object.reach() ? 0 : epsilon));
            }
        }
    }
}

TEST(MachineErrors, TouchesThatFailNowAndThenAreLeftOutAndTheRestGoesOn) {
    for (const Strategy& strategy : all_strategies()) {
        SCOPED_TRACE(strategy_name(strategy));
        const RoughRun run(subject("torus"), 0.12, strategy, 0.05, 0.02);
        EXPECT_GT(run.device.failed, 3U);
        EXPECT_EQ(run.result.cost.failed, run.device.failed);
        // Most of it is there, whatever single edges could not be closed.
        EXPECT_GT(run.result.topology.facets, 0.9 * 2 * static_cast<double>(run.result.samples));
        EXPECT_EQ(run.exact.unsafe_moves(), 0U);
        const auto& premises = run.result.certificate.premises;
        const bool said = std::any_of(premises.begin(), premises.end(),
                                      [](const Premise& p) { return p.detail.find("places could not be measured") != std::string::npos; });
        EXPECT_TRUE(said);
    }
}

TEST(MachineErrors, APlaceThatCannotBeMeasuredEndsIncompleteAndSaysWhere) {
    const Point hole(1.4, 0, 0);
    const RoughRun run(subject("torus"), 0.12, Strategy{}, 0.05, 0, hole, 0.2);
    EXPECT_EQ(run.result.certificate.status, Certificate::Status::incomplete);
    EXPECT_GT(run.result.topology.boundary_edges, 0U);
    ASSERT_FALSE(run.result.bad_places.empty());
    for (const BadPlace& place : run.result.bad_places) EXPECT_LT((place.position - hole).norm(), 0.5) << place.what;
    EXPECT_GT(run.result.topology.facets, 1000U) << "the rest is there";
}

}  // namespace
}  // namespace palpate::machine_errors_test
