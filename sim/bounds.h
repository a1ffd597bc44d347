// Axis-parallel bounding box.
#pragma once

#include "planner/geometry.h"

namespace palpate {

struct Bounds {
    Point min = Point::Zero();  // mm
    Point max = Point::Zero();  // mm

    [[nodiscard]] Point center() const { return 0.5 * (min + max); }
    [[nodiscard]] double diagonal() const { return (max - min).norm(); }
};

}  // namespace palpate
