// What stands around the part and is known beforehand: a table, clamps.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// All that lies below that height.
struct Table {
    double z = 0.0;  // mm
};

struct HalfSpace {
    Point point = Point::Zero();      // on its boundary
    Vector normal = Vector::UnitZ();  // unit, out of it
};

using Fixture = std::variant<Table, HalfSpace, Box>;

struct Fixtures {
    std::vector<Fixture> solids;
    // mm: the tool keeps so far off them, > 0; none: twice the touch error.
    std::optional<double> clearance;
    // Nothing but the part stands on them: what is far from the part is not looked at.
    bool assume_clear = true;
};

}  // namespace palpate
