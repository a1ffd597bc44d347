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
        palpate::visit_near(cells_, grid_cell(p, range_), visit);
    }

private:
    const double range_;
    std::unordered_map<GridCell, std::vector<std::uint32_t>, GridCellHash> cells_;
};

}  // namespace palpate
