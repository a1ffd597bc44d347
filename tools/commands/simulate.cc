// palpate simulate: a run on a hidden object, and the truth about it.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "config/writer.h"
#include "devices/errors.h"
#include "devices/session/journal.h"
#include "tools/commands/new_session.h"
#include "tools/hindsight.h"
#include "tools/provenance.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/session_folder.h"
#include "tools/session_plan.h"
#include "tools/summary.h"

namespace palpate {

ExitCode begin_simulation(const NewSession& session, bool force, Output& output) {
    StopSignals signals;
    const SessionConfig& config = session.config;
    const Scene scene = build_scene(config);
    print_warnings(scene.object);
    const SessionFolder folder = SessionFolder::begin(session.folder, session.inputs, [&](std::string_view) { return force; });
    warn_of_false_reach(config, scene.object);
    if (config.machine && config.machine->datum)
        spdlog::warn("machine.datum: a simulation touches no datum and takes out no drift; `palpate vm` and `palpate probe` do");
    const std::string text = write_config(config, session.folder);
    // Before the run, in which the mesh file may change.
    const Provenance provenance = provenance_of(config, session.folder, digest(text), object_sha256(config));
    Simulation run = simulate_with_progress(config, scene, output, signals);
    if (signals.token().stop_requested()) throw Stopped("stopped; nothing was written");
    warn_of_other_truth(run);
    if (session.earlier.empty()) {
        std::error_code ignored;
        std::filesystem::remove(session.folder / kEarlierFile, ignored);
    } else {
        write_file(session.folder / kEarlierFile, session.earlier);
    }
    write_file(session.folder / kConfigFile, text);
    const std::optional<PartResult> part = part_of(run.result, config);
    const std::optional<CurvedSurface> curved = curved_of(run.result, part, config);
    if (curved && run.truth) {
        run.curved_truth = measure_surface(scene.object, curved->mesh, kCurvedTruthPoints, config.probing.random_seed);
    }
    const std::string summary = to_json(run, part, config.probing.epsilon, provenance);
    const std::string files = write_results(session.folder, run.result, part, curved, provenance, summary, session.picture);
    signals.release();
    tell_result(output, run.result, part, config.probing.epsilon, {"truth", describe_truth(run)}, summary, session.folder,
                fmt::format("config.yaml, {}", files));
    return exit_code_of(run.result);
}

ExitCode run(const SimulateCommand& command, Output& output) {
    return begin_simulation(new_session(command.config, command.overrides, command.folder, command.picture), command.force, output);
}

}  // namespace palpate
