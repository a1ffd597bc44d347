#include "planner/loop/budget.h"

#include <sstream>

namespace palpate {

std::string used_up(const Budget& budget, const Cost& cost, const MachineRates& rates) {
    // Asked before every action: nothing is built until it is used up.
    const auto name = [](const auto& amount, const char* of_what) {
        std::ostringstream text;
        text << amount << of_what;
        return text.str();
    };
    if (budget.probes && cost.probes() >= *budget.probes) return name(*budget.probes, " probes");
    if (budget.displacement && cost.displacement() >= *budget.displacement) return name(*budget.displacement, " mm of displacement");
    if (budget.machine_time && estimate_machine_time(cost, rates).count() >= *budget.machine_time) {
        return name(*budget.machine_time, " s of machine time");
    }
    return {};
}

}  // namespace palpate
