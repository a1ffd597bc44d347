#include "tools/machine.h"

#include <fmt/format.h>

#include "config/modbus_profile_reader.h"
#include "devices/grbl/serial_grbl_machine.h"
#include "devices/modbus/modbus_machine.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

ModbusProfile profile_of(const ModbusSpec& modbus) {
    return modbus.profile.empty() ? ModbusProfile::standard() : read_modbus_profile(modbus.profile);
}

void check(const GrblSpec& /*grbl*/) {}
void check(const ModbusSpec& modbus) { (void)profile_of(modbus); }

std::unique_ptr<Machine> connect_to(const GrblSpec& grbl, const MachineSettings& settings, const std::stop_token& stop) {
    return std::make_unique<SerialGrblMachine>(grbl.port, GrblOptions{settings.motion, settings.origin, settings.homing}, stop);
}

std::unique_ptr<Machine> connect_to(const ModbusSpec& modbus, const MachineSettings& settings, const std::stop_token& stop) {
    ModbusDeviceOptions options;
    options.link = modbus.link;
    options.profile = profile_of(modbus);
    options.motion = settings.motion;
    options.origin = settings.origin;
    return std::make_unique<ModbusMachine>(options, stop);
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

std::unique_ptr<Machine> connect(const MachineConfig& config, const std::stop_token& stop) {
    return std::visit([&](const auto& spec) { return connect_to(spec, config, stop); }, config.connection);
}

std::string describe_plan(const MachineReport& report, bool homes_first, const std::string& what) {
    constexpr const char* kHoming =
        "\nIt will be homed first, unguarded, from where it is: make sure that the way of the homing cycle is free.";
    return fmt::format(
        "machine    {}\n"
        "state      {}, at {}\n"
        "{}{}",
        report.identity, report.state, point_text(report.position), what, homes_first ? kHoming : "");
}

std::string describe_plan(const PlannedMotion& plan) { return describe_plan(plan.report, plan.homes_first, to_sentence(plan.kind)); }

}  // namespace palpate
