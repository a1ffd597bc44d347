#include "tools/internal/item_buffer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tools/internal/rasterizer.h"

namespace palpate {

ItemBuffer::ItemBuffer(int columns, int rows)
    : columns_(columns), rows_(rows), nearest_(std::size_t(columns) * std::size_t(rows), kNowhere), items_(nearest_.size(), kBackground) {}

void ItemBuffer::draw_triangle(const std::array<Screen, 3>& corners, std::int32_t item) {
    rasterize(corners, columns_, rows_, [&](int x, int y, double nearness) { put(x, y, nearness, item); });
}

void ItemBuffer::draw_ball(const Camera& camera, const Point& point, double radius, std::int32_t item) {
    const Screen c = camera.project(point);
    const double r = radius * camera.magnification(c.nearness);
    const double depth = camera.depth_at(c.nearness);
    for (int y = std::max(0, static_cast<int>(c.y - r)); y <= std::min(rows_ - 1, static_cast<int>(c.y + r)); ++y) {
        for (int x = std::max(0, static_cast<int>(c.x - r)); x <= std::min(columns_ - 1, static_cast<int>(c.x + r)); ++x) {
            const double dx = (x + 0.5 - c.x) / r;
            const double dy = (y + 0.5 - c.y) / r;
            const double square = dx * dx + dy * dy;
            if (square < 1.0) {
                put(x, y, camera.nearness_at(depth - radius * (std::sqrt(1.0 - square) + 0.35)), item);
            }
        }
    }
}

void ItemBuffer::put(int x, int y, double nearness, std::int32_t item) {
    const std::size_t i = place_in_grid(x, y, columns_);
    if (static_cast<float>(nearness) > nearest_[i]) {
        nearest_[i] = static_cast<float>(nearness);
        items_[i] = item;
    }
}

}  // namespace palpate
