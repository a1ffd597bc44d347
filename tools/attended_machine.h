// A machine that moves once somebody has agreed: for commands that touch without a session.
#pragma once

#include <string>

#include "config/machine_config.h"
#include "devices/session/guarded_machine.h"
#include "tools/terminal/console.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {

// Shows the machine, its limits and feeds and `what` it will do, asks whether it may (`yes`: it may), has the probe pressed by hand if the
// configuration wants that, and makes the machine ready, which may home it. Throws SetupError if the answer is no or the tool stands
// outside the limits, DeviceError if the probe was not seen to work, and as Machine does.
void let_move(Machine& machine, const MachineReport& report, const MachineConfig& config, const std::string& what, bool yes,
              Console& console, StopSignals& signals);

}  // namespace palpate
