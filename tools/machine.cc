#include "tools/machine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "config/modbus_profile_reader.h"
#include "devices/external/external_machine.h"
#include "devices/grbl/stream_grbl_machine.h"
#include "devices/modbus/modbus_machine.h"
#include "devices/posix/child_stream.h"
#include "devices/posix/serial_port.h"
#include "devices/posix/tcp_stream.h"
#include "planner/number_text.h"
#include "tools/session_plan.h"
#include "tools/session_surroundings.h"

namespace palpate {
namespace {

// Of a wireless network with something else on it.
constexpr Seconds kNetworkDelay{0.5};

ModbusProfile profile_of(const ModbusSpec& modbus) {
    return modbus.profile.empty() ? ModbusProfile::standard() : read_modbus_profile(modbus.profile);
}

void check(const GrblSpec& /*grbl*/) {}
void check(const ModbusSpec& modbus) { (void)profile_of(modbus); }
void check(const ExternalSpec& /*external*/) {}

std::unique_ptr<Machine> connect_to(const GrblSpec& grbl, const MachineSettings& settings, const StopToken& stop) {
    const auto address = grbl.address();
    const Seconds delay = grbl.delay.value_or(address ? kNetworkDelay : Seconds(0));
    const GrblOptions options{settings.motion, settings.origin, settings.homing, std::chrono::ceil<std::chrono::milliseconds>(delay),
                              grbl.boot_time};
    std::unique_ptr<ByteStream> stream;
    if (address) {
        stream = std::make_unique<TcpStream>(*address);
    } else {
        stream = std::make_unique<SerialPort>(grbl.port);
    }
    return std::make_unique<StreamGrblMachine>(std::move(stream), options, stop);
}

std::unique_ptr<Machine> connect_to(const ModbusSpec& modbus, const MachineSettings& settings, const StopToken& stop) {
    ModbusDeviceOptions options;
    options.link = modbus.link;
    options.profile = profile_of(modbus);
    options.motion = settings.motion;
    options.origin = settings.origin;
    return std::make_unique<ModbusMachine>(options, stop);
}

std::unique_ptr<Machine> connect_to(const ExternalSpec& external, const MachineSettings& settings, const StopToken& stop) {
    ExternalOptions options{settings.motion, settings.origin, external.silence, external.slowest_answer, external.start_time};
    options.homing = settings.homing;
    options.touch_error_mm = settings.touch_error();
    options.touch_pace = settings.touch.samples > 1 ? Pace::touch : Pace::probe;
    std::unique_ptr<ByteStream> stream;
    if (external.command.empty()) {
        stream = std::make_unique<TcpStream>(*parse_host_port(external.address));
    } else {
        stream = std::make_unique<ChildStream>(external.command);
    }
    return std::make_unique<ExternalMachine>(std::move(stream), options, stop);
}

std::string describe_connecting(const GrblSpec& grbl) {
    const char* const opening = grbl.address()    ? ""
                                : grbl.port.reset ? ": opening it resets what is on it"
                                                  : ": opening it may reset what is on it";
    return fmt::format(
        "connecting to {}{}; what stays silent is sent a reset (Ctrl-X) twice, as some controllers hear nothing else; up to {} s",
        grbl.port.path, opening, number_text(grbl.boot_time.count()));
}

std::string describe_connecting(const ModbusSpec& modbus) {
    const auto* tcp = std::get_if<ModbusTcp>(&modbus.link.where);
    const std::string where = tcp != nullptr ? fmt::format("{}:{}", tcp->host, tcp->port) : std::get<ModbusRtu>(modbus.link.where).path;
    return fmt::format("connecting to unit {} at {}, whose answers are waited for up to {} s each", modbus.link.unit, where,
                       number_text(modbus.link.answer_timeout.count()));
}

std::string describe_connecting(const ExternalSpec& external) {
    return external.command.empty() ? fmt::format("connecting to the program at {}", external.address)
                                    : fmt::format("starting {}", fmt::join(external.command, " "));
}

const char* to_sentence(PlannedMotion::Kind kind) {
    switch (kind) {
        case PlannedMotion::Kind::begin:
            return "It will move, guarded, around and into the workspace until it has found the part's shape.";
        case PlannedMotion::Kind::go_on:
            return "It will go back to where the session ended, touch up to three known places again, all at the feed of probes, and go "
                   "on.";
    }
    return "";
}

}  // namespace

void check_connection(const MachineConfig& config) {
    std::visit([](const auto& spec) { check(spec); }, config.connection);
}

std::unique_ptr<Machine> connect(const MachineConfig& config, const StopToken& stop) {
    spdlog::info("{}", std::visit([](const auto& spec) { return describe_connecting(spec); }, config.connection));
    return std::visit([&](const auto& spec) { return connect_to(spec, config, stop); }, config.connection);
}

std::string describe_plan(const MachineReport& report, const MachineConfig& machine, const std::string& what) {
    constexpr const char* kHoming =
        "\nIt will be homed first, unguarded, from where it is: make sure that the way of the homing cycle is free.";
    const Feeds& feeds = machine.motion.feeds;
    return fmt::format(
        "machine    {}\n"
        "state      {}, at {}\n"
        "limits     {} to {}\n"
        "feeds      {} mm/s travel, {} mm/s probing, {} mm/s for a second touch\n"
        "{}{}",
        report.identity, report.state, point_text(report.position), point_text(machine.limits.min), point_text(machine.limits.max),
        feeds.travel_mm_per_s, feeds.probe_mm_per_s, feeds.touch_mm_per_s, what, machine.homes_first(report) ? kHoming : "");
}

std::string describe_plan(const PlannedMotion& plan, const SessionConfig& config) {
    std::string text = fmt::format("workspace  {}\n", describe(machine_workspace(config)));
    if (plan.first_target) {
        const bool is_touch = plan.first_pace == Pace::probe;
        text += fmt::format("first move {} {}\n", is_touch ? "a probe towards" : "to", point_text(*plan.first_target));
    }
    if (plan.kind == PlannedMotion::Kind::begin) {
        text += fmt::format("effort     {}\n", effort_text(config));
    }
    text += to_sentence(plan.kind);
    if (const auto& datum = config.machine->datum) {
        text += fmt::format(" It will touch the datum in {} place(s) {}, at the latest after every {} touches of the part, and in the end.",
                            datum->touches.size(), plan.kind == PlannedMotion::Kind::begin ? "first" : "before", datum->every);
    }
    return describe_plan(plan.report, *config.machine, text);
}

}  // namespace palpate
