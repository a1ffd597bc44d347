// ω: the ball or box that contains the object (planner/DESIGN.md, "Terms").
#pragma once

#include <optional>
#include <variant>

#include "planner/geometry.h"

namespace palpate {

class Region {
public:
    // Throws std::invalid_argument on a radius or side that is not positive and finite.
    explicit Region(const Ball& ball);
    explicit Region(const Box& box);

    [[nodiscard]] const std::variant<Ball, Box>& shape() const { return shape_; }
    [[nodiscard]] Point center() const;
    [[nodiscard]] double radius() const;  // mm: of the smallest ball around center() that contains ω
    [[nodiscard]] double volume() const;  // mm³
    [[nodiscard]] bool contains(const Point& p) const;

    // The part of the line inside ω, or nothing where the line misses it. `direction` has unit length.
    [[nodiscard]] std::optional<Interval> clip(const Point& origin, const Vector& direction) const;

    // The point of ω's boundary nearest to `p` in ω's own metric (radially for a ball, through the nearest face for a box).
    [[nodiscard]] Point nearest_boundary(const Point& p) const;

private:
    std::variant<Ball, Box> shape_;
};

}  // namespace palpate
