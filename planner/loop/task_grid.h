// Places that wait for the tool, and which of them is nearest to it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "planner/delaunay/maintained_delaunay.h"
#include "planner/geometry.h"
#include "planner/loop/grid_cell.h"

namespace palpate {

// What to look at: a Delaunay edge (the third sample is kNoSample) or a facet.
struct Task {
    static constexpr std::uint32_t kNoSample = ~std::uint32_t{0};
    std::array<std::uint32_t, 3> samples{kNoSample, kNoSample, kNoSample};
    std::uint32_t attempts = 0;
    Point at = Point::Zero();
    EdgeTicket hint;        // of a facet at the edge, when the task was noted
    double handicap = 0.0;  // mm: it is taken to be so much farther away
};

// A hash grid: adding and removing are constant time, and so is taking the nearest where tasks lie as densely as the cells. Where
// the nearest is many cells away, all tasks are looked through. Same calls, same answers: the order within the hash map never matters.
class TaskGrid {
public:
    // `cell_size` (mm): about the distance between tasks.
    explicit TaskGrid(double cell_size) : cell_size_(cell_size) {}

    // Does nothing if a task with the same samples, in the same order, waits at the same place.
    void add(const Task& task);
    // The task with those samples that waits at that place, if there is one.
    void remove(const Task& task);
    // Removes and returns the task nearest to p; among equals the one with the smaller samples.
    std::optional<Task> take_nearest(const Point& p);
    [[nodiscard]] std::size_t size() const { return size_; }

private:
    [[nodiscard]] GridCell cell_of(const Point& p) const { return grid_cell(p, cell_size_); }

    const double cell_size_;
    std::unordered_map<GridCell, std::vector<Task>, GridCellHash> cells_;
    std::size_t size_ = 0;
};

}  // namespace palpate
