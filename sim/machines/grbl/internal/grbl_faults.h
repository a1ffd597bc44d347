// The faults that a virtual GRBL controller still has to suffer.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "sim/machines/grbl/virtual_grbl.h"

namespace palpate {

class GrblFaults {
public:
    explicit GrblFaults(const VirtualGrblOptions& options);

    // Those that are due, in the order of the script; they do not come again. `at` counts lines, probe moves or seconds.
    [[nodiscard]] std::vector<VirtualFault> take(VirtualFault::When when, double at);
    [[nodiscard]] std::optional<Seconds> next_time() const;

    // By chance, for one probe move: after which share of its time it triggers; whether it bounces.
    [[nodiscard]] std::optional<double> draw_spurious();
    [[nodiscard]] bool draw_bounce();

private:
    double draw();

    std::vector<VirtualFault> script_;
    double spurious_rate_;
    double bounce_rate_;
    std::mt19937_64 random_;
};

}  // namespace palpate
