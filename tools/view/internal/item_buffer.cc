#include "tools/view/internal/item_buffer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tools/view/internal/rasterizer.h"

namespace palpate {

void ItemBuffer::clear(const Strip& strip) {
    strip_ = strip;
    nearest_.assign(place_in_grid(0, strip.end_row - strip.first_row, strip.columns), kNowhere);
    items_.assign(nearest_.size(), kBackground);
}

void ItemBuffer::draw_triangle(const std::array<Screen, 3>& corners, std::int32_t item) {
    rasterize(corners, strip_, [&](int y, int first, int end, double nearness, double step) {
        const std::size_t row = place(0, y);
        for (int x = first; x < end; ++x, nearness += step) put(row + static_cast<std::size_t>(x), nearness, item);
    });
}

void ItemBuffer::draw_ball(const Camera& camera, const Point& point, double radius, std::int32_t item) {
    const Screen c = camera.project(point);
    const double r = radius * camera.magnification(c.nearness);
    const double depth = camera.depth_at(c.nearness);
    for (int y = std::max(strip_.first_row, static_cast<int>(c.y - r)); y <= std::min(strip_.end_row - 1, static_cast<int>(c.y + r)); ++y) {
        for (int x = std::max(0, static_cast<int>(c.x - r)); x <= std::min(strip_.columns - 1, static_cast<int>(c.x + r)); ++x) {
            const double dx = (x + 0.5 - c.x) / r;
            const double dy = (y + 0.5 - c.y) / r;
            const double square = dx * dx + dy * dy;
            if (square < 1.0) {
                put(place(x, y), camera.nearness_at(depth - radius * (std::sqrt(1.0 - square) + 0.35)), item);
            }
        }
    }
}

void ItemBuffer::put(std::size_t i, double nearness, std::int32_t item) {
    if (static_cast<float>(nearness) > nearest_[i]) {
        nearest_[i] = static_cast<float>(nearness);
        items_[i] = item;
    }
}

}  // namespace palpate
