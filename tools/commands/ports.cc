// palpate ports: which serial ports there are.
#include <ostream>

#include "devices/posix/port_list.h"
#include "tools/commands/commands.h"

namespace palpate {

ExitCode run(const PortsCommand&, Output& output) {
    std::ostream& out = output.results;
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
