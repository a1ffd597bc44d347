// palpate touch: one guarded touch.
#include <fmt/format.h>

#include <ostream>

#include "config/reader.h"
#include "devices/errors.h"
#include "devices/session/guarded_machine.h"
#include "planner/number_text.h"
#include "tools/commands/commands.h"
#include "tools/machine.h"
#include "tools/session_plan.h"
#include "tools/terminal/consent.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {
namespace {

Point point_of(const std::vector<double>& coordinates, const char* option) {
    if (coordinates.size() != 3) throw SetupError(fmt::format("{}: needs three numbers, x,y,z in mm", option));
    return {coordinates[0], coordinates[1], coordinates[2]};
}

}  // namespace

ExitCode run(const TouchCommand& command, Output& output) {
    StopSignals signals;
    std::ostream& out = output.results;
    const SessionConfig config = read_config(command.config, command.overrides);
    if (!config.machine) throw SetupError(fmt::format("machine: missing; a touch needs {}", connection_keys()));
    const MachineConfig& machine_config = *config.machine;
    const Point from = point_of(command.from, "--from");
    const Point to = point_of(command.to, "--to");
    if (from == to) throw SetupError("--from and --to are the same place: there is no way to touch along");
    for (const Point& p : {from, to}) {
        const Box& limits = machine_config.limits;
        if (limits.contains(p)) continue;
        throw SetupError(
            fmt::format("{} is outside machine.limits, {} to {}", point_text(p), point_text(limits.min), point_text(limits.max)));
    }
    GuardedMachine guarded(connect(machine_config, signals.token()), machine_config, signals.token(), [&] { signals.pause(); });
    const MachineReport report = guarded.machine().report();
    ProbeDevice& device = guarded.device();
    ask_consent(describe_plan(report, machine_config,
                              fmt::format("It will move, guarded, straight to {}, then towards {} until it touches, and back.",
                                          point_text(from), point_text(to))),
                command.yes, output.console, signals);
    guarded.machine().make_ready();
    // Nothing has shown yet that the probe works.
    const MoveResult there = move_past_sparks(device, from, Pace::probe);
    if (there.outcome != MoveResult::Outcome::reached) throw UnexpectedContact(there.position, "the way to --from");
    const MoveResult touch = device.guarded_move(to, Pace::probe);
    const MoveResult back = device.guarded_move(from, Pace::travel);
    if (back.outcome != MoveResult::Outcome::reached) throw UnexpectedContact(back.position, "the way back");
    signals.release();
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
    const bool is_answered = touch.outcome == MoveResult::Outcome::reached || touch.outcome == MoveResult::Outcome::contact;
    return is_answered ? ExitCode::done : ExitCode::incomplete;
}

}  // namespace palpate
