#include "planner/inference/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {

bool Lens::contains(const Point& x) const {
    const Vector v = x - apex;
    const double height = v.squaredNorm() / (2 * reach) + margin;
    const auto sign = static_cast<double>(side);
    return std::all_of(normals.begin(), normals.end(), [&](const Vector& n) { return sign * v.dot(n) > height; });
}

std::optional<Interval> Lens::clip(const Point& origin, const Vector& direction) const {
    const Vector v = origin - apex;
    const auto sign = static_cast<double>(side);
    Interval inside{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    const double v_along = v.dot(direction);
    const double v_squared = v.squaredNorm() + 2 * reach * margin;
    for (const Vector& n : normals) {
        // t² + 2 half_b t + c < 0
        const double half_b = v_along - sign * reach * direction.dot(n);
        const double c = v_squared - sign * 2 * reach * v.dot(n);
        const double discriminant = half_b * half_b - c;
        if (!(discriminant > 0)) return std::nullopt;
        // The root of the larger magnitude first: no cancellation.
        const double q = half_b > 0 ? -half_b - std::sqrt(discriminant) : -half_b + std::sqrt(discriminant);
        const double other = c / q;
        inside.low = std::max(inside.low, std::min(q, other));
        inside.high = std::min(inside.high, std::max(q, other));
        if (!(inside.low < inside.high)) return std::nullopt;
    }
    return inside;
}

}  // namespace palpate
