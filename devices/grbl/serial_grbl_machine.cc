#include "devices/grbl/serial_grbl_machine.h"

#include <utility>

#include "devices/grbl/grbl_report.h"

namespace palpate {

SerialGrblMachine::SerialGrblMachine(const SerialPortOptions& port, const GrblOptions& options, StopToken stop)
    : port_(port), device_(port_, clock_, options, std::move(stop)) {}

MachineReport SerialGrblMachine::report() { return report_on(device_); }

bool SerialGrblMachine::is_position_trusted() {
    const grbl::Place place = device_.controller().place();
    return device_.controller().state() == grbl::State::idle && place.homed != false && !place.probe_unplugged;
}

}  // namespace palpate
