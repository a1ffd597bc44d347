#include "tools/simulation.h"

#include <fmt/format.h>

#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/timed_oracle.h"
#include "planner/number_text.h"
#include "sim/region_fit.h"
#include "sim/simulated_device.h"

namespace palpate {
namespace {

Region build_workspace(const WorkspaceSpec& spec, const HiddenObject& object) {
    if (const auto* ball = std::get_if<Ball>(&spec)) return Region(*ball);
    if (const auto* box = std::get_if<Box>(&spec)) return Region(*box);
    return fitting_workspace(object);
}

// The tool waits on top of the workspace.
Point start_above(const Region& workspace) {
    return workspace.nearest_boundary(workspace.center() + 2 * workspace.radius() * Vector::UnitZ());
}

}  // namespace

Scene build_scene(const SessionConfig& config) {
    if (!config.object) throw SetupError("object: missing; a simulation needs object.mesh or object.shape");
    HiddenObject object(*config.object);
    Region workspace = build_workspace(config.workspace, object);
    if (const auto outside = point_outside(object, workspace)) {
        const Box& bounds = object.bounds();
        throw SetupError(
            fmt::format("workspace: the object is not well inside it: it has a point at {}, outside or at the boundary, where the tool "
                        "moves; its bounds are {} to {}; make the workspace larger, or say workspace: auto",
                        point_text(*outside), point_text(bounds.min), point_text(bounds.max)));
    }
    check_options(workspace, config.probing, config.traits());
    return {std::move(object), std::move(workspace)};
}

void check_seeds(const SessionConfig& config, const Scene& scene) {
    SimulatedDevice device(scene.object, start_above(scene.workspace));
    DeviceOracle oracle(device, config.traits(), DeviceOracle::Positions::exact);
    check_seeds(oracle, scene.workspace, config.probing);
}

Simulation simulate(const SessionConfig& config, const Scene& scene, const Observer& watcher) {
    SimulatedDevice device(scene.object, start_above(scene.workspace));
    DeviceOracle device_oracle(device, config.traits(), DeviceOracle::Positions::exact);
    TimedOracle oracle(device_oracle);
    Observer observer;
    observer.on_progress = watcher.on_progress;
    Simulation run;
    Seconds checking{0};
    observer.on_inference = [&](const Point& near, const Point& far) {
        const Stopwatch watch(checking);
        if (scene.object.contains(near) || !scene.object.contains(far)) ++run.wrong_inferences;
    };
    const auto start = std::chrono::steady_clock::now();
    run.result = probe_surface(oracle, scene.workspace, config.probing, observer);
    const Seconds total = std::chrono::steady_clock::now() - start;
    run.oracle_seconds = oracle.spent().count();
    run.planner_seconds = (total - oracle.spent() - checking).count();
    run.truth = measure_truth(scene.object, run.result.mesh, TruthSampling{}, config.probing.random_seed);
    run.verdicts = judge_facets(scene.object, run.result.mesh, run.result.dual_edges, config.probing.epsilon);
    run.unsafe_moves = device.unsafe_moves();
    run.moves = device.moves();
    run.distance = device.distance();
    run.machine_time = estimate_machine_time(run.result.cost, config.traits().rates);
    return run;
}

}  // namespace palpate
