// A datum that a session touches again now and then, to see how part and machine drift against each other (devices/README.md, "Drift").
#pragma once

#include <cstdint>
#include <vector>

#include "planner/geometry.h"
#include "planner/surroundings.h"

namespace palpate {

struct MachineSettings;

struct DatumTouch {
    Point from = Point::Zero();  // mm
    Point to = Point::Zero();    // mm: touched before that, square to the face

    [[nodiscard]] Vector inwards() const { return (to - from).normalized(); }
};

struct DriftDatum {
    std::uint64_t every = 100;  // touches of the part from one visit to the next, > 0
    std::vector<DatumTouch> touches;
    double limit_mm = 0.1;  // > 0: what changes more from one visit to the next is no drift
};

// Throws SetupError if a touch of settings.datum cannot be made: where, and why.
void check_datum(const MachineSettings& settings, const Surroundings& surroundings);

// From one place outside ω to another, around it: the points to pass after `from`, up to and with `to`. The first and the last leg lead
// straight to ω's boundary and from it. Throws std::invalid_argument as Surroundings::nearest_entry does.
[[nodiscard]] std::vector<Point> way_around(const Surroundings& surroundings, const Point& from, const Point& to);

}  // namespace palpate
