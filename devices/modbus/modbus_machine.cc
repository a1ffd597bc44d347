#include "devices/modbus/modbus_machine.h"

#include <fmt/format.h>

#include <utility>

#include "devices/modbus/modbus_bits.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

MachineReport to_report(const ModbusReport& said, const Point& origin) {
    MachineReport report;
    report.identity = fmt::format("{}, {}, profile {}", said.identity, said.link, said.profile);
    report.state = said.is_in_fault ? "fault" : !said.is_homed ? "not homed" : said.is_standing ? "standing" : "moving";
    report.needs_homing = !said.is_homed;
    report.position = said.position - origin;
    report.reach = Box{said.limits.min - origin, said.limits.max - origin};
    const auto add = [&](const char* name, bool good, const char* value, const char* otherwise, const char* problem) {
        report.settings.push_back({name, good ? value : otherwise, good ? "" : problem});
    };
    add("homed", said.is_homed, "yes", "no", "home it at its own panel: nobody knows where the tool is");
    report.settings.push_back({"fault", said.lines().back(), said.is_in_fault ? "clear its cause" : ""});
    add("probe", !said.is_probe_closed, "open", "closed", "free it, or look at its lead");
    if (const std::string problem = said.position_problem(); !problem.empty()) {
        report.settings.push_back({"position", fmt::format("{} (machine)", point_text(said.position)), problem});
    }
    report.settings.push_back({"unit of positions", number_text(said.position_unit_mm, " mm"), said.unit_problem()});
    report.settings.push_back({"answers", said.timing_text(), said.timing_problem()});
    return report;
}

}  // namespace

ModbusMachine::ModbusMachine(const ModbusDeviceOptions& options, StopToken stop)
    : origin_(options.origin), device_(options, clock_, std::move(stop)) {}

MachineReport ModbusMachine::report() { return to_report(device_.report(), origin_); }

void ModbusMachine::make_ready() {
    // A controller that stopped because its host fell silent, between two moves perhaps, is told of it by nobody else.
    if (device_.state() != ModbusDevice::State::idle || device_.report().fault_code == cia402::kHeartbeatFault) device_.recover();
}

// A controller that stopped because its host fell silent knows where it is.
bool ModbusMachine::is_position_trusted() {
    const ModbusReport said = device_.report();
    return said.is_homed && (!said.is_in_fault || said.fault_code == cia402::kHeartbeatFault);
}

}  // namespace palpate
