#include "tools/session_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "tools/session_files.h"

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

Region machine_workspace(const SessionConfig& config) {
    if (!config.machine) throw SetupError(fmt::format("machine: missing; a session on a machine needs {}", connection_keys()));
    std::optional<Region> workspace;
    if (const auto* ball = std::get_if<Ball>(&config.workspace)) workspace.emplace(*ball);
    if (const auto* box = std::get_if<Box>(&config.workspace)) workspace.emplace(*box);
    if (!workspace) throw SetupError("workspace: auto is for simulations; say where the part is: workspace.ball or workspace.box");
    check_session(*config.machine, *workspace, config.probing);
    return *workspace;
}

SessionPlan plan_session(const SessionConfig& config, const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / kConfigFile;
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    return {*config.machine, machine_workspace(config), config.probing, folder / kJournalFile, digest(text), file.string()};
}

}  // namespace palpate
