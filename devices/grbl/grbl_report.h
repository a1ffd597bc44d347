// The settings of a GRBL-family controller against what a session asks of it.
#pragma once

#include "devices/grbl/grbl_device.h"
#include "devices/machine_report.h"

namespace palpate {

// Reads what the device learnt when it connected, and asks for its status and modes ($G). Moves nothing and changes nothing. Throws what
// Controller::place() throws.
[[nodiscard]] MachineReport report_on(GrblDevice& device);

}  // namespace palpate
