#include "tools/operated_session.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "devices/errors.h"
#include "tools/machine.h"
#include "tools/results.h"
#include "tools/run_progress.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"
#include "tools/summary.h"
#include "tools/terminal/consent.h"
#include "tools/terminal/probe_proof.h"

namespace palpate {
namespace {

std::string describe(const DriftAccount& drift) {
    return fmt::format(
        "{} visits to the datum, {} touches and {:.6g} mm besides: shifted by {:.4f} mm in the end, by {:.4f} mm at the most, by {:.4f} mm "
        "at the most from one visit to the next{}; taken out",
        drift.visits, drift.touches, drift.way_mm, drift.shift.norm(), drift.largest_shift_mm, drift.largest_change_mm,
        drift.directions < 3 ? fmt::format(", as far as is seen in {} of 3 directions", drift.directions) : std::string());
}

// The planner reckons with the touch error, and knows of a drift when it has happened.
void warn_of_drift(const MachineRun& run, const SessionConfig& config) {
    const double touch_error = config.machine->touch_error();
    if (!run.drift || !(run.drift->largest_change_mm > touch_error)) return;
    spdlog::warn(
        "it drifted by {:.4f} mm from one visit to the datum to the next, more than touches may be wrong by, {:g} mm: what lies between is "
        "interpolated and may be off by half of that, and touches may have contradicted each other meanwhile. Make machine.datum.every "
        "smaller, or machine.noise larger",
        run.drift->largest_change_mm, touch_error);
}

}  // namespace

SessionHost host_for(const SessionConfig& config, bool yes, Output& output, StopSignals& signals) {
    const MachineConfig& machine = *config.machine;
    SessionHost host;
    host.connect = [&] { return connect(machine, signals.token()); };
    if (is_proven_by_hand(machine.probe_proof, !yes)) {
        host.press = [&](Machine& connected) { return see_probe_pressed(connected, "stop", output.console, signals); };
    }
    host.ask = [&config, yes, &output, &signals](const PlannedMotion& plan) {
        if (yes && output.is_quiet) return;
        ask_consent(describe_plan(plan, config), yes, output.console, signals);
    };
    host.say = [](const std::string& sentence) { spdlog::info("{}", sentence); };
    host.stop = signals.token();
    host.pause = [&signals] { signals.pause(); };
    return host;
}

ExitCode run_session(const SessionPlan& plan, const SessionConfig& config, const std::filesystem::path& folder,
                     const PictureChoice& picture, SessionHost host, Output& output, StopSignals& signals,
                     MachineRun (*session)(const SessionPlan&, const SessionHost&)) {
    try {
        const MachineRun run = with_progress(output, [&](const Observer& observer) {
            host.on_progress = observer.on_progress;
            return session(plan, host);
        });
        signals.release();
        const Provenance provenance = provenance_of(config, folder, plan.config_digest, run.object_sha256);
        const std::optional<PartResult> part = part_of(run.result, config);
        const std::string summary = to_json(run, part, config.probing.epsilon, provenance);
        const std::string files =
            write_results(folder, run.result, part, curved_of(run.result, part, config), provenance, summary, picture);
        const ResultLine drift{"drift", run.drift ? describe(*run.drift) : ""};
        tell_result(output, run.result, part, config.probing.epsilon, drift, summary, folder,
                    fmt::format("config.yaml, journal.jsonl, {}", files));
        warn_of_drift(run, config);
        if (is_stopped_by_budget(run.result.certificate)) {
            spdlog::info("the budget is used up; with a larger one the session goes on, for example: palpate resume {} --set {}",
                         shell_word(folder.string()), larger_budget(config.probing.budget));
        }
        return exit_code_of(run.result);
    } catch (const OutputError& error) {
        if (!std::filesystem::exists(folder / kJournalFile)) throw;  // the whole folder is gone
        throw OutputError(
            fmt::format("{}. Nothing is lost: the session is finished, and in {}. Once the files can be written, this writes them, "
                        "without the machine: palpate resume {}",
                        error.what(), (folder / kJournalFile).string(), shell_word(folder.string())));
    } catch (const NotFinished&) {
        throw SetupError(fmt::format("{}: this session is not finished; resume it without --replay", folder.string()));
    } catch (const DeviceError&) {
        if (std::filesystem::exists(folder / kJournalFile)) {
            spdlog::warn("what was touched is in {}; go on with: palpate resume {}", (folder / kJournalFile).string(),
                         shell_word(folder.string()));
        }
        throw;
    }
}

}  // namespace palpate
