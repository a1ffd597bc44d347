// palpate probe: a session on a machine.
#include <spdlog/spdlog.h>

#include "config/writer.h"
#include "tools/calibration_file.h"
#include "tools/commands/new_session.h"
#include "tools/operated_session.h"
#include "tools/session_files.h"
#include "tools/session_folder.h"
#include "tools/session_plan.h"

namespace palpate {

ExitCode begin_on_machine(const NewSession& session, bool yes, Output& output) {
    StopSignals signals;
    const SessionConfig& config = session.config;
    for (const std::string& warning : calibration_warnings(config, std::chrono::system_clock::now())) spdlog::warn("{}", warning);
    (void)machine_workspace(config);
    const std::string text = write_config(config, session.folder);
    // A process that was killed before its session began has left its configuration, and an empty journal perhaps.
    const auto was_left = [&](std::string_view file) {
        const std::filesystem::path there = session.folder / file;
        if (file != kConfigFile && file != kEarlierFile) return false;
        return std::filesystem::exists(session.folder / kJournalFile) || read_file(there) == (file == kConfigFile ? text : session.earlier);
    };
    const SessionFolder folder = SessionFolder::begin(session.folder, session.inputs, was_left);
    try {
        if (!session.earlier.empty()) write_file(session.folder / kEarlierFile, session.earlier);
        write_file(session.folder / kConfigFile, text);
        return run_session(plan_session(config, session.folder, text), config, session.folder, session.picture,
                           host_for(config, yes, output, signals), output, signals, start_session);
    } catch (...) {
        remove_unbegun_session(session.folder);
        throw;
    }
}

ExitCode run(const ProbeCommand& command, Output& output) {
    return begin_on_machine(new_session(command.config, command.overrides, command.folder, command.picture), command.yes, output);
}

}  // namespace palpate
