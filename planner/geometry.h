// Value types that every module shares. Lengths are millimetres.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace palpate {

using Point = Eigen::Vector3d;
using Vector = Eigen::Vector3d;

struct Segment {
    Point source = Point::Zero();
    Point target = Point::Zero();
};

// The point of the segment that is nearest to `p`.
[[nodiscard]] inline Point nearest_on(const Segment& segment, const Point& p) {
    const Vector way = segment.target - segment.source;
    const double squared = way.squaredNorm();
    const double share = squared > 0 ? std::clamp((p - segment.source).dot(way) / squared, 0.0, 1.0) : 0.0;
    return segment.source + share * way;
}
// mm: from `p` to that point.
[[nodiscard]] inline double distance_to(const Segment& segment, const Point& p) { return (p - nearest_on(segment, p)).norm(); }

// mm: from `from` straight to every point of the path in turn.
[[nodiscard]] inline double path_length(const Point& from, const std::vector<Point>& path) {
    double length = 0;
    Point last = from;
    for (const Point& p : path) {
        length += (p - last).norm();
        last = p;
    }
    return length;
}

// mm: of the triangle's circle; infinite without area.
[[nodiscard]] inline double circumradius(const Point& a, const Point& b, const Point& c) {
    const Vector u = b - a;
    const Vector v = c - a;
    const double twice_area = u.cross(v).norm();
    if (!(twice_area > 0)) return std::numeric_limits<double>::infinity();
    return u.norm() * v.norm() * (u - v).norm() / (2 * twice_area);
}

// An indexed triangle mesh; triangles are counter-clockwise seen from outside the solid.
struct TriangleMesh {
    std::vector<Point> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct Ball {
    Point center = Point::Zero();
    double radius = 0.0;  // mm, > 0
};

// Along the axes; mm.
struct Box {
    Point min = Point::Zero();
    Point max = Point::Zero();

    // Finite, and max greater than min in each coordinate.
    [[nodiscard]] bool is_valid() const { return min.allFinite() && max.allFinite() && (min.array() < max.array()).all(); }
    // Faces are inside, and what is at most `slack` beyond them; what is not finite is outside.
    [[nodiscard]] bool contains(const Point& p, double slack = 0.0) const {
        return (p.array() >= min.array() - slack).all() && (p.array() <= max.array() + slack).all();
    }
    [[nodiscard]] bool contains(const Box& inner) const { return contains(inner.min) && contains(inner.max); }
    [[nodiscard]] Point center() const { return 0.5 * (min + max); }
    [[nodiscard]] double diagonal() const { return (max - min).norm(); }  // mm
};

// Parameters of a line x(t) = origin + t · direction.
struct Interval {
    double low = 0.0;
    double high = 0.0;
};

}  // namespace palpate
