#include "tools/attended_machine.h"

#include "devices/errors.h"
#include "tools/machine.h"
#include "tools/terminal/consent.h"
#include "tools/terminal/probe_proof.h"

namespace palpate {

void let_move(Machine& machine, const MachineReport& report, const MachineConfig& config, const std::string& what, bool yes,
              Console& console, StopSignals& signals) {
    ask_consent(describe_plan(report, config, what), yes, console, signals);
    if (is_proven_by_hand(config.probe_proof, !yes) && !see_probe_pressed(machine, "stop", console, signals)) {
        throw DeviceError("the probe was not seen to close and to open; nothing has moved. Look at its lead, plug and battery");
    }
    machine.make_ready();
}

}  // namespace palpate
