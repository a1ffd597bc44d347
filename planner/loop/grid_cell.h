// The cell of a grid of cubes that a place lies in.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "planner/geometry.h"

namespace palpate {

using GridCell = std::array<std::int64_t, 3>;

// `size` (mm): a cell's side.
[[nodiscard]] inline GridCell grid_cell(const Point& p, double size) {
    const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor(x / size)); };
    return {index(p.x()), index(p.y()), index(p.z())};
}

}  // namespace palpate
