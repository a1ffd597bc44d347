#include "tools/machine.h"

#include "devices/errors.h"
#include "devices/grbl_report.h"

namespace palpate {

Machine::Machine(const MachineConfig& config, const std::stop_token& stop) {
    const GrblOptions options{config.kinematics, config.origin, config.homing};
    port_ = std::make_unique<SerialPort>(std::get<GrblSpec>(config.connection).port);
    grbl_ = std::make_unique<GrblDevice>(*port_, clock_, options, stop);
}

ProbeDevice& Machine::device() { return *grbl_; }
void Machine::make_ready() { grbl_->make_ready(); }
void Machine::retreat(const Point& target) { grbl_->retreat(target); }
bool Machine::is_probe_closed() { return grbl_->is_probe_closed(); }
bool Machine::is_position_trusted() { return grbl_->controller().state() == grbl::State::idle; }
MachineReport Machine::report() { return report_on(*grbl_); }

}  // namespace palpate
