// What is nearest to the viewer at each sample of the screen.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planner/geometry.h"
#include "tools/internal/camera.h"
#include "tools/internal/screen.h"

namespace palpate {

inline constexpr std::int32_t kBackground = -1;

// Items are numbers ≥ 0 that the caller gives. Of equally near ones the first that was drawn stays.
class ItemBuffer {
public:
    ItemBuffer(int columns, int rows);

    void draw_triangle(const std::array<Screen, 3>& corners, std::int32_t item);
    // A ball, a little before its point so that the surface around does not swallow it. `radius` in mm.
    void draw_ball(const Camera& camera, const Point& point, double radius, std::int32_t item);

    // The item at a sample, or kBackground.
    [[nodiscard]] std::int32_t item(int x, int y) const { return items_[place_in_grid(x, y, columns_)]; }
    [[nodiscard]] float nearness(int x, int y) const { return nearest_[place_in_grid(x, y, columns_)]; }

private:
    void put(int x, int y, double nearness, std::int32_t item);

    int columns_, rows_;
    std::vector<float> nearest_;
    std::vector<std::int32_t> items_;
};

}  // namespace palpate
