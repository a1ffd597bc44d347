#include "planner/loop/budget.h"

#include <fmt/format.h>

namespace palpate {

std::string used_up(const Budget& budget, const Cost& cost, const MachineRates& rates) {
    // Asked before every action: nothing is built until it is used up.
    if (budget.probes && cost.probes() >= *budget.probes) return fmt::format("{} probes", *budget.probes);
    if (budget.displacement && cost.displacement() >= *budget.displacement) {
        return fmt::format("{:.6g} mm of displacement", *budget.displacement);
    }
    if (budget.machine_time && estimate_machine_time(cost, rates).count() >= *budget.machine_time) {
        return fmt::format("{:.6g} s of machine time", *budget.machine_time);
    }
    return {};
}

}  // namespace palpate
