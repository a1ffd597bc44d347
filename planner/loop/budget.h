// Has a run used up what it may cost?
#pragma once

#include <string>

#include "planner/cost.h"
#include "planner/machine_time.h"
#include "planner/options.h"

namespace palpate {

// The budget that is used up, as the certificate names it ("300 probes"); empty if none is. `rates` reckon machine time.
[[nodiscard]] std::string used_up(const Budget& budget, const Cost& cost, const MachineRates& rates);

}  // namespace palpate
