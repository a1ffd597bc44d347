// What `palpate check` tells of a machine: who it is, and every setting that matters for probing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planner/region.h"

namespace palpate {

struct MachineSetting {
    std::string name;     // "$121 acceleration y"
    std::string value;    // "200 mm/s²"
    std::string problem;  // what is wrong and what to do; empty: nothing
};

struct MachineReport {
    std::string identity;            // "Grbl 1.1h (1.1h.20190825:) on /dev/ttyUSB0"
    std::string state;               // "idle", "locked: home it first"
    bool needs_homing = false;       // it is locked, or says that it is not homed
    Point position = Point::Zero();  // mm, Palpate's coordinates
    std::optional<Box> reach;        // mm, Palpate's coordinates: where the machine itself can go, if it says so
    std::vector<MachineSetting> settings;

    [[nodiscard]] bool has_problems() const {
        for (const MachineSetting& s : settings) {
            if (!s.problem.empty()) return true;
        }
        return false;
    }
};

}  // namespace palpate
