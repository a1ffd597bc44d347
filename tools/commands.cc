#include "tools/commands.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <iostream>
#include <sstream>

#include "config/config_error.h"
#include "config/modbus_profile_reader.h"
#include "config/reader.h"
#include "config/strategy_names.h"
#include "config/writer.h"
#include "devices/errors.h"
#include "devices/journaling_device.h"
#include "planner/errors.h"
#include "planner/number_text.h"
#include "sim/errors.h"
#include "tools/anytime.h"
#include "tools/bench.h"
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

// A reach written with a few digits less than the true one has is not a false one.
constexpr double kRounding = 1e-6;

void print_warnings(const HiddenObject& object) {
    for (const std::string& warning : object.warnings()) spdlog::warn("{}", warning);
}

// A simulation knows better than the user; a certificate that rests on a false premise should not go unnoticed.
void warn_of_false_reach(const SessionConfig& config, const HiddenObject& object) {
    if (config.probing.reach && object.reach() && *config.probing.reach > *object.reach() * (1 + kRounding)) {
        spdlog::warn("probing.reach = {} mm is more than the object's true reach, {} mm: what the certificate rests on is false",
                     *config.probing.reach, *object.reach());
    }
}

void warn_of_other_truth(const Simulation& run) {
    const Topology& found = run.result.topology;
    if (found.euler_characteristic != run.truth.euler_characteristic || static_cast<int>(found.components) != run.truth.components) {
        spdlog::warn(
            "the mesh has {} component(s) and Euler characteristic {}, the hidden object {} and {}: make epsilon smaller, or give seed "
            "rays",
            found.components, found.euler_characteristic, run.truth.components, run.truth.euler_characteristic);
    }
}

// Runs with a progress line on standard error.
Simulation simulate_with_progress(const SessionConfig& config, const Scene& scene) {
    return with_progress([&](const auto& on_progress) { return simulate(config, scene, on_progress); });
}

std::string describe_truth(const Simulation& run) {
    std::ostringstream text;
    text << "Euler characteristic " << run.truth.euler_characteristic << ", " << run.truth.components
         << " component(s), Hausdorff distance " << run.truth.hausdorff << " mm, " << run.unsafe_moves << " unsafe moves";
    return text.str();
}

// Everything that a session on the machine would refuse is refused here, and nothing moves.
ExitCode check_machine(const CheckCommand& command, const SessionConfig& config, std::ostream& out) {
    const Workspace workspace = machine_workspace(config);
    const Kinematics& k = config.machine->kinematics;
    out << "workspace      around " << point_text(workspace.center()) << ", radius " << workspace.radius() << " mm; within machine.limits\n"
        << "epsilon        " << config.probing.epsilon << " mm; touches are taken to be exact to " << config.probing.touch_error << " mm\n"
        << "stopping       " << stopping_distance(k, k.feeds.travel_mm_per_s) << " mm from travel, "
        << stopping_distance(k, k.feeds.probe_mm_per_s) << " mm from a touch; the probe gives way by " << k.overtravel_mm << " mm\n";
    if (config.object) (void)HiddenObject(*config.object);
    const auto* modbus = std::get_if<ModbusSpec>(&config.machine->connection);
    if (modbus != nullptr && !modbus->profile.empty()) (void)read_modbus_profile(modbus->profile);
    if (command.offline) {
        out << "the configuration is good; the machine was not asked\n";
        return ExitCode::done;
    }
    const StopSignals signals;
    Machine machine(*config.machine, signals.token());
    const MachineReport report = machine.report();
    out << "machine        " << report.identity << "\nstate          " << report.state << ", at " << point_text(report.position) << '\n';
    bool good = !report.has_problems();
    for (const MachineSetting& setting : report.settings) {
        out << "  " << setting.name << ": " << setting.value << (setting.problem.empty() ? "" : "  <- " + setting.problem) << '\n';
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
        const bool works = see_probe_pressed(machine, STDIN_FILENO, "go on without", std::cerr, signals.token());
        out << "  probe works: " << (works ? "yes, it closed and opened\n" : "not shown  <- look at its lead, plug and battery\n");
        good &= works;
    } else {
        out << "  probe works: not shown; the first touch of a session will (machine.probe_proof)\n";
    }
    out << (good ? "all is good; nothing has moved\n" : "mend what an arrow points at; nothing has moved\n");
    return good ? ExitCode::done : ExitCode::usage;
}

}  // namespace

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
    return run.result.certificate.status == Certificate::Status::incomplete ? ExitCode::incomplete : ExitCode::done;
}

ExitCode run(const PictureCommand& command, std::ostream& out) {
    draw_session_picture(command.folder, command.up);
    out << "written to     " << (command.folder / kPictureFile).string() << '\n';
    return ExitCode::done;
}

ExitCode run(const CheckCommand& command, std::ostream& out) {
    const SessionConfig config = read_config(command.config, command.overrides);
    if (config.machine) return check_machine(command, config, out);
    const Scene scene = build_scene(config);
    print_warnings(scene.object);
    warn_of_false_reach(config, scene.object);
    const Bounds& bounds = scene.object.bounds();
    const Options& probing = config.probing;
    out << "object         " << point_text(bounds.min) << " to " << point_text(bounds.max) << ", " << scene.object.components()
        << " component(s), Euler characteristic " << scene.object.euler_characteristic() << '\n'
        << "reach          " << (scene.object.reach() ? std::to_string(*scene.object.reach()) + " mm" : std::string("not known")) << '\n'
        << "workspace      around " << point_text(scene.workspace.center()) << ", radius " << scene.workspace.radius()
        << " mm; contains the object\n"
        << "epsilon        " << probing.epsilon << " mm; a guarantee of topology needs a reach of at least "
        << probing.epsilon / kMaxEpsilonPerReach << " mm, "
        << (probing.reach ? "given: " + std::to_string(*probing.reach) + " mm" : "none given") << '\n'
        << "strategy       " << to_string(probing.strategy) << '\n'
        << "seeds          "
        << (probing.seed_rays.empty() ? "rays towards the centre of the workspace"
                                      : std::to_string(probing.seed_rays.size()) + " seed ray(s)")
        << "\nthe configuration is good\n";
    return ExitCode::done;
}

ExitCode run(const BenchCommand& command, std::ostream& out) {
    std::vector<Strategy> strategies;
    for (const std::string& name : command.strategies) strategies.push_back(parse_strategy(name));
    // All that can fail without a run fails before the first.
    const std::filesystem::path csv = command.output.string() + ".csv";
    const std::filesystem::path other = command.output.string() + (command.anytime ? ".svg" : ".json");
    if (command.anytime && command.configs.size() != 1) throw SetupError("bench --anytime draws one plot: give one configuration");
    for (const auto& file : {csv, other}) {
        if (!command.force && std::filesystem::exists(file)) {
            throw OutputError(file.string() + ": exists; choose another name with -o, or give --force to replace it");
        }
    }
    if (!std::filesystem::exists(csv)) {
        write_file(csv, "");
        std::filesystem::remove(csv);
    }
    std::vector<std::pair<SessionConfig, Scene>> scenes;
    for (const auto& file : command.configs) {
        SessionConfig config = read_config(file, command.overrides);
        Scene scene = build_scene(config);
        print_warnings(scene.object);
        warn_of_false_reach(config, scene.object);
        scenes.emplace_back(std::move(config), std::move(scene));
    }

    if (command.anytime) {
        out << "method, probes, displacement (mm), Hausdorff distance (mm)\n";
        const auto points =
            measure_anytime(command.configs[0].stem().string(), scenes[0].first, scenes[0].second, strategies, [&](const AnytimePoint& p) {
                out << p.method << ", " << p.probes << ", " << p.displacement << ", " << p.hausdorff << std::endl;
            });
        write_file(csv, anytime_csv(points));
        write_file(other, anytime_svg(points));
        return ExitCode::done;
    }

    std::vector<BenchRow> rows;
    bool incomplete = false;
    for (std::size_t k = 0; k < scenes.size(); ++k) {
        auto& [config, scene] = scenes[k];
        for (const Strategy& strategy : strategies) {
            config.probing.strategy = strategy;
            rows.push_back({command.configs[k].stem().string(), strategy, config.probing.epsilon, simulate_with_progress(config, scene)});
            warn_of_other_truth(rows.back().run);
            incomplete |= rows.back().run.result.certificate.status == Certificate::Status::incomplete;
        }
    }
    out << bench_table(rows);
    write_file(csv, bench_csv(rows));
    write_file(other, bench_json(rows));
    return incomplete ? ExitCode::incomplete : ExitCode::done;
}

ExitCode explain_current_exception() {
    const auto say = [](const std::exception& error, ExitCode code) {
        std::cerr << "palpate: " << error.what() << '\n';
        return code;
    };
    try {
        throw;
    } catch (const ConfigError& error) {
        return say(error, ExitCode::usage);
    } catch (const ObjectError& error) {
        return say(error, ExitCode::usage);
    } catch (const SetupError& error) {
        return say(error, ExitCode::usage);
    } catch (const OutputError& error) {
        return say(error, ExitCode::usage);
    } catch (const SeedError& error) {
        return say(error, ExitCode::usage);
    } catch (const std::invalid_argument& error) {
        return say(error, ExitCode::usage);
    } catch (const DeviceError& error) {
        return say(error, ExitCode::device);
    } catch (const ContradictionError& error) {
        return say(error, ExitCode::device);
    } catch (const JournalDamaged& error) {
        return say(error, ExitCode::usage);
    } catch (const ReplayMismatch& error) {
        return say(error, ExitCode::usage);
    } catch (const std::exception& error) {
        std::cerr << "palpate: internal error: " << error.what()
                  << "\nThis is a bug; please report it with the configuration that shows it.\n";
        return ExitCode::internal;
    }
}

}  // namespace palpate
