#include "devices/grbl/stream_grbl_machine.h"

#include <utility>

#include "devices/grbl/grbl_report.h"

namespace palpate {

StreamGrblMachine::StreamGrblMachine(std::unique_ptr<ByteStream> stream, const GrblOptions& options, StopToken stop)
    : stream_(std::move(stream)), device_(*stream_, clock_, options, std::move(stop)) {}

MachineReport StreamGrblMachine::report() { return report_on(device_); }

bool StreamGrblMachine::is_position_trusted() {
    const grbl::Place place = device_.controller().place();
    return device_.controller().state() == grbl::State::idle && place.homed != false && !place.probe_unplugged;
}

}  // namespace palpate
