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

// visit(value) for all in the cell and those around it, always in the same order. `cells`: a map from cells to sequences of values.
template <typename Cells, typename Visit>
void visit_near(const Cells& cells, const GridCell& at, const Visit& visit) {
    for (std::int64_t x = at[0] - 1; x <= at[0] + 1; ++x) {
        for (std::int64_t y = at[1] - 1; y <= at[1] + 1; ++y) {
            for (std::int64_t z = at[2] - 1; z <= at[2] + 1; ++z) {
                const auto found = cells.find({x, y, z});
                if (found == cells.end()) continue;
                for (const auto& value : found->second) visit(value);
            }
        }
    }
}

}  // namespace palpate
