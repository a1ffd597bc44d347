// The tool of a machine: a ball on a stylus in a holder.
#pragma once

#include <optional>

#include "planner/geometry.h"

namespace palpate {

// The reference point, which positions are those of, is the ball's centre. All parts have their axis on the line from there along `axis`,
// and round ends.
struct ToolShape {
    struct Shaft {
        double diameter = 0.0;  // mm, > 0
        double length = 0.0;    // mm, > 0: from end to end
    };
    double ball_diameter = 0.0;     // mm, > 0, and no less than the stylus'
    std::optional<Shaft> stylus;    // begins at the ball's centre; none: the ball floats
    std::optional<Shaft> holder;    // begins where the stylus ends
    Vector axis = Vector::UnitZ();  // unit: from the ball to the holder
};

}  // namespace palpate
