// Runs the planner on a hidden object: what `palpate simulate` and `palpate bench` have in common.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "planner/probe_surface.h"
#include "sim/facet_truth.h"
#include "sim/objects/hidden_object.h"
#include "sim/tool/tool_audit.h"
#include "sim/tool/tool_obstacle.h"
#include "sim/truth.h"

namespace palpate {

// The object and workspace that a configuration names, fit for each other.
struct Scene {
    HiddenObject object;
    Surroundings workspace;
};

// Throws SetupError if there is no object to simulate, or it is not inside the workspace; ObjectError on a bad object.
[[nodiscard]] Scene build_scene(const SessionConfig& config);

// The tool and the fixtures of a configuration, and what they make of the object that they meet.
struct ToolScene {
    ToolObstacle obstacle;
    ToolDepths depths;
};

// Nothing where the configuration has neither: the object itself is what a point meets. `object` must outlive the result. Throws as
// ToolObstacle does.
[[nodiscard]] std::optional<ToolScene> tool_scene(const SessionConfig& config, const HiddenObject& object);
// What the machine's reference point cannot enter.
[[nodiscard]] const Obstacle& obstacle_of(const HiddenObject& object, const std::optional<ToolScene>& tool);

// Lets the planner touch its seeds, by ray casting: would simulate() begin? Throws what check_seeds of the planner throws.
void check_seeds(const SessionConfig& config, const Scene& scene);

// Of the object's surface: that many tell the distance of 99 in 100 within a few parts in a hundred.
inline constexpr std::size_t kCurvedTruthPoints = 30'000;

struct Simulation {
    Result result;
    // With a tool, fixtures or an area another surface than the object's is probed, and there is none.
    std::optional<Truth> truth;
    std::optional<SurfaceDistances> curved_truth;    // of surface.ply, where there is one
    std::vector<FacetVerdict> verdicts;              // by triangle of the result; none without the truth
    std::optional<ToolAccount> tool;                 // with a tool, fixtures or an area
    std::optional<std::uint64_t> moves_out_of_area;  // with an area
    std::uint64_t wrong_inferences = 0;              // crossings that were inferred where the surface that is probed has none
    std::uint64_t unsafe_moves = 0;                  // counted by the simulator, not by the planner
    std::uint64_t moves = 0;                         // likewise
    double distance = 0.0;                           // mm, likewise
    Seconds machine_time{0.0};                       // what a machine would take for it
    double planner_seconds = 0.0;                    // without the oracle
    double oracle_seconds = 0.0;
};

// Throws what probe_surface throws. Of `watcher`, on_progress is called, if it is given.
[[nodiscard]] Simulation simulate(const SessionConfig& config, const Scene& scene, const Observer& watcher = {});

}  // namespace palpate
