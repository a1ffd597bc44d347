// palpate resume: a session goes on, or is replayed.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "config/reader.h"
#include "tools/commands/commands.h"
#include "tools/machine.h"
#include "tools/operated_session.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// What the planner asks must not change; where the port is today may.
void check_overrides(const ResumeCommand& command) {
    constexpr std::array<std::string_view, 2> kAllowed = {"machine.homing=", "machine.probe_proof="};
    if (command.replay && !command.overrides.empty()) throw SetupError("--set: a replay has no machine that it could be for");
    for (const std::string& word : command.overrides) {
        if (is_connection_key(word) || std::ranges::any_of(kAllowed, [&](std::string_view allowed) { return word.starts_with(allowed); }))
            continue;
        throw SetupError(
            fmt::format("--set {}: a session goes on as it began; allowed: machine.homing, machine.probe_proof, and what is below {}", word,
                        connection_keys()));
    }
}

}  // namespace

ExitCode run(const ResumeCommand& command, std::ostream& out) {
    const StopSignals signals;
    if (!fs::is_regular_file(command.folder / kJournalFile)) {
        throw SetupError(fmt::format("{}: holds no journal.jsonl that is a file; only what `palpate probe` began can be resumed",
                                     command.folder.string()));
    }
    check_overrides(command);
    const SessionConfig config = read_config(command.folder / kConfigFile, command.overrides);
    (void)machine_workspace(config);
    return run_session(command.folder, config, command.picture, host_for(*config.machine, command.yes, signals), out,
                       command.replay ? replay_session : resume_session);
}

}  // namespace palpate
