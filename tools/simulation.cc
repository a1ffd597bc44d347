#include "tools/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "devices/decorators/multi_touch_device.h"
#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/timed_oracle.h"
#include "planner/number_text.h"
#include "sim/area_audit.h"
#include "sim/region_fit.h"
#include "sim/simulated_device.h"
#include "tools/session_surroundings.h"

namespace palpate {
namespace {

Region build_workspace(const WorkspaceSpec& spec, const Box& bounds) {
    if (const auto* ball = std::get_if<Ball>(&spec)) return Region(*ball);
    if (const auto* box = std::get_if<Box>(&spec)) return Region(*box);
    return fitting_workspace(bounds);
}

// So far (mm) at least.
bool is_behind_open_faces(const Box& box, const Box& omega, const Surroundings::OpenFaces& faces, double clearance) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        if (faces.is_open[axis][0] && box.min[k] <= omega.min[k] + clearance) return false;
        if (faces.is_open[axis][1] && box.max[k] >= omega.max[k] - clearance) return false;
    }
    return true;
}

// Throws SetupError unless all that the tool can touch of the object is in the workspace, kClearance of its radius from the boundary.
void check_inside(const ToolObstacle& obstacle, const Surroundings& surroundings) {
    const Region& workspace = surroundings.region();
    const double clearance = kClearance * workspace.radius();
    const auto* const omega = std::get_if<Box>(&workspace.shape());
    for (const Box& box : obstacle.reachable_bounds()) {
        // Beside an area the object goes on; where the tool comes from it may not.
        if (surroundings.area() && omega != nullptr && is_behind_open_faces(box, *omega, surroundings.faces(), clearance)) continue;
        for (unsigned k = 0; k < 8; ++k) {
            const Point corner((k & 1U ? box.max : box.min).x(), (k & 2U ? box.max : box.min).y(), (k & 4U ? box.max : box.min).z());
            if (workspace.contains(corner) && (workspace.nearest_boundary(corner) - corner).norm() > clearance) continue;
            throw SetupError(
                fmt::format("workspace: not all places where the tool may touch the object are well inside it: they reach from {} to {}; "
                            "make the workspace larger",
                            point_text(box.min), point_text(box.max)));
        }
    }
}

// The tool waits on top of the workspace.
Point start_above(const Region& workspace) {
    return workspace.nearest_boundary(workspace.center() + 2 * workspace.radius() * Vector::UnitZ());
}

}  // namespace

Scene build_scene(const SessionConfig& config) {
    if (!config.object) throw SetupError("object: missing; a simulation needs object.mesh or object.shape");
    HiddenObject object(*config.object);
    const std::optional<ToolScene> tool = tool_scene(config, object);
    const Region workspace = build_workspace(config.workspace, tool ? tool->obstacle.bounds() : object.bounds());
    Surroundings surroundings = surroundings_of(config, workspace);
    if (tool) {
        check_inside(tool->obstacle, surroundings);
    } else if (const auto outside = point_outside(object, workspace)) {
        const Box& bounds = object.bounds();
        throw SetupError(
            fmt::format("workspace: the object is not well inside it: it has a point at {}, outside or at the boundary, where the tool "
                        "moves; its bounds are {} to {}; make the workspace larger, or say workspace: auto",
                        point_text(*outside), point_text(bounds.min), point_text(bounds.max)));
    }
    check_options(surroundings, config.probing, config.traits());
    return {std::move(object), std::move(surroundings)};
}

std::optional<ToolScene> tool_scene(const SessionConfig& config, const HiddenObject& object) {
    if (!config.tool && config.fixtures.solids.empty() && !config.area) return std::nullopt;
    ToolObstacle obstacle(object, config.tool, config.fixtures.solids);
    return ToolScene{std::move(obstacle), ToolDepths(object, config.tool, config.fixtures.solids)};
}

const Obstacle& obstacle_of(const HiddenObject& object, const std::optional<ToolScene>& tool) {
    if (tool) return tool->obstacle;
    return object;
}

void check_seeds(const SessionConfig& config, const Scene& scene) {
    const std::optional<ToolScene> tool = tool_scene(config, scene.object);
    SimulatedDevice device(obstacle_of(scene.object, tool), start_above(scene.workspace.region()));
    DeviceOracle oracle(device, config.traits(), DeviceOracle::Positions::exact);
    check_seeds(oracle, scene.workspace, config.probing);
}

Simulation simulate(const SessionConfig& config, const Scene& scene, const Observer& watcher) {
    const std::optional<ToolScene> tool = tool_scene(config, scene.object);
    const Obstacle& obstacle = obstacle_of(scene.object, tool);
    SimulatedDeviceOptions device_options;
    std::optional<ToolAudit> audit;
    std::optional<AreaAudit> area_audit;
    if (tool) {
        // What only grazes may be as deep as the closed form's slack, a share of the lengths involved.
        audit.emplace(tool->depths, std::max(ToolAudit::kTolerance_mm, 4 * MotionAudit::kDepth * obstacle.scale()));
        device_options.audit = !config.tool;  // that account is of points
        if (config.area) area_audit.emplace(*config.area, std::get<Box>(config.workspace), ToolAudit::kTolerance_mm);
        device_options.on_move = [&](const Segment& way, bool touched) {
            audit->record(way, touched);
            if (area_audit) area_audit->record(way);
        };
    }
    device_options.errors = config.probe_errors();
    if (config.machine) device_options.motion = config.machine->motion;
    const auto positions = device_options.errors.is_any() ? DeviceOracle::Positions::as_traits_say : DeviceOracle::Positions::exact;
    SimulatedDevice device(obstacle, start_above(scene.workspace.region()), std::move(device_options));
    std::optional<MultiTouchDevice> measuring;
    if (config.machine && config.errors) measuring.emplace(device, config.machine->touch, config.machine->motion.retract_mm);
    DeviceOracle device_oracle(measuring ? static_cast<ProbeDevice&>(*measuring) : device, config.traits(), positions);
    TimedOracle oracle(device_oracle);
    Observer observer;
    observer.on_progress = watcher.on_progress;
    Simulation run;
    Seconds checking{0};
    observer.on_inference = [&](const Point& near, const Point& far) {
        const Stopwatch watch(checking);
        // A known solid is a clearance larger than its fixture, and ends where nothing in the world does.
        if (scene.workspace.known().contains(far)) return;
        if (obstacle.contains(near) || !obstacle.contains(far)) ++run.wrong_inferences;
    };
    const auto start = std::chrono::steady_clock::now();
    run.result = probe_surface(oracle, scene.workspace, config.probing, observer);
    const Seconds total = std::chrono::steady_clock::now() - start;
    run.oracle_seconds = oracle.spent().count();
    run.planner_seconds = (total - oracle.spent() - checking).count();
    run.unsafe_moves = device.unsafe_moves();
    if (tool) {
        run.tool = audit->account();
        if (area_audit) run.moves_out_of_area = area_audit->moves_out();
        run.unsafe_moves = std::max(run.unsafe_moves, run.tool->unsafe_moves);
    } else {
        run.truth = measure_truth(scene.object, run.result.mesh, TruthSampling{}, config.probing.random_seed);
        run.verdicts = judge_facets(scene.object, run.result.mesh, run.result.dual_edges, config.probing.epsilon);
    }
    run.moves = device.moves();
    run.distance = device.distance();
    run.machine_time = estimate_machine_time(run.result.cost, config.traits().rates);
    return run;
}

}  // namespace palpate
