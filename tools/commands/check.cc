// palpate check: would a session begin? Moves nothing.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <ostream>

#include "config/reader.h"
#include "config/strategy_names.h"
#include "devices/errors.h"
#include "planner/number_text.h"
#include "tools/calibration_file.h"
#include "tools/commands/commands.h"
#include "tools/hindsight.h"
#include "tools/machine.h"
#include "tools/session_plan.h"
#include "tools/session_surroundings.h"
#include "tools/terminal/probe_proof.h"
#include "tools/terminal/stop_signals.h"
#include "tools/terminal/terminal.h"
#include "tools/tool_text.h"

namespace palpate {
namespace {

// What is known of the tool and around the part, if anything is.
void tell_tool(const SessionConfig& config, const Surroundings& surroundings, std::ostream& out) {
    if (config.tool) out << "tool           " << describe(*config.tool) << '\n';
    if (config.probe_calibration) out << "calibration    " << describe(*config.probe_calibration) << '\n';
    if (!config.fixtures.solids.empty()) out << "fixtures       " << describe(config.fixtures) << '\n';
    if (surroundings.area()) out << "area           " << describe_area(surroundings) << '\n';
}

// What a session would say against the place where the tool is; nothing if it would not, or if nobody knows the place yet.
std::string start_problem(Machine& machine, const Surroundings& workspace, const Box& limits, const Point& position) {
    if (!machine.is_position_trusted()) return {};
    try {
        check_start(workspace, limits, position);
    } catch (const SetupError& error) {
        return error.what();
    }
    return {};
}

// Everything that a session on the machine would refuse is refused here, and nothing moves.
ExitCode check_machine(const CheckCommand& command, const SessionConfig& config, Output& output) {
    std::ostream& out = output.results;
    const Surroundings workspace = machine_workspace(config);
    const MotionModel& k = config.machine->motion;
    out << "workspace      " << describe(workspace) << "; within machine.limits\n"
        << "epsilon        " << config.probing.epsilon << " mm; touches are taken to be exact to " << config.traits().touch_error << " mm\n"
        << "stopping       " << stopping_distance(k, k.feeds.travel_mm_per_s) << " mm from travel, "
        << stopping_distance(k, k.feeds.probe_mm_per_s) << " mm from a touch; the probe gives way by " << k.overtravel_mm << " mm\n";
    tell_tool(config, workspace, out);
    out << "effort         " << effort_text(config) << '\n';
    check_connection(*config.machine);
    if (command.offline) {
        out << "the configuration is good; the machine was not asked\n";
        return ExitCode::done;
    }
    StopSignals signals;
    const std::unique_ptr<Machine> machine = connect(*config.machine, signals.token());
    const MachineReport report = machine->report();
    out << "machine        " << report.identity << "\nstate          " << report.state << ", at " << point_text(report.position) << '\n';
    bool good = !report.has_problems();
    const std::string problem = start_problem(*machine, workspace, config.machine->limits, report.position);
    if (!problem.empty()) out << "start          <- " << problem << '\n';
    good &= problem.empty();
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
    if (is_proven_by_hand(config.machine->probe_proof, Terminal::of_process().has_value())) {
        const bool works = see_probe_pressed(*machine, "go on without", output.console, signals);
        out << "  probe works: " << (works ? "yes, it closed and opened\n" : "not shown  <- look at its lead, plug and battery\n");
        good &= works;
    } else {
        out << "  probe works: not shown; the first touch of a session will (machine.probe_proof)\n";
    }
    out << (good ? "all is good; nothing has moved\n" : "mend what an arrow points at; nothing has moved\n");
    return good ? ExitCode::done : ExitCode::usage;
}

// What is concluded without a touch.
const char* inference_text(Strategy::Infer infer) {
    switch (infer) {
        case Strategy::Infer::none:
            return "nothing";
        case Strategy::Infer::reach:
            return "what the given reach proves";
        default:
            return "what the samples around make plausible, which is no proof";
    }
}

}  // namespace

ExitCode run(const CheckCommand& command, Output& output) {
    std::ostream& out = output.results;
    const SessionConfig config = with_its_files(read_config(command.config, command.overrides));
    for (const std::string& warning : calibration_warnings(config, std::chrono::system_clock::now())) spdlog::warn("{}", warning);
    if (config.machine) return check_machine(command, config, output);
    const Scene scene = build_scene(config);
    print_warnings(scene.object);
    warn_of_false_reach(config, scene.object);
    check_seeds(config, scene);
    const Box& bounds = scene.object.bounds();
    const Options& probing = config.probing;
    out << "object         " << point_text(bounds.min) << " to " << point_text(bounds.max) << ", " << scene.object.components()
        << " component(s), Euler characteristic " << scene.object.euler_characteristic() << '\n'
        << "reach          " << (scene.object.reach() ? fmt::format("{:f} mm", *scene.object.reach()) : std::string("not known")) << '\n'
        << "workspace      " << describe(scene.workspace) << "; contains the object\n"
        << "epsilon        " << probing.epsilon << " mm; a guarantee of topology needs a reach of at least "
        << probing.epsilon / kMaxEpsilonPerReach << " mm, "
        << (probing.reach ? fmt::format("given: {:f} mm", *probing.reach) : "none given") << '\n'
        << "strategy       " << to_string(probing.strategy) << "; infers " << inference_text(probing.inference()) << '\n'
        << "seeds          "
        << (probing.seed_rays.empty() ? "rays towards the centre of the workspace"
                                      : fmt::format("{} seed ray(s)", probing.seed_rays.size()))
        << "; they touch the object\n"
        << "effort         " << effort_text(probing, bounds.max - bounds.min) << '\n';
    tell_tool(config, scene.workspace, out);
    out << "the configuration is good\n";
    return ExitCode::done;
}

}  // namespace palpate
