#include "tools/operated_session.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <iostream>

#include "devices/errors.h"
#include "tools/consent.h"
#include "tools/machine.h"
#include "tools/probe_proof.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"
#include "tools/summary.h"

namespace palpate {

SessionHost host_for(const MachineConfig& machine, bool yes, const StopSignals& signals) {
    SessionHost host;
    host.connect = [&] { return connect(machine, signals.token()); };
    if (is_proven_by_hand(machine.probe_proof, !yes)) {
        host.press = [&signals](Machine& connected) {
            return see_probe_pressed(connected, STDIN_FILENO, "stop", std::cerr, signals.token());
        };
    }
    host.ask = [yes, &signals](const PlannedMotion& plan) {
        ask_consent(describe_plan(plan), yes, STDIN_FILENO, std::cerr, signals.token());
    };
    host.say = [](const std::string& sentence) { spdlog::info("{}", sentence); };
    host.stop = signals.token();
    return host;
}

ExitCode run_session(const std::filesystem::path& folder, const SessionConfig& config, const PictureChoice& picture, SessionHost host,
                     std::ostream& out, MachineRun (*session)(const SessionPlan&, const SessionHost&)) {
    try {
        const SessionPlan plan = plan_session(config, folder);
        const MachineRun run = with_progress([&](const auto& on_progress) {
            host.on_progress = on_progress;
            return session(plan, host);
        });
        const std::string files = write_results(folder, run.result, to_json(run, config.probing.epsilon), picture);
        print_result(run.result, config.probing.epsilon, "", out);
        out << "written to     " << folder.string() << ": config.yaml, journal.jsonl, " << files << '\n';
        return exit_code_of(run.result);
    } catch (const NotFinished&) {
        throw SetupError(fmt::format("{}: this session is not finished; resume it without --replay", folder.string()));
    } catch (const DeviceError&) {
        if (std::filesystem::exists(folder / kJournalFile)) {
            spdlog::warn("what was touched is in {}; go on with: palpate resume {}", (folder / kJournalFile).string(), folder.string());
        }
        throw;
    }
}

}  // namespace palpate
