// The commands that drive a machine: probe, resume, touch, ports.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <string_view>

#include "config/reader.h"
#include "config/writer.h"
#include "devices/errors.h"
#include "devices/port_list.h"
#include "planner/number_text.h"
#include "tools/commands.h"
#include "tools/consent.h"
#include "tools/machine.h"
#include "tools/machine_session.h"
#include "tools/probe_proof.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/simulation.h"
#include "tools/stop_signals.h"
#include "tools/summary.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

void ask(const std::string& what_will_move, bool yes, const StopSignals& signals) {
    ask_consent(what_will_move, yes, STDIN_FILENO, std::cerr, signals.token());
}

SessionHost host_for(const MachineConfig& machine, bool yes, const StopSignals& signals) {
    SessionHost host;
    if (is_proven_by_hand(machine.probe_proof, !yes)) {
        host.press = [&signals](Machine& connected) {
            return see_probe_pressed(connected, STDIN_FILENO, "stop", std::cerr, signals.token());
        };
    }
    host.ask = [yes, &signals](const std::string& plan) { ask(plan, yes, signals); };
    host.say = [](const std::string& sentence) { spdlog::info("{}", sentence); };
    host.stop = signals.token();
    return host;
}

// Runs a session, says how to go on if it is interrupted, and writes what it found.
ExitCode run_session(const fs::path& folder, const SessionConfig& config, const PictureChoice& picture, SessionHost host, std::ostream& out,
                     MachineRun (*session)(const SessionConfig&, const fs::path&, const SessionHost&)) {
    try {
        const MachineRun run = with_progress([&](const auto& on_progress) {
            host.on_progress = on_progress;
            return session(config, folder, host);
        });
        const std::string files = write_results(folder, run.result, to_json(run, config.probing.epsilon), picture);
        print_result(run.result, config.probing.epsilon, "", out);
        out << "written to     " << folder.string() << ": config.yaml, journal.jsonl, " << files << '\n';
        return run.result.certificate.status == Certificate::Status::incomplete ? ExitCode::incomplete : ExitCode::done;
    } catch (const DeviceError&) {
        if (fs::exists(folder / kJournalFile)) {
            spdlog::warn("what was touched is in {}; go on with: palpate resume {}", (folder / kJournalFile).string(), folder.string());
        }
        throw;
    }
}

// What the planner asks must not change; where the port is today may.
void check_overrides(const ResumeCommand& command) {
    constexpr std::array<std::string_view, 4> kAllowed = {"machine.grbl.", "machine.modbus.", "machine.homing=", "machine.probe_proof="};
    if (command.replay && !command.overrides.empty()) throw SetupError("--set: a replay has no machine that it could be for");
    for (const std::string& word : command.overrides) {
        if (std::ranges::any_of(kAllowed, [&](std::string_view allowed) { return word.starts_with(allowed); })) continue;
        throw SetupError("--set " + word +
                         ": a session goes on as it began; allowed: machine.homing, machine.probe_proof, and what is below "
                         "machine.grbl or machine.modbus");
    }
}

Point point_of(const std::vector<double>& coordinates, const char* option) {
    if (coordinates.size() != 3) throw SetupError(std::string(option) + ": needs three numbers, x,y,z in mm");
    return {coordinates[0], coordinates[1], coordinates[2]};
}

}  // namespace

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

ExitCode run(const ResumeCommand& command, std::ostream& out) {
    const StopSignals signals;
    if (!fs::is_regular_file(command.folder / kJournalFile)) {
        throw SetupError(command.folder.string() +
                         ": holds no journal.jsonl that is a file; only what `palpate probe` began can be resumed");
    }
    check_overrides(command);
    const SessionConfig config = read_config(command.folder / kConfigFile, command.overrides);
    (void)machine_workspace(config);
    return run_session(command.folder, config, command.picture, host_for(*config.machine, command.yes, signals), out,
                       command.replay ? replay_session : resume_session);
}

ExitCode run(const TouchCommand& command, std::ostream& out) {
    const StopSignals signals;
    const SessionConfig config = read_config(command.config, command.overrides);
    if (!config.machine) throw SetupError("machine: missing; a touch needs machine.grbl or machine.modbus");
    const MachineConfig& machine_config = *config.machine;
    const Point from = point_of(command.from, "--from");
    const Point to = point_of(command.to, "--to");
    if (from == to) throw SetupError("--from and --to are the same place: there is no way to touch along");
    for (const Point& p : {from, to}) {
        const Box& limits = machine_config.limits;
        if (limits.contains(p)) continue;
        throw SetupError(point_text(p) + " is outside machine.limits, " + point_text(limits.min) + " to " + point_text(limits.max));
    }
    GuardedMachine guarded(machine_config, signals.token());
    ProbeDevice& device = guarded.device();
    ask(describe_plan(
            machine_config, guarded.machine().report(),
            "It will move, guarded, straight to " + point_text(from) + ", then towards " + point_text(to) + " until it touches, and back."),
        command.yes, signals);
    guarded.machine().make_ready();
    // Nothing has shown yet that the probe works.
    const MoveResult there = move_past_sparks(device, from, Pace::probe);
    if (there.outcome != MoveResult::Outcome::reached) throw UnexpectedContact(there.position, "the way to --from");
    const MoveResult touch = device.guarded_move(to, Pace::probe);
    switch (touch.outcome) {
        case MoveResult::Outcome::reached:
            out << "clear: nothing was touched\n";
            break;
        case MoveResult::Outcome::contact:
            out << "contact at " << point_text(touch.position) << ", " << (touch.position - from).norm() << " mm from where it began\n";
            break;
        case MoveResult::Outcome::vanished:
            out << "vanished: the probe closed at " << point_text(touch.position)
                << ", and twice nothing was there when looked at again: a false trigger, or the probe does not close any more; press it by "
                   "hand "
                   "(palpate check)\n";
            break;
        case MoveResult::Outcome::failed:
            out << "failed: touches near " << point_text(touch.position) << " lie apart farther than machine.touch.tolerance\n";
            break;
    }
    for (const DeviceEvent& event : touch.events) {
        out << "  " << (event.kind == DeviceEvent::Kind::spurious_trigger ? "false trigger at " : "event at ") << point_text(event.position)
            << '\n';
    }
    const MoveResult back = device.guarded_move(from, Pace::travel);
    if (back.outcome != MoveResult::Outcome::reached) throw UnexpectedContact(back.position, "the way back");
    const bool is_answered = touch.outcome == MoveResult::Outcome::reached || touch.outcome == MoveResult::Outcome::contact;
    return is_answered ? ExitCode::done : ExitCode::incomplete;
}

ExitCode run(const PortsCommand& /*command*/, std::ostream& out) {
    const std::vector<PortInfo> ports = list_ports();
    if (ports.empty()) out << "no serial ports\n";
    for (const PortInfo& port : ports) {
        out << port.path << "  " << (port.usb_id.empty() ? "not on USB" : port.usb_id);
        for (const std::string& said : {port.manufacturer, port.product, port.serial}) out << (said.empty() ? "" : "  " + said);
        if (!port.driver.empty()) out << "  (" << port.driver << ")";
        out << '\n';
    }
    return ExitCode::done;
}

}  // namespace palpate
