// ω: the ball or box that contains the object. Everything outside it is free (DESIGN section 1).
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct Ball {
    Point center = Point::Zero();
    double radius = 0.0;  // mm, > 0
};

struct Box {
    Point min = Point::Zero();
    Point max = Point::Zero();  // every coordinate greater than min's

    // Finite, and max greater than min in each coordinate.
    [[nodiscard]] bool is_valid() const { return min.allFinite() && max.allFinite() && (min.array() < max.array()).all(); }
    // Faces are inside, and what is at most `slack` beyond them; what is not finite is outside.
    [[nodiscard]] bool contains(const Point& p, double slack = 0.0) const {
        return (p.array() >= min.array() - slack).all() && (p.array() <= max.array() + slack).all();
    }
    [[nodiscard]] bool contains(const Box& inner) const { return contains(inner.min) && contains(inner.max); }
};

// Parameters of a line x(t) = origin + t · direction.
struct Interval {
    double low = 0.0;
    double high = 0.0;
};

class Workspace {
public:
    // Throws std::invalid_argument on a radius or side that is not positive and finite.
    explicit Workspace(const Ball& ball);
    explicit Workspace(const Box& box);

    [[nodiscard]] const std::variant<Ball, Box>& shape() const { return shape_; }
    [[nodiscard]] Point center() const;
    [[nodiscard]] double radius() const;  // mm: of the smallest ball around center() that contains ω
    [[nodiscard]] double volume() const;  // mm³
    [[nodiscard]] bool contains(const Point& p) const;

    // The part of the line inside ω, or nothing where the line misses it. `direction` has unit length.
    [[nodiscard]] std::optional<Interval> clip(const Point& origin, const Vector& direction) const;

    // Where a straight way from outside ω to `p` should enter: the point of ω's boundary nearest to `p` in ω's own
    // metric (radially for a ball, through the nearest face for a box).
    [[nodiscard]] Point nearest_boundary(const Point& p) const;

    // The points to pass, after `from` and up to and with `to`, on a short way outside the interior of ω between two
    // points of its boundary. For a ball: the polygon of tangents around the great-circle arc, so that no chord cuts ω.
    // For a box: straight on a face, or over the edges of the faces between.
    [[nodiscard]] std::vector<Point> outer_path(const Point& from, const Point& to) const;
    // The least box along the axes that holds ω and every outer_path.
    [[nodiscard]] Box outer_bounds() const;
    // Length of outer_path, without building it.
    [[nodiscard]] double outer_distance(const Point& from, const Point& to) const;

private:
    std::variant<Ball, Box> shape_;
};

}  // namespace palpate
