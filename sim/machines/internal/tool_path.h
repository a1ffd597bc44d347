// The way of a tool, straight or with the kinks that backlash makes, cut where it passes the surface of a solid: which parts are inside,
// and how deep.
#pragma once

#include <vector>

#include "sim/objects/obstacle.h"

namespace palpate {

// In mm from the source. Neighbours differ in `inside`; the first begins at 0.
struct Stretch {
    double from = 0.0;
    double to = 0.0;
    bool inside = false;
};

// A straight part of the way that a tool really goes while its steps are counted from `from` to `to` mm of a straight way.
struct Leg {
    double from = 0.0;
    double to = 0.0;
    Segment way;                     // in the obstacle's coordinates
    Vector rate = Vector::Zero();    // along it, per mm of steps: of length 1 unless an axis takes up its play
    Vector shift = Vector::Zero();   // mm: where it is, less what the steps say (ProbeErrors), at `from`
    Vector change = Vector::Zero();  // of that, per mm of steps

    [[nodiscard]] Point at(double distance) const { return way.source + (distance - from) * rate; }
    [[nodiscard]] Vector shift_at(double distance) const { return shift + (distance - from) * change; }
};

// One at least, in order.
using Legs = std::vector<Leg>;
[[nodiscard]] const Leg& leg_at(const Legs& legs, double distance);

// At least one stretch, however short the way is. `way` is in the obstacle's own coordinates.
[[nodiscard]] std::vector<Stretch> stretches_of(const Obstacle& obstacle, const Segment& way);

// The same, in mm of steps.
[[nodiscard]] std::vector<Stretch> stretches_of(const Obstacle& obstacle, const Legs& legs);

// What a probe shows of the first stretch inside: it closes `late` mm behind its beginning (before, if negative) and opens `early` mm
// before its end; if that is the way's, too, where `early` is not 0. Outside as a whole where it would open first.
[[nodiscard]] std::vector<Stretch> felt_of(std::vector<Stretch> stretches, double late, double early);

// The most depth from `from` to `to` mm along the way, by sampling at both ends and every `step` mm between (wider if that were too
// many samples). Depth changes no faster than place, so it is at most half a step too small.
[[nodiscard]] double deepest_between(const Obstacle& obstacle, const Segment& way, double from, double to, double step);

// The same, in mm of steps.
[[nodiscard]] double deepest_between(const Obstacle& obstacle, const Legs& legs, double from, double to, double step);

}  // namespace palpate
