// Seeded random numbers that are the same everywhere; a test that uses them prints its seed.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "planner/geometry.h"
#include "planner/region.h"

namespace palpate {

class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}

    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53; }
    std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
    bool chance(double probability) { return uniform(0, 1) < probability; }
    Point in_box(const Point& low, const Point& high) {
        return {uniform(low.x(), high.x()), uniform(low.y(), high.y()), uniform(low.z(), high.z())};
    }
    Vector direction() {
        while (true) {
            const Vector v = in_box(Point::Constant(-1), Point::Constant(1));
            if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
        }
    }
    Point on_boundary(const Region& workspace) {
        if (const auto* ball = std::get_if<Ball>(&workspace.shape())) return ball->center + ball->radius * direction();
        const auto& box = std::get<Box>(workspace.shape());
        Point p = in_box(box.min, box.max);
        const auto axis = static_cast<int>(below(3));
        p[axis] = chance(0.5) ? box.min[axis] : box.max[axis];
        return p;
    }
    // In the box, grown by `share` of its diagonal on every side.
    template <typename Bounds>
    Point around(const Bounds& box, double share) {
        const Vector margin = Vector::Constant(share * (box.max - box.min).norm());
        return in_box(box.min - margin, box.max + margin);
    }
    template <typename T>
    const T& one_of(const std::vector<T>& values) {
        return values[below(values.size())];
    }

private:
    std::mt19937_64 engine_;
};

inline std::string seed_text(std::uint64_t seed) { return "seed " + std::to_string(seed); }

}  // namespace palpate
