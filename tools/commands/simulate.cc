// palpate simulate: a run on a hidden object, and the truth about it.
#include <ostream>

#include "config/reader.h"
#include "config/writer.h"
#include "tools/commands/commands.h"
#include "tools/hindsight.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/summary.h"

namespace palpate {

ExitCode run(const SimulateCommand& command, std::ostream& out) {
    const SessionConfig config = read_config(command.config, command.overrides);
    const Scene scene = build_scene(config);
    print_warnings(scene.object);
    prepare_session_folder(command.folder, command.force);
    warn_of_false_reach(config, scene.object);
    const Simulation run = simulate_with_progress(config, scene);
    warn_of_other_truth(run);
    write_file(command.folder / kConfigFile, write_config(config));
    const std::string files = write_results(command.folder, run.result, to_json(run, config.probing.epsilon), command.picture);
    print_result(run.result, config.probing.epsilon, describe_truth(run), out);
    out << "written to     " << command.folder.string() << ": config.yaml, " << files << '\n';
    return exit_code_of(run.result);
}

}  // namespace palpate
