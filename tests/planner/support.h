// What the tests of planner/ share: workspaces, solids in closed form and an oracle on them.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planner/geometry.h"
#include "planner/region.h"
#include "planner/surface_oracle.h"
#include "tests/random.h"

namespace palpate {

// How deep p lies inside ω, in mm; negative outside.
inline double depth(const Region& workspace, const Point& p) {
    if (const auto* ball = std::get_if<Ball>(&workspace.shape())) return ball->radius - (p - ball->center).norm();
    const auto& box = std::get<Box>(workspace.shape());
    return std::min((p - box.min).minCoeff(), (box.max - p).minCoeff());
}

// A union of balls and boxes: every line meets it in intervals that are known in closed form.
class Solid {
public:
    Solid& add(const Ball& ball) {
        parts_.push_back(Region(ball));
        return *this;
    }
    Solid& add(const Box& box) {
        parts_.push_back(Region(box));
        return *this;
    }

    // Where the line x(t) = origin + t · direction (of unit length) runs inside the solid, in order, disjoint. A negative
    // `offset` (mm) asks for the solid without its outermost layer.
    [[nodiscard]] std::vector<Interval> inside(const Point& origin, const Vector& direction, double offset = 0) const {
        std::vector<Interval> pieces;
        for (const Region& part : parts_) {
            if (const auto piece = grown(part, offset).clip(origin, direction)) pieces.push_back(*piece);
        }
        std::sort(pieces.begin(), pieces.end(), [](const Interval& x, const Interval& y) { return x.low < y.low; });
        std::vector<Interval> merged;
        for (const Interval& piece : pieces) {
            if (!merged.empty() && piece.low <= merged.back().high) {
                merged.back().high = std::max(merged.back().high, piece.high);
            } else {
                merged.push_back(piece);
            }
        }
        return merged;
    }

    // Does the segment come deeper than `tolerance` into the solid?
    [[nodiscard]] bool meets(const Point& a, const Point& b, double tolerance) const {
        if (a == b) return depth_at(a) > tolerance;
        const double length = (b - a).norm();
        for (const Interval& piece : inside(a, (b - a) / length, -tolerance)) {
            if (piece.low < length && piece.high > 0) return true;
        }
        return false;
    }

    // How deep p lies in the part that it lies deepest in, in mm; negative outside.
    [[nodiscard]] double depth_at(const Point& p) const {
        double deepest = -std::numeric_limits<double>::infinity();
        for (const Region& part : parts_) deepest = std::max(deepest, depth(part, p));
        return deepest;
    }

    // The first point of the solid on the segment.
    [[nodiscard]] std::optional<Point> first_hit(const Point& from, const Point& to) const {
        const double length = (to - from).norm();
        if (length == 0) return std::nullopt;
        const Vector direction = (to - from) / length;
        for (const Interval& piece : inside(from, direction)) {
            if (piece.low >= 0 && piece.low <= length) return from + piece.low * direction;
        }
        return std::nullopt;
    }

    [[nodiscard]] Point surface_point(Random& random) const {
        while (true) {
            const Point p = random.on_boundary(random.one_of(parts_));
            if (depth_at(p) < 1e-9) return p;
        }
    }

private:
    static Region grown(const Region& part, double offset) {
        if (const auto* ball = std::get_if<Ball>(&part.shape())) return Region(Ball{ball->center, ball->radius + offset});
        const auto& box = std::get<Box>(part.shape());
        return Region(Box{box.min - Vector::Constant(offset), box.max + Vector::Constant(offset)});
    }

    std::vector<Region> parts_;  // a workspace is the same kind of thing
};

// Answers on a solid, and keeps the account of the tool's motion by itself.
class SolidOracle final : public SurfaceOracle {
public:
    using FirstHit = std::function<std::optional<Point>(const Point& from, const Point& to)>;
    SolidOracle(FirstHit first_hit, const Point& start) : first_hit_(std::move(first_hit)), position_(start) {}
    SolidOracle(const Solid& solid, const Point& start)
        : SolidOracle([solid](const Point& from, const Point& to) { return solid.first_hit(from, to); }, start) {}

    [[nodiscard]] OracleTraits traits() const override { return {}; }
    [[nodiscard]] Point position() const override { return position_; }
    void travel(std::span<const Point> path, Ground /*ground*/) override {
        for (const Point& p : path) {
            travels.push_back({position_, p});
            travel_length += (p - position_).norm();
            position_ = p;
        }
    }
    [[nodiscard]] ProbeAnswer probe(const Point& target) override {
        const std::optional<Point> hit = first_hit_(position_, target);
        const Point stop = hit.value_or(target);
        probes.push_back({position_, stop});
        probing_length += (stop - position_).norm();
        contacts += hit ? 1 : 0;
        position_ = stop;
        return {hit ? ProbeAnswer::Outcome::contact : ProbeAnswer::Outcome::clear, stop};
    }

    std::vector<Segment> travels;
    std::vector<Segment> probes;
    double travel_length = 0;
    double probing_length = 0;
    std::size_t contacts = 0;

private:
    FirstHit first_hit_;
    Point position_;
};

}  // namespace palpate
