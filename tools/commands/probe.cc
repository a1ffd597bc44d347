// palpate probe: a session on a machine.
#include <spdlog/spdlog.h>

#include "config/reader.h"
#include "config/writer.h"
#include "tools/calibration_file.h"
#include "tools/commands/commands.h"
#include "tools/operated_session.h"
#include "tools/session_files.h"
#include "tools/session_folder.h"
#include "tools/session_plan.h"

namespace palpate {

ExitCode run(const ProbeCommand& command, Output& output) {
    StopSignals signals;
    const SessionConfig config = with_calibration(read_config(command.config, command.overrides));
    for (const std::string& warning : calibration_warnings(config, std::chrono::system_clock::now())) spdlog::warn("{}", warning);
    (void)machine_workspace(config);
    const std::string text = write_config(config, command.folder);
    // A process that was killed before its session began has left its configuration, and an empty journal perhaps.
    const auto was_left = [&](std::string_view file) {
        const std::filesystem::path there = command.folder / file;
        return file == kConfigFile && (std::filesystem::exists(command.folder / kJournalFile) || read_file(there) == text);
    };
    const SessionFolder folder = SessionFolder::begin(command.folder, inputs_of(config, command.config), was_left);
    write_file(command.folder / kConfigFile, text);
    try {
        return run_session(plan_session(config, command.folder, text), config, command.folder, command.picture,
                           host_for(config, command.yes, output, signals), output, signals, start_session);
    } catch (...) {
        remove_unbegun_session(command.folder);
        throw;
    }
}

}  // namespace palpate
