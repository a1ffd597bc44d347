// A torus around the z axis in closed form: the reach of a solid with both kinds of curvature is its minor radius, unless its hole is
// smaller. With a major radius of 0 it is a sphere.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/random.h"

namespace palpate {

struct Torus {
    double major = 1.0;
    double minor = 0.4;

    [[nodiscard]] static Torus sphere(double radius) { return {0, radius}; }
    [[nodiscard]] bool is_sphere() const { return major == 0; }

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

    [[nodiscard]] double reach() const { return is_sphere() ? minor : std::min(minor, major - minor); }  // mm
    [[nodiscard]] double area() const {                                                                  // mm²
        return 4 * std::numbers::pi * minor * (is_sphere() ? minor : std::numbers::pi * major);
    }
    [[nodiscard]] int euler_characteristic() const { return is_sphere() ? 2 : 0; }

    // How far from its start (mm) the segment passes the surface, in order. Distances are 1-Lipschitz, which tells where it does not.
    [[nodiscard]] std::vector<double> crossings(const Point& from, const Point& to) const {
        std::vector<double> found;
        const double length = (to - from).norm();
        if (length > 0) add_crossings(from, (to - from) / length, 0, length, found);
        return found;
    }
    // The first point of the solid on the segment.
    [[nodiscard]] std::optional<Point> first_hit(const Point& from, const Point& to) const {
        const std::vector<double> found = crossings(from, to);
        const std::size_t into = distance(from) > 0 ? 0 : 1;
        if (found.size() <= into) return std::nullopt;
        return from + found[into] * (to - from).normalized();
    }
    // mm: how near the segment comes to the surface, negative inside; to `precision`.
    [[nodiscard]] double least_distance(const Point& from, const Point& to, double precision) const {
        double least = std::min(distance(from), distance(to));
        lower_distance(from, to, precision, least);
        return least;
    }

private:
    void add_crossings(const Point& origin, const Vector& direction, double low, double high, std::vector<double>& found) const {
        constexpr double kPrecision = 1e-13;  // mm
        const double middle = (low + high) / 2;
        if (std::abs(distance(origin + middle * direction)) > 0.51 * (high - low)) return;  // rounding aside
        if (high - low > kPrecision) {
            add_crossings(origin, direction, low, middle, found);
            add_crossings(origin, direction, middle, high, found);
        } else if ((distance(origin + low * direction) > 0) != (distance(origin + high * direction) > 0)) {
            found.push_back(middle);
        }
    }
    void lower_distance(const Point& a, const Point& b, double precision, double& least) const {
        const Point middle = (a + b) / 2;
        const double here = distance(middle);
        least = std::min(least, here);
        const double half = (b - a).norm() / 2;
        if (here - half >= least - precision) return;
        lower_distance(a, middle, precision, least);
        lower_distance(middle, b, precision, least);
    }
};

}  // namespace palpate
