#include "tools/session_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tools/calibration_file.h"
#include "tools/earlier_session.h"
#include "tools/provenance.h"
#include "tools/session_files.h"
#include "tools/session_surroundings.h"

namespace palpate {
namespace {

std::string full_key(std::string_view connection) { return fmt::format("machine.{}", connection); }

}  // namespace

std::string connection_keys() {
    std::string text;
    for (const std::string_view connection : kConnectionKeys) text += (text.empty() ? "" : " or ") + full_key(connection);
    return text;
}

bool is_connection_key(std::string_view key) {
    return std::ranges::any_of(kConnectionKeys, [&](std::string_view connection) { return key.starts_with(full_key(connection) + '.'); });
}

Surroundings machine_workspace(const SessionConfig& config) {
    if (!config.machine) throw SetupError(fmt::format("machine: missing; a session on a machine needs {}", connection_keys()));
    std::optional<Region> workspace;
    if (const auto* ball = std::get_if<Ball>(&config.workspace)) workspace.emplace(*ball);
    if (const auto* box = std::get_if<Box>(&config.workspace)) workspace.emplace(*box);
    if (!workspace) throw SetupError("workspace: auto is for simulations; say where the part is: workspace.ball or workspace.box");
    Surroundings surroundings = surroundings_of(config, *workspace);
    check_session(*config.machine, surroundings, config.probing);
    return surroundings;
}

SessionConfig with_its_files(SessionConfig config) { return with_earlier_touches(with_calibration(std::move(config))); }

std::vector<std::filesystem::path> inputs_of(const SessionConfig& config, const std::filesystem::path& file) {
    std::vector<std::filesystem::path> inputs = {file};
    if (!config.calibration.file.empty()) inputs.push_back(config.calibration.file);
    if (!config.earlier.file.empty()) inputs.push_back(config.earlier.file);
    if (!config.object) return inputs;
    if (const auto* mesh = std::get_if<MeshSpec>(&*config.object)) inputs.push_back(mesh->file);
    return inputs;
}

ExpectedEffort expected_effort(const SessionConfig& config) {
    // Measured on the examples: samples per that of the hexagonal bound, touches and way (in epsilon) per sample with and without a bound
    // on the reach, and of that way what is gone as a probe.
    constexpr double kSamplesPerBound = 1.75;
    const bool has_bound = config.probing.reach.has_value();
    const double touches_per_sample = has_bound ? 1.2 : 2.8;
    const double way_per_sample = (has_bound ? 3.5 : 11.0) * config.probing.epsilon;
    constexpr double kProbed = 0.4;
    // Of a part that fills most of the workspace.
    constexpr double kArea = 0.6;
    const Box around = machine_workspace(config).bounds();
    const Vector size = around.max - around.min;
    const double area = kArea * 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    const double samples = kSamplesPerBound * lower_bound_samples(area, config.probing.epsilon);
    Cost cost;
    cost.contact = static_cast<std::uint64_t>(touches_per_sample * samples);
    cost.probing = kProbed * way_per_sample * samples;
    cost.travel = (1 - kProbed) * way_per_sample * samples;
    ExpectedEffort effort{touches_per_sample * samples, estimate_machine_time(cost, machine_rates(config.machine->motion))};
    const Budget& budget = config.probing.budget;
    if (budget.probes && static_cast<double>(*budget.probes) < effort.touches) {
        effort.time *= static_cast<double>(*budget.probes) / effort.touches;
        effort.touches = static_cast<double>(*budget.probes);
    }
    return effort;
}

std::string larger_budget(const Budget& budget) {
    if (budget.probes) return fmt::format("probing.budget.probes={}", 2 * *budget.probes);
    if (budget.displacement) return fmt::format("probing.budget.displacement={:.6g}", 2 * *budget.displacement);
    return fmt::format("probing.budget.machine_time={:.6g}", 2 * budget.machine_time.value_or(1.0));
}

SessionPlan plan_session(const SessionConfig& config, const std::filesystem::path& folder, const std::string& text) {
    return {*config.machine, machine_workspace(config),       config.probing,       folder / kJournalFile,
            digest(text),    (folder / kConfigFile).string(), object_sha256(config)};
}

}  // namespace palpate
