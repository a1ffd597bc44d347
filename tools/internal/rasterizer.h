// The cells of a grid that a triangle covers, and where they are on the triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/geometry.h"
#include "tools/internal/screen.h"

namespace palpate {

// Twice the signed area on the screen.
[[nodiscard]] inline double doubled_area(const Screen& a, const Screen& b, const Screen& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Barycentric coordinates of a place on the screen; the triangle has an area.
[[nodiscard]] Vector barycentric(const std::array<Screen, 3>& t, double x, double y);

// Calls visit(x, y, nearness) for each cell of a width × height grid whose centre the triangle covers.
template <class Visit>
void rasterize(const std::array<Screen, 3>& t, int width, int height, const Visit& visit) {
    if (std::abs(doubled_area(t[0], t[1], t[2])) < 1e-12) {
        return;
    }
    const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
    const int last_x = static_cast<int>(std::min(width - 1.0, std::ceil(x1)));
    const int last_y = static_cast<int>(std::min(height - 1.0, std::ceil(y1)));
    const Vector nearness(t[0].nearness, t[1].nearness, t[2].nearness);
    for (int y = static_cast<int>(std::max(0.0, std::floor(y0))); y <= last_y; ++y) {
        const int first_x = static_cast<int>(std::max(0.0, std::floor(x0)));
        Vector b = barycentric(t, first_x + 0.5, y + 0.5);
        const Vector step = barycentric(t, first_x + 1.5, y + 0.5) - b;
        for (int x = first_x; x <= last_x; ++x, b += step) {
            if (b.minCoeff() >= -1e-9) {
                visit(x, y, b.dot(nearness));
            }
        }
    }
}

}  // namespace palpate
