// palpate simulate: a run on a hidden object, and the truth about it.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "config/reader.h"
#include "config/writer.h"
#include "devices/errors.h"
#include "devices/session/journal.h"
#include "tools/calibration_file.h"
#include "tools/commands/commands.h"
#include "tools/hindsight.h"
#include "tools/provenance.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/session_folder.h"
#include "tools/session_plan.h"
#include "tools/summary.h"

namespace palpate {

ExitCode run(const SimulateCommand& command, Output& output) {
    StopSignals signals;
    const SessionConfig config = with_calibration(read_config(command.config, command.overrides));
    const Scene scene = build_scene(config);
    print_warnings(scene.object);
    const SessionFolder folder =
        SessionFolder::begin(command.folder, inputs_of(config, command.config), [&](std::string_view) { return command.force; });
    warn_of_false_reach(config, scene.object);
    if (config.machine && config.machine->datum)
        spdlog::warn("machine.datum: a simulation touches no datum and takes out no drift; `palpate vm` and `palpate probe` do");
    const std::string text = write_config(config, command.folder);
    // Before the run, in which the mesh file may change.
    const Provenance provenance = provenance_of(config, command.folder, digest(text), object_sha256(config));
    Simulation run = simulate_with_progress(config, scene, output, signals);
    if (signals.token().stop_requested()) throw Stopped("stopped; nothing was written");
    warn_of_other_truth(run);
    write_file(command.folder / kConfigFile, text);
    const std::optional<PartResult> part = part_of(run.result, config);
    const std::optional<CurvedSurface> curved = curved_of(run.result, part, config);
    if (curved && run.truth) {
        run.curved_truth = measure_surface(scene.object, curved->mesh, kCurvedTruthPoints, config.probing.random_seed);
    }
    const std::string summary = to_json(run, part, config.probing.epsilon, provenance);
    const std::string files = write_results(command.folder, run.result, part, curved, provenance, summary, command.picture);
    signals.release();
    tell_result(output, run.result, part, config.probing.epsilon, {"truth", describe_truth(run)}, summary, command.folder,
                fmt::format("config.yaml, {}", files));
    return exit_code_of(run.result);
}

}  // namespace palpate
