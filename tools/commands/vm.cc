// palpate vm: a virtual machine for any program that drives one.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "config/reader.h"
#include "devices/errors.h"
#include "devices/posix/machine_lock.h"
#include "devices/posix/tcp_stream.h"
#include "sim/area_audit.h"
#include "sim/machines/external/virtual_program.h"
#include "sim/machines/grbl/grbl_host.h"
#include "sim/machines/modbus/virtual_modbus.h"
#include "tools/commands/commands.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"
#include "tools/simulation.h"
#include "tools/summary.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// So often it is asked whether it should end.
constexpr std::chrono::milliseconds kPoll{50};
// So long a hand presses the probe.
constexpr std::chrono::seconds kHand{1};
// "fast" of a Modbus controller: its axes run that much faster than the clock by which its heartbeat is watched.
constexpr double kSpeedup = 200.0;
// mm: the machine reaches a little farther than the session may go.
constexpr double kBeyondLimits = 1.0;

// The axes of the machine that the configuration describes, with the tool waiting above the workspace.
VirtualToolOptions tool_options(const SessionConfig& config, const Region& workspace) {
    const MachineConfig& machine = *config.machine;
    VirtualToolOptions options;
    options.motion = machine.motion;
    options.origin = machine.origin;
    const Vector beyond = Vector::Constant(kBeyondLimits);
    // Like a controller that homes to the upper ends of its axes and calls them 0.
    options.limits = {machine.limits.min + machine.origin - beyond, (machine.limits.max + machine.origin + beyond).cwiseMax(0.0)};
    options.errors = config.probe_errors();
    options.probe_feed_mm_per_s = machine.motion.feeds.probe_mm_per_s;
    options.start = workspace.center() + machine.origin;
    options.start.z() = machine.limits.max.z() + machine.origin.z();
    return options;
}

// What is hidden where neither the configuration nor the command names an object: a ring in the middle of the workspace.
ObjectSpec own_object(const WorkspaceSpec& workspace) {
    ShapeSpec ring;
    double room = 1.0;
    if (const auto* ball = std::get_if<Ball>(&workspace)) {
        ring.at = ball->center;
        room = ball->radius;
    } else if (const auto* box = std::get_if<Box>(&workspace)) {
        ring.at = box->center();
        room = (box->max - box->min).minCoeff() / 2;
    }
    ring.kind = TorusSpec{0.45 * room, 0.2 * room};
    return ring;
}

// Of tools with a body, and of areas that alone are to be probed.
struct BodyAudits {
    std::optional<ToolAudit> tool;
    std::optional<AreaAudit> area;
};

Json audit_of(const VirtualToolAudit& audit, const BodyAudits& body) {
    Json json{{"moves", audit.moves},
              {"unguarded_moves", audit.unguarded_moves},
              {"outside_limits", audit.outside_limits},
              {"unsafe_moves", audit.unsafe_moves},
              {"fast_moves_inside", audit.fast_moves_inside},
              {"deepest_mm", audit.deepest_mm},
              {"deepest_end_mm", audit.deepest_end_mm},
              {"distance_mm", audit.distance_mm}};
    if (body.area) json["moves_out_of_area"] = body.area->moves_out();
    if (body.tool) json["tool"] = to_json(body.tool->account());
    return json;
}

void report(const VmCommand& command, const Json& audit, std::ostream& out) {
    const std::string text = audit.dump(2) + '\n';
    if (command.audit.empty()) {
        out << text;
    } else {
        write_file(command.audit, text);
    }
}

// SIGUSR1 is the hand that presses the probe.
volatile std::sig_atomic_t is_hand_wanted = 0;
void want_hand(int /*signal*/) { is_hand_wanted = 1; }

// Until the end is asked for; `press` holds the probe closed, or lets go of it.
void wait(StopSignals& signals, const std::function<void(bool)>& press) {
    struct sigaction action {};
    action.sa_handler = want_hand;
    ::sigaction(SIGUSR1, &action, nullptr);
    std::optional<std::chrono::steady_clock::time_point> release;
    while (!signals.token().stop_requested()) {
        signals.pause();
        if (is_hand_wanted != 0) {
            is_hand_wanted = 0;
            press(true);
            release = std::chrono::steady_clock::now() + kHand;
        }
        if (release && std::chrono::steady_clock::now() >= *release) {
            press(false);
            release.reset();
        }
        std::this_thread::sleep_for(kPoll);
    }
}

// The link to a virtual machine's port while it runs: another one may take over what a dead one left, but nothing else. Throws SetupError
// if a running machine has it.
MachineLock own_link(const std::filesystem::path& link) {
    const std::filesystem::path folder = std::filesystem::weakly_canonical(std::filesystem::absolute(link).parent_path());
    try {
        return MachineLock::of_name((folder / link.filename()).string());
    } catch (const DeviceError&) {
        throw SetupError(fmt::format("{}: leads to a virtual machine that runs; end it first, or choose another link", link.string()));
    }
}

// Of "HOST:PORT", which `option` was given.
int port_of(const char* option, const std::string& where) {
    const auto address = parse_host_port(where);
    if (!address) throw SetupError(fmt::format("{}: {} is no HOST:PORT", option, where));
    if (address->host != "127.0.0.1" && address->host != "localhost") {
        throw SetupError(fmt::format("{}: {}: a virtual machine is for this computer alone; allowed: 127.0.0.1:PORT", option, where));
    }
    return address->port;
}

// What moves in a machine, and who watches it.
struct Axes {
    const Obstacle& obstacle;
    VirtualToolOptions options;
    const BodyAudits& body;
};

// On a line that may be taken.
template <class Host, class Machine, class Options>
std::unique_ptr<Host> serve(Machine& machine, const Options& options) {
    try {
        return std::make_unique<Host>(machine, options);
    } catch (const ConnectionLost& error) {
        throw SetupError(fmt::format("{}: give another one, or end what uses it", error.what()));
    }
}

void run_grbl(const VmCommand& command, const Axes& axes, StopSignals& signals, std::ostream& out) {
    VirtualTool tool(axes.obstacle, axes.options);
    VirtualGrblOptions options;
    options.dialect = command.dialect == "grblhal"   ? GrblDialect::grblhal
                      : command.dialect == "fluidnc" ? GrblDialect::fluidnc
                                                     : GrblDialect::grbl;
    options.locked = command.locked;
    options.soft_limits = true;
    options.homed_position = axes.options.start;
    options.spurious_rate = command.spurious;
    options.bounce_rate = command.bounce;
    options.miss_rate = command.miss;
    options.seed = command.seed;
    VirtualGrbl grbl(tool, options);
    GrblHostOptions where;
    where.time = command.fast ? GrblHostOptions::Time::fast : GrblHostOptions::Time::real;
    const std::string name = command.grbl.string();
    if (is_tcp_address(name)) {
        where.tcp_port = port_of("--grbl", name.substr(kTcpScheme.size()));
        where.greets_clients = options.dialect == GrblDialect::grblhal;
    } else {
        where.link = command.grbl;
    }
    {
        const std::unique_ptr<GrblHost> served = serve<GrblHost>(grbl, where);
        GrblHost& host = *served;
        out << "virtual " << command.dialect << " on " << (where.tcp_port ? "" : name + " -> ") << host.client_path() << "; Ctrl-C ends it"
            << std::endl;
        wait(signals, [&](bool pressed) { host.with([&](VirtualGrbl&) { tool.press(pressed); }); });
    }
    signals.release();
    report(command, audit_of(tool.audit(), axes.body), out);
}

std::unique_ptr<VirtualModbus> start_modbus(const Obstacle& obstacle, const VirtualModbusOptions& options,
                                            const std::variant<VirtualModbusTcp, VirtualModbusSerial>& where, int unit) {
    try {
        return std::make_unique<VirtualModbus>(obstacle, options, where, unit);
    } catch (const std::system_error& error) {
        throw SetupError(fmt::format("{}: give another port, or end what uses it", error.what()));
    }
}

void run_modbus(const VmCommand& command, const Axes& axes, int unit, StopSignals& signals, std::ostream& out) {
    VirtualModbusOptions options;
    options.tool = axes.options;
    options.homed = !command.locked;
    options.speedup = command.fast ? kSpeedup : 1.0;
    std::variant<VirtualModbusTcp, VirtualModbusSerial> where = VirtualModbusSerial{command.modbus_rtu};
    if (!command.modbus.empty()) where = VirtualModbusTcp{port_of("--modbus", command.modbus)};
    const std::unique_ptr<VirtualModbus> machine = start_modbus(axes.obstacle, options, where, unit);
    VirtualModbus& modbus = *machine;
    const ModbusLinkOptions link = modbus.link();
    out << "virtual Modbus controller, unit " << link.unit << ", ";
    if (const auto* tcp = std::get_if<ModbusTcp>(&link.where)) out << "on " << tcp->host << ':' << tcp->port;
    if (const auto* rtu = std::get_if<ModbusRtu>(&link.where)) out << "on " << command.modbus_rtu.string() << " -> " << rtu->path;
    out << "; Ctrl-C ends it" << std::endl;
    wait(signals,
         [&](bool pressed) { modbus.with_controller([&](VirtualModbusController& controller) { controller.tool().press(pressed); }); });
    signals.release();
    report(command, modbus.with_controller([&](const VirtualModbusController& controller) {
        return audit_of(controller.tool().audit(), axes.body);
    }),
           out);
}

void run_external(const VmCommand& command, const Axes& axes, StopSignals& signals, std::ostream& out) {
    VirtualTool tool(axes.obstacle, axes.options);
    VirtualProgramOptions options;
    options.port = port_of("--external", command.external);
    options.is_fast = command.fast;
    options.homed = !command.locked;
    {
        const std::unique_ptr<VirtualProgram> program = serve<VirtualProgram>(tool, options);
        out << "virtual machine with a program of its own on " << program->address() << "; Ctrl-C ends it" << std::endl;
        wait(signals, [&](bool pressed) { program->with([&](VirtualTool& t) { t.press(pressed); }); });
    }
    signals.release();
    report(command, audit_of(tool.audit(), axes.body), out);
}

}  // namespace

ExitCode run(const VmCommand& command, Output& output) {
    StopSignals signals;
    std::ostream& out = output.results;
    SessionConfig config = read_config(command.config, command.overrides);
    if (!command.object.empty()) config.object = MeshSpec{command.object};
    if (!config.object) config.object = own_object(config.workspace);
    if (!config.machine) throw SetupError("machine: missing; a virtual machine needs to know how it moves");
    const int kinds = (command.grbl.empty() ? 0 : 1) + (command.modbus.empty() ? 0 : 1) + (command.modbus_rtu.empty() ? 0 : 1) +
                      (command.external.empty() ? 0 : 1);
    if (kinds != 1) throw SetupError("give one of --grbl LINK, --modbus HOST:PORT, --modbus-rtu LINK, --external HOST:PORT");
    if (command.grbl.empty() && (command.spurious > 0 || command.bounce > 0 || command.miss > 0 || command.dialect != "grbl")) {
        throw SetupError("--spurious, --bounce, --miss and --dialect are of the virtual GRBL controller: leave them out, or give --grbl");
    }
    const auto is_share = [](double x) { return x >= 0 && x <= 1; };
    if (!is_share(command.spurious) || !is_share(command.bounce) || !is_share(command.miss)) {
        throw SetupError("--spurious, --bounce, --miss: allowed: from 0 to 1");
    }
    for (const std::filesystem::path& input : inputs_of(config, command.config)) {
        std::error_code ignored;
        if (std::filesystem::equivalent(input, command.audit, ignored))
            throw SetupError(fmt::format("--audit {}: is read by this run; choose another file", command.audit.string()));
    }
    if (!command.audit.empty()) write_file(command.audit, "");  // what cannot be written is found out now
    MachineLock owner;
    const bool has_link = command.modbus.empty() && command.external.empty() && !is_tcp_address(command.grbl.string());
    if (has_link) owner = own_link(command.grbl.empty() ? command.modbus_rtu : command.grbl);
    const Scene scene = build_scene(config);
    const std::optional<ToolScene> tool = tool_scene(config, scene.object);
    BodyAudits body;
    Axes axes{obstacle_of(scene.object, tool), tool_options(config, scene.workspace.region()), body};
    if (tool) {
        const MotionModel& motion = config.machine->motion;
        const double tolerance = motion.overtravel_mm + motion.resolution_mm + ToolAudit::kTolerance_mm;
        body.tool.emplace(tool->depths, tolerance);
        if (config.area) body.area.emplace(*config.area, std::get<Box>(config.workspace), motion.resolution_mm + ToolAudit::kTolerance_mm);
        axes.options.on_move = [&body](const Segment& way, bool touched) {
            body.tool->record(way, touched);
            if (body.area) body.area->record(way);
        };
    }
    if (!command.external.empty()) {
        run_external(command, axes, signals, out);
    } else if (command.grbl.empty()) {
        const auto* modbus = std::get_if<ModbusSpec>(&config.machine->connection);
        run_modbus(command, axes, modbus != nullptr ? modbus->link.unit : 1, signals, out);
    } else {
        run_grbl(command, axes, signals, out);
    }
    return ExitCode::done;
}

}  // namespace palpate
