#include "planner/loop/task_grid.h"

#include <gtest/gtest.h>

#include "tests/random.h"

namespace palpate::task_grid_test {
namespace {

TEST(TaskGrid, TakesTheNearestAsBruteForceDoes) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        const double cell = random.uniform(0.05, 3);
        TaskGrid grid(cell);
        std::vector<Task> all;
        for (std::uint32_t k = 0; k < 300; ++k) {
            Task task{{k, k + 1, Task::kNoSample}, 0, random.in_box(Point::Constant(-3), Point::Constant(3)), {}};
            if (random.chance(0.5)) task.handicap = random.uniform(0, 4);
            grid.add(task);
            grid.add(task);  // once is enough
            all.push_back(task);
        }
        Point head = random.in_box(Point::Constant(-9), Point::Constant(9));
        while (!all.empty()) {
            ASSERT_EQ(grid.size(), all.size());
            const auto taken = grid.take_nearest(head);
            const auto nearest = std::min_element(all.begin(), all.end(), [&](const Task& x, const Task& y) {
                return (x.at - head).norm() + x.handicap < (y.at - head).norm() + y.handicap;
            });
            ASSERT_TRUE(taken);
            ASSERT_EQ(taken->samples, nearest->samples) << seed_text(seed);
            all.erase(nearest);
            if (random.chance(0.5)) head = taken->at;
            if (random.chance(0.05)) head = random.in_box(Point::Constant(-30), Point::Constant(30));
        }
        EXPECT_FALSE(grid.take_nearest(head));
    }
}

TEST(TaskGrid, RemovesWhatItHas) {
    TaskGrid grid(1);
    for (std::uint32_t k = 0; k < 100; ++k) grid.add({{k, k, k}, 0, Point(100 + k, 0, 0), {}});
    for (std::uint32_t k = 0; k < 40; ++k) grid.remove({{k, k, k}, 7, Point(100 + k, 0, 0), {}});
    grid.remove({{50, 50, 51}, 0, Point(150, 0, 0), {}});
    grid.remove({{500, 500, 500}, 0, Point(500, 0, 0), {}});
    EXPECT_EQ(grid.size(), 60U);
    EXPECT_EQ(grid.take_nearest(Point::Zero())->samples[0], 40U);
}

}  // namespace
}  // namespace palpate::task_grid_test
