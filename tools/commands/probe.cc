// palpate probe: a session on a machine.
#include "config/reader.h"
#include "config/writer.h"
#include "tools/commands/commands.h"
#include "tools/operated_session.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"

namespace palpate {

ExitCode run(const ProbeCommand& command, std::ostream& out) {
    const StopSignals signals;
    const SessionConfig config = read_config(command.config, command.overrides);
    (void)machine_workspace(config);
    remove_unbegun_session(command.folder);
    prepare_session_folder(command.folder, false);
    write_file(command.folder / kConfigFile, write_config(config));
    try {
        return run_session(command.folder, config, command.picture, host_for(*config.machine, command.yes, signals), out, start_session);
    } catch (...) {
        remove_unbegun_session(command.folder);
        throw;
    }
}

}  // namespace palpate
