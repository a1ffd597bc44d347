// Distances by plain search, to hold closed forms against.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "planner/geometry.h"

namespace palpate {

using Triangle = std::array<Point, 3>;

inline double point_distance(const Point& p, const Triangle& t) {
    const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
    bool is_over = true;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const Point& a = t.at(i);
        const Point& b = t.at((i + 1) % 3);
        is_over = is_over && n.dot((b - a).cross(p - a)) >= 0;
        nearest = std::min(nearest, distance_to({a, b}, p));
    }
    return is_over ? std::min(nearest, std::abs(n.normalized().dot(p - t[0]))) : nearest;
}

// Of a convex function between 0 and 1: in every round a third of what is left can be left out.
template <typename Function>
double least(const Function& f, int rounds) {
    double low = 0;
    double high = 1;
    for (int k = 0; k < rounds; ++k) {
        const double a = low + (high - low) / 3;
        const double b = high - (high - low) / 3;
        (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
    }
    return f((low + high) / 2);
}

}  // namespace palpate
