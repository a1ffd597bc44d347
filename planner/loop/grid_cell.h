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

struct GridCellHash {
    std::size_t operator()(const GridCell& c) const {
        std::uint64_t h = 0;
        for (const std::int64_t x : c) h = (h ^ static_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15U;
        return static_cast<std::size_t>(h ^ (h >> 32U));
    }
};

}  // namespace palpate
