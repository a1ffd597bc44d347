#include "tools/machine_session.h"

#include <fstream>

#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/journaling_device.h"
#include "planner/errors.h"
#include "planner/number_text.h"
#include "tools/machine.h"
#include "tools/return_to_work.h"
#include "tools/session_files.h"
#include "tools/simulation.h"
#include "tools/timed_oracle.h"

namespace palpate {
namespace {

std::string config_digest(const std::filesystem::path& folder) {
    std::ifstream in(folder / kConfigFile, std::ios::binary);
    return digest({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
}

void check_start(const Workspace& workspace, const Box& limits, const Point& start) {
    if (!limits.contains(start)) {
        throw SetupError("the tool is at " + point_text(start) + ", outside machine.limits, " + point_text(limits.min) + " to " +
                         point_text(limits.max) + ": move it inside them by hand, then start again");
    }
    if (!workspace.contains(start)) return;
    throw SetupError("the tool is inside the workspace, at " + point_text(start) +
                     ", where no way is known to be free: move it outside by hand, then start again");
}

// What the planner makes of the answers of `journal`.
MachineRun plan_on(JournalingDevice& journal, const SessionConfig& config, const Workspace& workspace, const SessionHost& host) {
    MeteredDevice metered(journal, config.machine->kinematics);
    DeviceOracle device_oracle(metered, config.probing.touch_error);
    TimedOracle oracle(device_oracle);
    Observer observer;
    observer.on_progress = host.on_progress;
    MachineRun run;
    const auto begin = std::chrono::steady_clock::now();
    run.result = probe_surface(oracle, workspace, config.probing, observer);
    const Seconds total = std::chrono::steady_clock::now() - begin;
    run.oracle_seconds = oracle.spent().count();
    run.planner_seconds = (total - oracle.spent()).count();
    run.meter = metered.meter();
    run.grazes = device_oracle.grazes();
    run.machine = journal.record().header.machine;
    run.resumptions = journal.record().resumptions;
    return run;
}

// The tool does not stay in the part: the next session has to begin outside.
void leave(JournalWriter& writer, GuardedMachine& guarded, const SessionConfig& config, const Workspace& workspace,
           const SessionHost& host) {
    try {
        leave_work(guarded, writer.read(), workspace, *config.machine);
    } catch (const DeviceError& error) {
        host.say(std::string("the session is over, but the tool could not be brought out of the workspace: ") + error.what());
    }
}

MachineRun finish(MachineRun run, JournalWriter& writer, GuardedMachine& guarded, const SessionConfig& config, const Workspace& workspace,
                  const SessionHost& host) {
    writer.append(JournalEnd{run.planner_seconds, run.oracle_seconds});
    leave(writer, guarded, config, workspace, host);
    return run;
}

// All was in the journal but its end.
MachineRun finish_without_machine(MachineRun run, JournalWriter& writer) {
    writer.append(JournalEnd{run.planner_seconds, run.oracle_seconds});
    return run;
}

// The configuration decides what the planner asks: another one would not fit the journal.
void check_config(const Journal& journal, const std::filesystem::path& folder) {
    if (journal.header.config == config_digest(folder)) return;
    throw SetupError(
        (folder / kConfigFile).string() +
        ": was changed since the session began, and its journal does not fit it any more: put the old one back, or begin a new session");
}

}  // namespace

Workspace machine_workspace(const SessionConfig& config) {
    if (!config.machine) throw SetupError("machine: missing; a session on a machine needs machine.grbl or machine.modbus");
    std::optional<Workspace> workspace;
    if (const auto* ball = std::get_if<Ball>(&config.workspace)) workspace.emplace(*ball);
    if (const auto* box = std::get_if<Box>(&config.workspace)) workspace.emplace(*box);
    if (!workspace) throw SetupError("workspace: auto is for simulations; say where the part is: workspace.ball or workspace.box");
    const Box around = workspace->outer_bounds();
    const Box& limits = config.machine->limits;
    if (!limits.contains(around)) {
        throw SetupError("machine.limits: the tool has to get all around the workspace, from " + point_text(around.min) + " to " +
                         point_text(around.max) + ", but the limits are " + point_text(limits.min) + " to " + point_text(limits.max) +
                         ": make the workspace smaller or the limits wider");
    }
    check_options(*workspace, config.probing);
    return *workspace;
}

MachineRun start_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionHost& host) {
    const Workspace workspace = machine_workspace(config);
    GuardedMachine guarded(*config.machine, host.stop);
    const MachineReport report = guarded.machine().report();
    // Homing moves it elsewhere; otherwise nobody need be asked about a session that cannot begin.
    if (guarded.machine().is_position_trusted()) check_start(workspace, config.machine->limits, report.position);
    host.ask(describe_plan(*config.machine, report,
                           "It will move, guarded, around and into the workspace until it has found the part's shape."));
    guarded.machine().make_ready();
    const JournalHeader header{config_digest(folder), guarded.device().position(), report.identity};
    check_start(workspace, config.machine->limits, header.start);
    JournalWriter writer = JournalWriter::create(folder / kJournalFile, header);
    JournalingDevice journal(Journal{header}, &writer, [&](const Point&) -> ProbeDevice& { return guarded.device(); });
    try {
        return finish(plan_on(journal, config, workspace, host), writer, guarded, config, workspace, host);
    } catch (const SeedError&) {
        leave(writer, guarded, config, workspace, host);
        throw;
    }
}

MachineRun replay_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionHost& host) {
    const Workspace workspace = machine_workspace(config);
    Journal record = read_journal(folder / kJournalFile);
    check_config(record, folder);
    if (!record.end) throw SetupError(folder.string() + ": this session is not finished; resume it without --replay");
    const JournalEnd end = *record.end;
    JournalingDevice journal(std::move(record), nullptr, {}, host.stop);
    MachineRun run = plan_on(journal, config, workspace, host);
    run.planner_seconds = end.planner_seconds;
    run.oracle_seconds = end.oracle_seconds;
    return run;
}

MachineRun resume_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionHost& host) {
    const Workspace workspace = machine_workspace(config);
    JournalWriter writer(folder / kJournalFile);
    std::optional<GuardedMachine> guarded;
    for (bool again = false;; again = true) {
        Journal record = writer.read();
        if (record.end) {
            host.say("this session is finished; its files are made again from its journal");
            return replay_session(config, folder, host);
        }
        check_config(record, folder);
        if (record.dropped_bytes > 0) host.say("the last line of the journal was torn and is dropped: that move is made again");
        std::uint64_t resumptions = record.resumptions;
        const auto go_live = [&](const Point& next_target) -> ProbeDevice& {
            guarded.emplace(*config.machine, host.stop);
            host.ask(describe_plan(*config.machine, guarded->machine().report(),
                                   "It will go back to where the session ended, touch a known place again, and go on."));
            const Confirmation found = return_to_work(*guarded, record, workspace, *config.machine, next_target);
            writer.append_resumed(found.contact_line, found.offset_mm);
            ++resumptions;
            return guarded->device();
        };
        JournalingDevice journal(record, &writer, go_live, host.stop);
        try {
            MachineRun run = plan_on(journal, config, workspace, host);
            run.resumptions = resumptions;
            if (!guarded) return finish_without_machine(std::move(run), writer);
            return finish(std::move(run), writer, *guarded, config, workspace, host);
        } catch (const SeedError&) {
            if (guarded) leave(writer, *guarded, config, workspace, host);
            throw;
        } catch (const UnexpectedContact& contact) {
            // The session had halted at a touch where space was free. The machine is asked again, once.
            if (journal.is_live() || again) throw;
            host.say(std::string("the session had halted: ") + contact.what() + "; that way is gone again");
            journal.withdraw(contact.moves());
        }
    }
}

}  // namespace palpate
