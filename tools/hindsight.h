// What a simulation knows that no machine does, and tells: whether what the user vouches for is so, and whether the result is right.
#pragma once

#include <string>

#include "tools/simulation.h"
#include "tools/terminal/output.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {

// What was mended of the object's file.
void print_warnings(const HiddenObject& object);
// A simulation knows better than the user; a certificate that rests on a false premise should not go unnoticed.
void warn_of_false_reach(const SessionConfig& config, const HiddenObject& object);
void warn_of_other_truth(const Simulation& run);
// The truth in a line.
[[nodiscard]] std::string describe_truth(const Simulation& run);

// Throws Stopped if a stop is requested meanwhile.
[[nodiscard]] Simulation simulate_with_progress(const SessionConfig& config, const Scene& scene, Output& output, StopSignals& signals);

}  // namespace palpate
