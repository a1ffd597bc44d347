#include "tools/session_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/progress_estimate.h"
#include "tools/calibration_file.h"
#include "tools/earlier_session.h"
#include "tools/provenance.h"
#include "tools/session_files.h"
#include "tools/session_surroundings.h"
#include "tools/terminal/time_left.h"

namespace palpate {
namespace {

std::string full_key(std::string_view connection) { return fmt::format("machine.{}", connection); }

// Measured on the examples: touches and way (in epsilon) for a sample.
struct PerSample {
    double touches = 0.0;
    double way = 0.0;
};

PerSample per_sample(const Options& options) {
    switch (options.inference()) {
        case Strategy::Infer::reach:
            return {1.05, 3.2};
        case Strategy::Infer::none:
            return options.strategy.explore == Strategy::Explore::closure ? PerSample{5.8, 70} : PerSample{18, 200};
        default:
            return {1.15, 4.2};
    }
}

struct Expected {
    double base = 0.0;  // samples without a tolerance
    double samples = 0.0;
    PerSample each;

    [[nodiscard]] double touches() const { return each.touches * samples; }
};

Expected expected(const Options& options, const Vector& size) {
    const double base = expected_samples(size, options.epsilon);
    return {base, base * (options.tolerance ? expected_refinement(*options.tolerance, options.epsilon) : 1), per_sample(options)};
}

// No more is known of a guess.
double two_digits(double x) {
    const double unit = std::pow(10, std::floor(std::log10(std::max(x, 1.0))) - 1);
    return std::round(x / unit) * unit;
}

std::string touches_text(double touches) { return fmt::format("about {:.0f} touches", two_digits(touches)); }

std::string doubt_text(const Options& options) {
    return options.tolerance ? "; how many a tolerance takes depends on the shape: a third of that, or three times" : "";
}

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
    // Of the way, what is gone as a probe.
    constexpr double kProbed = 0.4;
    const Box around = machine_workspace(config).bounds();
    const Expected expected = palpate::expected(config.probing, around.max - around.min);
    // Samples that lie closer have less of it between them.
    const double way = expected.each.way * config.probing.epsilon * std::sqrt(expected.base * expected.samples);
    Cost cost;
    cost.contact = static_cast<std::uint64_t>(expected.touches());
    cost.probing = kProbed * way;
    cost.travel = (1 - kProbed) * way;
    ExpectedEffort effort{expected.touches(), estimate_machine_time(cost, machine_rates(config.machine->motion))};
    const Budget& budget = config.probing.budget;
    if (budget.probes && static_cast<double>(*budget.probes) < effort.touches) {
        effort.time *= static_cast<double>(*budget.probes) / effort.touches;
        effort.touches = static_cast<double>(*budget.probes);
    }
    return effort;
}

std::string effort_text(const SessionConfig& config) {
    const ExpectedEffort effort = expected_effort(config);
    return fmt::format("{} in {} of motion if the part fills the workspace{}", touches_text(effort.touches), duration_text(effort.time),
                       doubt_text(config.probing));
}

std::string effort_text(const Options& options, const Vector& size) {
    return touches_text(expected(options, size).touches()) + doubt_text(options);
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
