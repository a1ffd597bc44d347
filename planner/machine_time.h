// How long a machine would take, from what a run did.
#pragma once

#include <chrono>

#include "planner/cost.h"

namespace palpate {

using Seconds = std::chrono::duration<double>;

// A small CNC with a touch probe; what users' logs show (a touch costs 0.5 to 8 s).
struct MachineRates {
    double travel_feed_mm_per_s = 40.0;
    double probe_feed_mm_per_s = 5.0;
    Seconds touch{1.5};  // stop, retract, latch, and the answer, per contact
};

// Constant feeds; accelerations are not counted.
[[nodiscard]] inline Seconds estimate_machine_time(const Cost& cost, const MachineRates& rates) {
    const Seconds moving{cost.travel / rates.travel_feed_mm_per_s + cost.probing / rates.probe_feed_mm_per_s};
    return moving + static_cast<double>(cost.contact) * rates.touch;
}

}  // namespace palpate
