// Nothing moves, and nothing of the user's changes, before the operator has agreed (devices/FACTS.md, "Safety floor").
#pragma once

#include <string>

#include "tools/terminal/console.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {

// Shows what is about to happen, and asks for "yes" on the operator's own terminal, wherever standard input, output and error lead; what
// was typed before the question is no answer. `given` (--yes) is that answer. Throws SetupError if the answer is another one or there is
// no terminal, Stopped if a stop is requested meanwhile. `has_moved`: it has, after an earlier question.
void ask_consent(const std::string& what_will_move, bool given, Console& console, StopSignals& signals, bool has_moved = false);

// The same before a file that the user wrote is changed, with everything at rest.
void ask_to_change(const std::string& what_will_change, bool given, Console& console, StopSignals& signals);

}  // namespace palpate
