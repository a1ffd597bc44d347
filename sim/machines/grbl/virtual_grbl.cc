#include "sim/machines/grbl/virtual_grbl.h"

#include "sim/machines/grbl/internal/grbl_machine.h"

namespace palpate {

VirtualGrbl::VirtualGrbl(VirtualTool& tool, const VirtualGrblOptions& options) : machine_(std::make_unique<GrblMachine>(tool, options)) {}
VirtualGrbl::~VirtualGrbl() = default;
VirtualGrbl::VirtualGrbl(VirtualGrbl&&) noexcept = default;

void VirtualGrbl::receive(std::string_view bytes) { machine_->receive(bytes); }
void VirtualGrbl::advance(Seconds time) { machine_->advance(time); }
std::string VirtualGrbl::take_output() { return machine_->take_output(); }
std::string VirtualGrbl::banner() const { return machine_->banner(); }
std::optional<Seconds> VirtualGrbl::time_to_event() const { return machine_->time_to_event(); }
void VirtualGrbl::press_reset() { machine_->press_reset(); }
VirtualGrbl::Link VirtualGrbl::link() const { return machine_->link(); }
void VirtualGrbl::unplug() { machine_->unplug(); }
void VirtualGrbl::plug_in() { machine_->plug_in(); }
const VirtualGrbl::Counts& VirtualGrbl::counts() const { return machine_->counts(); }
const VirtualTool& VirtualGrbl::tool() const { return machine_->tool(); }
Seconds VirtualGrbl::now() const { return machine_->now(); }

}  // namespace palpate
