// Objects with a known truth, and what any finished run on them must show.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/probe_surface.h"
#include "sim/objects/hidden_object.h"
#include "sim/simulated_device.h"

namespace palpate {

class ProbedSpace;
class ProbingLoop;

struct Subject {
    std::string name;
    ObjectSpec object;
    Region workspace;
    std::vector<double> epsilons;    // mm
    std::vector<Segment> seed_rays;  // empty: the default seeds
};

// sphere, ellipsoid, torus, genus2, rounded_box, two_components, bunny: each at two epsilons.
const std::vector<Subject>& subjects();
const Subject& subject(const std::string& name);

// A finished run with everything that it ran on.
class FinishedRun {
public:
    // Looks at all that is known, after every sample that is not a seed.
    using Look = std::function<void(const ProbedSpace&)>;

    // `reach` (mm): the bound that the planner is told, in place of the true one; an adaptive strategy is told none.
    FinishedRun(const Subject& subject, double epsilon, const Strategy& strategy, const Observer& observer = {},
                std::optional<double> reach = std::nullopt, const Look& look = {});
    FinishedRun(const Subject& subject, const Options& options, const Observer& observer = {}, const Look& look = {},
                const OracleTraits& traits = {});
    ~FinishedRun();

    const HiddenObject& object() const { return *object_; }
    const SimulatedDevice& device() const { return *device_; }
    const ProbedSpace& space() const;
    const Options& options() const { return options_; }
    const Result& result() const { return result_; }
    // Crossings that were inferred, and those of them where S has none.
    std::size_t inferences() const { return inferences_; }
    std::size_t wrong_inferences() const { return wrong_inferences_; }

private:
    // The run keeps references: all stay where they are.
    std::unique_ptr<HiddenObject> object_;
    Region workspace_;
    Options options_;
    Observer observer_;
    std::unique_ptr<SimulatedDevice> device_;
    std::unique_ptr<SurfaceOracle> oracle_;
    std::unique_ptr<ProbingLoop> run_;
    Result result_;
    std::size_t inferences_ = 0;
    std::size_t wrong_inferences_ = 0;
};

// Topology equal to the truth, an oriented closed manifold, balls within epsilon, 0 unsafe moves, and the planner's account
// of motion equal to the device's own.
void expect_right_result(const FinishedRun& run);
// Samples pairwise farther than epsilon apart, seed facets and repairs aside. Quadratic in a grid cell.
void expect_sparse(const FinishedRun& run);
// Every record of an edge at a free vertex against the full list of crossings from the ray caster.
void expect_true_records(const FinishedRun& run);

std::string strategy_name(const Strategy& strategy);
// The four combinations of refine and explore without inference, the default, and adaptive.
std::vector<Strategy> all_strategies();

}  // namespace palpate
