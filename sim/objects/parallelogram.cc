#include "sim/objects/parallelogram.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

namespace palpate {
namespace {

// Of the product of the sides: with less area than that, its edges alone tell the distance.
constexpr double kFlat = 1e-12;

// The inside of a parallelogram, or of the triangle that is half of it.
struct PlaneFace {
    Point corner = Point::Zero();
    Vector to_s = Vector::Zero();  // <p - corner, to_s> is the coordinate along u
    Vector to_t = Vector::Zero();
    Vector normal = Vector::Zero();  // unit
    bool is_half = false;

    [[nodiscard]] double height(const Point& p) const { return normal.dot(p - corner); }
    [[nodiscard]] bool is_level_with(const Point& p) const {
        const double s = to_s.dot(p - corner);
        const double t = to_t.dot(p - corner);
        return s >= 0 && t >= 0 && (is_half ? s + t <= 1 : s <= 1 && t <= 1);
    }
    [[nodiscard]] bool is_crossed_by(const Segment& edge) const {
        const double a = height(edge.source);
        const double b = height(edge.target);
        return (a < 0) != (b < 0) && is_level_with(edge.source + a / (a - b) * (edge.target - edge.source));
    }
};

std::optional<PlaneFace> face_of(const Point& corner, const Vector& u, const Vector& v, bool is_half) {
    const Vector across = u.cross(v);
    const double squared = across.squaredNorm();
    if (squared <= kFlat * kFlat * u.squaredNorm() * v.squaredNorm()) return std::nullopt;
    return PlaneFace{corner, v.cross(across) / squared, across.cross(u) / squared, across / std::sqrt(squared), is_half};
}

double distance(const Segment& one, const Segment& other) {
    const Vector a = one.target - one.source;
    const Vector b = other.target - other.source;
    const Vector between = one.source - other.source;
    const double aa = a.squaredNorm();
    const double ab = a.dot(b);
    const double bb = b.squaredNorm();
    // Nearest on both lines; where that is beyond an end, an end of one of them is nearest.
    double nearest = std::min(
        {distance_to(other, one.source), distance_to(other, one.target), distance_to(one, other.source), distance_to(one, other.target)});
    const double squared = aa * bb - ab * ab;
    if (squared <= kFlat * kFlat * aa * bb) return nearest;
    const double s = (ab * b.dot(between) - bb * a.dot(between)) / squared;
    const double t = (aa * b.dot(between) - ab * a.dot(between)) / squared;
    if (s > 0 && s < 1 && t > 0 && t < 1) nearest = std::min(nearest, (between + s * a - t * b).norm());
    return nearest;
}

// Between a face and what its corners are; and whether an edge of that passes through it.
double distance(const std::optional<PlaneFace>& face, std::span<const Segment> edges) {
    double nearest = std::numeric_limits<double>::infinity();
    if (!face) return nearest;
    for (const Segment& edge : edges) {
        if (face->is_crossed_by(edge)) return 0;
        for (const Point& p : {edge.source, edge.target}) {
            if (face->is_level_with(p)) nearest = std::min(nearest, std::abs(face->height(p)));
        }
    }
    return nearest;
}

}  // namespace

double distance(const Parallelogram& swept, const std::array<Point, 3>& triangle) {
    const std::array<Segment, 3> sides{{{triangle[0], triangle[1]}, {triangle[1], triangle[2]}, {triangle[2], triangle[0]}}};
    const Point& p = swept.corner;
    const Point far = p + swept.u + swept.v;
    const std::array<Segment, 4> edges{{{p, p + swept.u}, {p + swept.v, far}, {p, p + swept.v}, {p + swept.u, far}}};
    const std::span<const Segment> different = swept.v.isZero(0)   ? std::span(edges).first(1)
                                               : swept.u.isZero(0) ? std::span(edges).subspan(2, 1)
                                                                   : std::span(edges);
    double nearest = std::min(distance(face_of(triangle[0], triangle[1] - triangle[0], triangle[2] - triangle[0], true), different),
                              distance(face_of(p, swept.u, swept.v, false), sides));
    for (const Segment& edge : different) {
        for (const Segment& side : sides) nearest = std::min(nearest, distance(edge, side));
    }
    return nearest;
}

}  // namespace palpate
