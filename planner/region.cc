#include "planner/region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace palpate {
namespace {

bool finite_and_positive(double x) { return std::isfinite(x) && x > 0; }

}  // namespace

Region::Region(const Ball& ball) : shape_(ball) {
    if (!finite_and_positive(ball.radius) || !ball.center.allFinite()) {
        throw std::invalid_argument("workspace ball: the radius must be positive and finite");
    }
}

Region::Region(const Box& box) : shape_(box) {
    const Vector size = box.max - box.min;
    for (int axis = 0; axis < 3; ++axis) {
        if (!finite_and_positive(size[axis])) throw std::invalid_argument("workspace box: every max must be greater than its min");
    }
}

Point Region::center() const {
    if (const auto* ball = std::get_if<Ball>(&shape_)) return ball->center;
    const auto& box = std::get<Box>(shape_);
    return (box.min + box.max) / 2;
}

double Region::radius() const {
    if (const auto* ball = std::get_if<Ball>(&shape_)) return ball->radius;
    const auto& box = std::get<Box>(shape_);
    return (box.max - box.min).norm() / 2;
}

double Region::volume() const {
    if (const auto* ball = std::get_if<Ball>(&shape_)) return 4.0 / 3.0 * std::numbers::pi * std::pow(ball->radius, 3);
    const auto& box = std::get<Box>(shape_);
    return (box.max - box.min).prod();
}

bool Region::contains(const Point& p) const {
    if (const auto* ball = std::get_if<Ball>(&shape_)) return (p - ball->center).squaredNorm() <= ball->radius * ball->radius;
    return std::get<Box>(shape_).contains(p);
}

std::optional<Interval> Region::clip(const Point& origin, const Vector& direction) const {
    if (const auto* ball = std::get_if<Ball>(&shape_)) {
        const Vector to_center = ball->center - origin;
        const double nearest = to_center.dot(direction);
        // The distance of the line from the centre, from the orthogonal part: the difference of squares would cancel.
        const double squared = ball->radius * ball->radius - (to_center - nearest * direction).squaredNorm();
        if (!(squared > 0)) return std::nullopt;
        const double half = std::sqrt(squared);
        return Interval{nearest - half, nearest + half};
    }
    const auto& box = std::get<Box>(shape_);
    Interval inside{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) {
            if (!(origin[axis] > box.min[axis] && origin[axis] < box.max[axis])) return std::nullopt;
            continue;
        }
        const double a = (box.min[axis] - origin[axis]) / direction[axis];
        const double b = (box.max[axis] - origin[axis]) / direction[axis];
        inside.low = std::max(inside.low, std::min(a, b));
        inside.high = std::min(inside.high, std::max(a, b));
    }
    if (!(inside.low < inside.high)) return std::nullopt;
    return inside;
}

Point Region::nearest_boundary(const Point& p) const {
    if (const auto* ball = std::get_if<Ball>(&shape_)) {
        const Vector outwards = p - ball->center;
        return ball->center + ball->radius * (outwards.norm() > 0 ? Vector(outwards.normalized()) : Vector(Vector::UnitZ()));
    }
    const auto& box = std::get<Box>(shape_);
    if (!contains(p)) return p.cwiseMax(box.min).cwiseMin(box.max);
    int low_axis = 0;
    int high_axis = 0;
    const double to_low = (p - box.min).minCoeff(&low_axis);
    const double to_high = (box.max - p).minCoeff(&high_axis);
    Point nearest = p;
    if (to_low < to_high) {
        nearest[low_axis] = box.min[low_axis];
    } else {
        nearest[high_axis] = box.max[high_axis];
    }
    return nearest;
}

}  // namespace palpate
