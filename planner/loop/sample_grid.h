// Samples by place: those around any place, at a cost that does not grow with the run.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "planner/loop/grid_cell.h"

namespace palpate {

class SampleGrid {
public:
    // `range` (mm): how far around a place samples are asked for.
    explicit SampleGrid(double range) : range_(range) {}

    void add(std::uint32_t sample, const Point& at) { cells_[grid_cell(at, range_)].push_back(sample); }
    // Those within the range of p, and some beyond; always in the same order.
    template <typename Visit>
    void visit_near(const Point& p, const Visit& visit) const {
        const GridCell centre = grid_cell(p, range_);
        for (std::int64_t x = -1; x <= 1; ++x) {
            for (std::int64_t y = -1; y <= 1; ++y) {
                for (std::int64_t z = -1; z <= 1; ++z) {
                    const auto cell = cells_.find({centre[0] + x, centre[1] + y, centre[2] + z});
                    if (cell == cells_.end()) continue;
                    for (const std::uint32_t sample : cell->second) visit(sample);
                }
            }
        }
    }

private:
    const double range_;
    std::unordered_map<GridCell, std::vector<std::uint32_t>, GridCellHash> cells_;
};

}  // namespace palpate
