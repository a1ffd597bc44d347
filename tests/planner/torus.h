// A torus around the z axis in closed form: the reach of a solid with both kinds of curvature is its minor radius.
#pragma once

#include <cmath>
#include <numbers>

#include "tests/random.h"

namespace palpate {

struct Torus {
    double major = 1.0;
    double minor = 0.4;

    struct Place {
        Point point;
        Vector normal;  // unit, outwards
    };
    [[nodiscard]] Place at(double around, double across) const {
        const Vector radial(std::cos(around), std::sin(around), 0);
        const Vector normal = std::cos(across) * radial + std::sin(across) * Vector::UnitZ();
        return {major * radial + minor * normal, normal};
    }
    [[nodiscard]] Place random_place(Random& random) const {
        return at(random.uniform(0, 2 * std::numbers::pi), random.uniform(0, 2 * std::numbers::pi));
    }
    // mm; negative inside.
    [[nodiscard]] double distance(const Point& p) const { return std::hypot(std::hypot(p.x(), p.y()) - major, p.z()) - minor; }
    // The point of the surface below or above p.
    [[nodiscard]] Place nearest(const Point& p) const {
        return at(std::atan2(p.y(), p.x()), std::atan2(p.z(), std::hypot(p.x(), p.y()) - major));
    }
};

}  // namespace palpate
