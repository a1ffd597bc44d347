// palpate check: would a session begin? Moves nothing.
#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

#include "config/reader.h"
#include "config/strategy_names.h"
#include "planner/number_text.h"
#include "tools/commands/commands.h"
#include "tools/hindsight.h"
#include "tools/machine.h"
#include "tools/probe_proof.h"
#include "tools/session_plan.h"
#include "tools/stop_signals.h"

namespace palpate {
namespace {

// Everything that a session on the machine would refuse is refused here, and nothing moves.
ExitCode check_machine(const CheckCommand& command, const SessionConfig& config, std::ostream& out) {
    const Region workspace = machine_workspace(config);
    const MotionModel& k = config.machine->motion;
    out << "workspace      around " << point_text(workspace.center()) << ", radius " << workspace.radius() << " mm; within machine.limits\n"
        << "epsilon        " << config.probing.epsilon << " mm; touches are taken to be exact to " << config.traits().touch_error << " mm\n"
        << "stopping       " << stopping_distance(k, k.feeds.travel_mm_per_s) << " mm from travel, "
        << stopping_distance(k, k.feeds.probe_mm_per_s) << " mm from a touch; the probe gives way by " << k.overtravel_mm << " mm\n";
    if (config.object) (void)HiddenObject(*config.object);
    check_connection(*config.machine);
    if (command.offline) {
        out << "the configuration is good; the machine was not asked\n";
        return ExitCode::done;
    }
    const StopSignals signals;
    const std::unique_ptr<Machine> machine = connect(*config.machine, signals.token());
    const MachineReport report = machine->report();
    out << "machine        " << report.identity << "\nstate          " << report.state << ", at " << point_text(report.position) << '\n';
    bool good = !report.has_problems();
    for (const MachineSetting& setting : report.settings) {
        out << "  " << setting.name << ": " << setting.value << (setting.problem.empty() ? "" : fmt::format("  <- {}", setting.problem))
            << '\n';
    }
    if (report.reach) {
        const bool inside = report.reach->contains(config.machine->limits);
        out << "reach          " << point_text(report.reach->min) << " to " << point_text(report.reach->max)
            << (inside ? "; machine.limits are within it\n"
                       : "  <- machine.limits go beyond it: move machine.origin, or make them narrower\n");
        good &= inside;
    }
    const bool at_terminal = ::isatty(STDIN_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0;
    if (is_proven_by_hand(config.machine->probe_proof, at_terminal)) {
        const bool works = see_probe_pressed(*machine, STDIN_FILENO, "go on without", std::cerr, signals.token());
        out << "  probe works: " << (works ? "yes, it closed and opened\n" : "not shown  <- look at its lead, plug and battery\n");
        good &= works;
    } else {
        out << "  probe works: not shown; the first touch of a session will (machine.probe_proof)\n";
    }
    out << (good ? "all is good; nothing has moved\n" : "mend what an arrow points at; nothing has moved\n");
    return good ? ExitCode::done : ExitCode::usage;
}

}  // namespace

ExitCode run(const CheckCommand& command, std::ostream& out) {
    const SessionConfig config = read_config(command.config, command.overrides);
    if (config.machine) return check_machine(command, config, out);
    const Scene scene = build_scene(config);
    print_warnings(scene.object);
    warn_of_false_reach(config, scene.object);
    const Box& bounds = scene.object.bounds();
    const Options& probing = config.probing;
    out << "object         " << point_text(bounds.min) << " to " << point_text(bounds.max) << ", " << scene.object.components()
        << " component(s), Euler characteristic " << scene.object.euler_characteristic() << '\n'
        << "reach          " << (scene.object.reach() ? fmt::format("{:f} mm", *scene.object.reach()) : std::string("not known")) << '\n'
        << "workspace      around " << point_text(scene.workspace.center()) << ", radius " << scene.workspace.radius()
        << " mm; contains the object\n"
        << "epsilon        " << probing.epsilon << " mm; a guarantee of topology needs a reach of at least "
        << probing.epsilon / kMaxEpsilonPerReach << " mm, "
        << (probing.reach ? fmt::format("given: {:f} mm", *probing.reach) : "none given") << '\n'
        << "strategy       " << to_string(probing.strategy) << '\n'
        << "seeds          "
        << (probing.seed_rays.empty() ? "rays towards the centre of the workspace"
                                      : fmt::format("{} seed ray(s)", probing.seed_rays.size()))
        << "\nthe configuration is good\n";
    return ExitCode::done;
}

}  // namespace palpate
