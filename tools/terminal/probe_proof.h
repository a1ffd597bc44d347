// The probe is shown to work before anything relies on it: pressed by hand, seen to close and to open (devices/FACTS.md, "Safety floor").
#pragma once

#include "devices/machine.h"
#include "devices/session/machine_settings.h"
#include "tools/terminal/console.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {

// Whether it is to be pressed by hand; `asks`: somebody is at a terminal and is asked whether the machine may move.
[[nodiscard]] bool is_proven_by_hand(ProbeProof proof, bool asks);

// Asks for that on the operator's terminal, or on the console if there is none, and looks until it was seen, a minute has passed, a stop is
// requested, or a line is entered on the terminal, which means `enter`. What was entered before is dropped. True if it was seen. Throws as
// Machine does, and Stopped.
[[nodiscard]] bool see_probe_pressed(Machine& machine, const char* enter, Console& console, StopSignals& signals);

}  // namespace palpate
