#include "tools/hindsight.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "devices/errors.h"
#include "tools/run_progress.h"

namespace palpate {
namespace {

// A reach written with a few digits less than the true one has is not a false one.
constexpr double kRounding = 1e-6;

}  // namespace

void print_warnings(const HiddenObject& object) {
    for (const std::string& warning : object.warnings()) spdlog::warn("{}", warning);
}

void warn_of_false_reach(const SessionConfig& config, const HiddenObject& object) {
    // With a tool another surface is probed, and what its reach is nobody has worked out.
    if (config.tool || !config.fixtures.solids.empty() || config.area) return;
    if (config.probing.reach && object.reach() && *config.probing.reach > *object.reach() * (1 + kRounding)) {
        spdlog::warn("probing.reach = {} mm is more than the object's true reach, {} mm: what the certificate rests on is false",
                     *config.probing.reach, *object.reach());
    }
}

void warn_of_other_truth(const Simulation& run) {
    const Topology& found = run.result.topology;
    if (!run.truth) return;
    const Truth& truth = *run.truth;
    if (found.euler_characteristic != truth.euler_characteristic || static_cast<int>(found.components) != truth.components) {
        spdlog::warn(
            "the mesh has {} component(s) and Euler characteristic {}, the hidden object {} and {}: make epsilon smaller, or give seed "
            "rays",
            found.components, found.euler_characteristic, truth.components, truth.euler_characteristic);
    }
}

std::string describe_truth(const Simulation& run) {
    if (!run.truth) {
        const ToolAccount tool = run.tool.value_or(ToolAccount{});
        using Part = ToolContact::Part;
        const auto touches = [&](Part part) {
            return tool.touches(part, ToolContact::Met::object) + tool.touches(part, ToolContact::Met::fixture);
        };
        return fmt::format(
            "{} unsafe moves, {} into the object and {} into fixtures{}; {} touches of the ball, {} of the stylus, {} of the holder",
            run.unsafe_moves, tool.moves_into_object, tool.moves_into_fixtures,
            run.moves_out_of_area ? fmt::format(", {} out of the area", *run.moves_out_of_area) : std::string(), touches(Part::ball),
            touches(Part::stylus), touches(Part::holder));
    }
    return fmt::format("Euler characteristic {}, {} component(s), Hausdorff distance {:.6g} mm, {} unsafe moves, {} wrong facets",
                       run.truth->euler_characteristic, run.truth->components, run.truth->hausdorff, run.unsafe_moves,
                       std::ranges::count(run.verdicts, FacetVerdict::wrong));
}

Simulation simulate_with_progress(const SessionConfig& config, const Scene& scene, Output& output, StopSignals& signals) {
    return with_progress(output, [&](const Observer& observer) {
        Observer stopping = observer;
        stopping.on_progress = [&](const Progress& progress, const RunView& run) {
            observer.on_progress(progress, run);
            signals.pause();
            if (signals.token().stop_requested()) throw Stopped("stopped; nothing was written");
        };
        return simulate(config, scene, stopping);
    });
}

}  // namespace palpate
