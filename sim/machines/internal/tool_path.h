// A straight way cut where it passes the surface of a solid: which parts are inside, and how deep.
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

// At least one stretch, however short the way is. `way` is in the obstacle's own coordinates.
[[nodiscard]] std::vector<Stretch> stretches_of(const Obstacle& obstacle, const Segment& way);

// The most depth from `from` to `to` mm along the way, by sampling at both ends and every `step` mm between (wider if that were too
// many samples). Depth changes no faster than place, so it is at most half a step too small.
[[nodiscard]] double deepest_between(const Obstacle& obstacle, const Segment& way, double from, double to, double step);

}  // namespace palpate
