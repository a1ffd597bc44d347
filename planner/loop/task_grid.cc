#include "planner/loop/task_grid.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace palpate {
namespace {

// Rings of cells around the tool that are looked through before all tasks are.
constexpr std::int64_t kMaxRing = 4;

}  // namespace

void TaskGrid::add(const Task& task) {
    std::vector<Task>& cell = cells_[cell_of(task.at)];
    if (std::any_of(cell.begin(), cell.end(), [&](const Task& t) { return t.samples == task.samples; })) return;
    cell.push_back(task);
    ++size_;
}

void TaskGrid::remove(const Task& task) {
    const auto cell = cells_.find(cell_of(task.at));
    if (cell == cells_.end()) return;
    size_ -= std::erase_if(cell->second, [&](const Task& t) { return t.samples == task.samples; });
    if (cell->second.empty()) cells_.erase(cell);
}

std::optional<Task> TaskGrid::take_nearest(const Point& p) {
    using Rank = std::tuple<double, std::array<std::uint32_t, 3>>;
    std::optional<Rank> best;
    std::unordered_map<GridCell, std::vector<Task>, GridCellHash>::iterator where;
    std::size_t index = 0;
    const auto look = [&](const auto& cell) {
        for (std::size_t k = 0; k < cell->second.size(); ++k) {
            const Task& task = cell->second[k];
            const Rank rank{(task.at - p).norm() + task.handicap, task.samples};
            if (best && *best <= rank) continue;
            best = rank;
            where = cell;
            index = k;
        }
    };
    const GridCell centre = cell_of(p);
    bool found = false;
    for (std::int64_t ring = 0; ring <= kMaxRing && size_ > 0; ++ring) {
        for (std::int64_t x = -ring; x <= ring; ++x) {
            for (std::int64_t y = -ring; y <= ring; ++y) {
                const bool side = std::abs(x) == ring || std::abs(y) == ring;
                for (std::int64_t z = -ring; z <= ring; z += side ? 1 : std::max<std::int64_t>(1, 2 * ring)) {
                    const auto cell = cells_.find({centre[0] + x, centre[1] + y, centre[2] + z});
                    if (cell != cells_.end()) look(cell);
                }
            }
        }
        // Whatever lies beyond this ring is farther away than that.
        found = best && std::get<double>(*best) <= static_cast<double>(ring) * cell_size_;
        if (found) break;
    }
    if (!found) {
        for (auto cell = cells_.begin(); cell != cells_.end(); ++cell) look(cell);
    }
    if (!best) return std::nullopt;
    std::vector<Task>& tasks = where->second;
    const Task task = tasks[index];
    tasks.erase(tasks.begin() + static_cast<std::ptrdiff_t>(index));
    if (tasks.empty()) cells_.erase(where);
    --size_;
    return task;
}

}  // namespace palpate
