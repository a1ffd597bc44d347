// Do a caller's options make sense, every one of them, for that oracle and ω?
#pragma once

#include "planner/options.h"
#include "planner/surface_oracle.h"
#include "planner/surroundings.h"

namespace palpate {

// Throws std::invalid_argument, which names what to change, on options and traits that make no sense, and where double coordinates could
// not tell points apart that the run must tell apart.
void check_options(const Surroundings& surroundings, const Options& options, const OracleTraits& traits = {});

}  // namespace palpate
