#include "tools/machine.h"

#include <sstream>

#include "config/modbus_profile_reader.h"
#include "devices/grbl_report.h"
#include "devices/modbus_bits.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

ModbusDeviceOptions options_for(const MachineConfig& config, const ModbusSpec& modbus) {
    ModbusDeviceOptions options;
    options.link = modbus.link;
    if (!modbus.profile.empty()) options.profile = read_modbus_profile(modbus.profile);
    options.kinematics = config.kinematics;
    options.origin = config.origin;
    return options;
}

MachineReport to_report(const ModbusReport& said, const Point& origin) {
    MachineReport report;
    report.identity = said.identity + ", " + said.link + ", profile " + said.profile;
    report.state = said.fault_code != 0 ? "fault" : !said.is_homed ? "not homed" : said.is_standing ? "standing" : "moving";
    report.position = said.position - origin;
    report.reach = Box{said.limits.min - origin, said.limits.max - origin};
    const auto add = [&](const char* name, bool good, const char* value, const char* otherwise, const char* problem) {
        report.settings.push_back({name, good ? value : otherwise, good ? "" : problem});
    };
    add("homed", said.is_homed, "yes", "no", "home it at its own panel: nobody knows where the tool is");
    report.settings.push_back({"fault", said.lines().back(), said.fault_code == 0 ? "" : "clear its cause"});
    add("probe", !said.is_probe_closed, "open", "closed", "free it, or look at its lead");
    if (const std::string problem = said.position_problem(); !problem.empty()) {
        report.settings.push_back({"position", point_text(said.position) + " (machine)", problem});
    }
    report.settings.push_back({"answers", said.timing_text(), said.timing_problem()});
    return report;
}

}  // namespace

Machine::Machine(const MachineConfig& config, const std::stop_token& stop) : origin_(config.origin) {
    if (const auto* grbl = std::get_if<GrblSpec>(&config.connection)) {
        port_ = std::make_unique<SerialPort>(grbl->port);
        grbl_ = std::make_unique<GrblDevice>(*port_, clock_, GrblOptions{config.kinematics, config.origin, config.homing}, stop);
    } else {
        modbus_ = std::make_unique<ModbusDevice>(options_for(config, std::get<ModbusSpec>(config.connection)), clock_, stop);
    }
}

ProbeDevice& Machine::device() {
    if (grbl_) return *grbl_;
    return *modbus_;
}

void Machine::make_ready() {
    if (grbl_) return grbl_->make_ready();
    if (modbus_->state() != ModbusDevice::State::idle) modbus_->recover();
}

void Machine::retreat(const Point& target) { grbl_ ? grbl_->retreat(target) : modbus_->retreat(target); }

bool Machine::is_probe_closed() { return grbl_ ? grbl_->is_probe_closed() : modbus_->report().is_probe_closed; }

bool Machine::is_position_trusted() {
    if (grbl_) {
        const grbl::Place place = grbl_->controller().place();
        return grbl_->controller().state() == grbl::State::idle && place.homed != false && !place.probe_unplugged;
    }
    // A controller that stopped because its host fell silent knows where it is.
    const ModbusReport report = modbus_->report();
    return report.is_homed && (report.fault_code == 0 || report.fault_code == cia402::kHeartbeatFault);
}

MachineReport Machine::report() { return grbl_ ? report_on(*grbl_) : to_report(modbus_->report(), origin_); }

std::string describe_plan(const MachineConfig& config, const MachineReport& report, const std::string& what) {
    std::ostringstream out;
    out << "machine    " << report.identity << "\nstate      " << report.state << ", at " << point_text(report.position) << '\n' << what;
    const bool needs_homing = report.state.rfind("Alarm", 0) == 0 || report.state.find("not homed") != std::string::npos;
    if (config.homing == Homing::run && needs_homing) {
        out << "\nIt will be homed first, unguarded, from where it is: make sure that the way of the homing cycle is free.";
    }
    return out.str();
}

}  // namespace palpate
