// The cells of a grid that a triangle covers, and where they are on the triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planner/geometry.h"
#include "tools/view/internal/screen.h"

namespace palpate {

// Twice the signed area on the screen.
[[nodiscard]] inline double doubled_area(const Screen& a, const Screen& b, const Screen& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Barycentric coordinates of a place on the screen; the triangle has an area.
[[nodiscard]] Vector barycentric(const std::array<Screen, 3>& t, double x, double y);

// Some rows of a grid.
struct Strip {
    int columns = 0;
    int first_row = 0;
    int end_row = 0;
};

// Its corners from top to bottom.
[[nodiscard]] inline std::array<Screen, 3> downwards(std::array<Screen, 3> t) {
    const auto order = [](Screen& a, Screen& b) {
        if (b.y < a.y) std::swap(a, b);
    };
    order(t[0], t[1]);
    order(t[1], t[2]);
    order(t[0], t[1]);
    return t;
}

// How far an edge goes to the right per row.
[[nodiscard]] inline double slope(const Screen& from, const Screen& to) { return to.y > from.y ? (to.x - from.x) / (to.y - from.y) : 0.0; }

// The first of the cells [0, end) whose centre is at least `from`, and one past the last whose centre is at most `to`.
// Casts, because std::ceil and std::floor are calls where the processor's oldest instructions have to do.
[[nodiscard]] inline int first_centre(double from, int end) {
    const double place = std::clamp(from - 0.5, 0.0, static_cast<double>(end));
    const int cell = static_cast<int>(place);
    return cell < place ? cell + 1 : cell;
}
[[nodiscard]] inline int end_of_centres(double to, int end) {
    return static_cast<int>(std::clamp(to + 0.5, 0.0, static_cast<double>(end)));
}

// Calls visit(y, first, end, nearness, step) for each row of the strip in which the triangle covers the centres of the cells [first, end):
// its nearness at the first, and how much more it is at each next one. Centres on an edge belong to the triangles on both sides.
template <class Visit>
void rasterize(const std::array<Screen, 3>& t, const Strip& strip, const Visit& visit) {
    constexpr double kLeastArea = 1e-6;  // of fewer cells, rounding would decide how near they are
    const auto [top, middle, bottom] = downwards(t);
    const int first_row = std::max(strip.first_row, first_centre(top.y, strip.end_row));
    const int end_row = end_of_centres(bottom.y, strip.end_row);
    const double area = doubled_area(top, middle, bottom);
    if (first_row >= end_row || std::abs(area) < kLeastArea) {
        return;
    }
    const double upper = slope(top, middle);
    const double lower = slope(middle, bottom);
    const double whole = slope(top, bottom);
    const double nearer_middle = middle.nearness - top.nearness;
    const double nearer_bottom = bottom.nearness - top.nearness;
    const double across = (nearer_middle * (bottom.y - top.y) - nearer_bottom * (middle.y - top.y)) / area;
    const double down = (nearer_bottom * (middle.x - top.x) - nearer_middle * (bottom.x - top.x)) / area;
    for (int row = first_row; row < end_row; ++row) {
        const double y = row + 0.5;
        const double on_whole = top.x + (y - top.y) * whole;
        const double on_other = y < middle.y ? top.x + (y - top.y) * upper : middle.x + (y - middle.y) * lower;
        const int first = first_centre(std::min(on_whole, on_other), strip.columns);
        const int end = end_of_centres(std::max(on_whole, on_other), strip.columns);
        visit(row, first, end, top.nearness + down * (y - top.y) + across * (first + 0.5 - top.x), across);
    }
}

}  // namespace palpate
