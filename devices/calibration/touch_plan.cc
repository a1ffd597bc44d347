#include "devices/calibration/touch_plan.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

constexpr double kPi = std::numbers::pi;
// Between places where a way around touches the sphere of clearance: corners lie 1 / cos(half of it) farther, 8 %.
constexpr double kStep = kPi / 4;
// Rounding, of unit vectors.
constexpr double kUnitRounding = 1e-9;

// Unit vectors across the axis: x is as near to the machine's X as can be.
struct Frame {
    explicit Frame(const Vector& axis) : z(axis) {
        const Vector flat = Vector::UnitX() - axis.x() * axis;
        constexpr double kParallel = 0.1;
        x = flat.norm() > kParallel ? flat.normalized() : Vector((Vector::UnitY() - axis.y() * axis).normalized());
        y = z.cross(x);
    }
    // radians
    [[nodiscard]] Vector at(double elevation, double azimuth) const {
        return std::cos(elevation) * (std::cos(azimuth) * x + std::sin(azimuth) * y) + std::sin(elevation) * z;
    }
    Vector x;
    Vector y;
    Vector z;
};

void add_ring(std::vector<Vector>& directions, const Frame& frame, int count, double elevation, double turn) {
    for (int k = 0; k < count; ++k) directions.push_back(frame.at(elevation, turn + 2 * kPi * k / count));
}

// Corners of a way along the great circle from `a` to `b`, circumscribed about the sphere of that radius, which it touches at both ends.
void add_arc(std::vector<Point>& way, const Vector& a, const Vector& b, const Point& center, double radius) {
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    if (angle < kUnitRounding) return;
    const auto corners = static_cast<int>(std::ceil(angle / kStep));
    const double step = angle / corners;
    const Vector across = (b - b.dot(a) * a).normalized();
    for (int k = 0; k < corners; ++k) {
        const double at = (k + 0.5) * step;
        way.emplace_back(center + radius / std::cos(step / 2) * (std::cos(at) * a + std::sin(at) * across));
    }
    way.emplace_back(center + radius * b);
}

// Two directions above the equator: so is the arc between them. Where it is not defined it goes over the pole.
void add_way_around(std::vector<Point>& way, const Vector& a, const Vector& b, const Vector& pole, const Point& center, double radius) {
    constexpr double kOpposite = -0.99;
    if (a.dot(b) > kOpposite) return add_arc(way, a, b, center, radius);
    add_arc(way, a, pole, center, radius);
    add_arc(way, pole, b, center, radius);
}

void require_positive(double value, const char* what) {
    if (!(value > 0) || !std::isfinite(value)) throw QualificationError(fmt::format("{} is {} mm, it has to be positive", what, value));
}

// Nothing of the holder comes as near to the sphere as the stylus' ball does: worst on the equator, where it stands beside the sphere.
void require_holder_apart(const ReferenceSphere& sphere, const ToolShape& tool, double margin) {
    if (!tool.holder) return;
    const double above = tool.stylus ? tool.stylus->length : 0.0;
    const double beside = touched_distance(sphere, tool) - margin;
    if (std::hypot(beside, above) - tool.holder->diameter / 2 > sphere.diameter / 2 + margin) return;
    throw QualificationError(
        fmt::format("the holder ({} mm) would touch the sphere ({} mm) before the ball does on its equator: take a longer "
                    "stylus, or a larger sphere",
                    tool.holder->diameter, sphere.diameter));
}

void require_sense(const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins,
                   const std::vector<Vector>& directions) {
    require_positive(sphere.diameter, "the sphere's diameter");
    require_positive(tool.ball_diameter, "the ball's diameter");
    require_positive(margins.center_error_mm, "the error of the sphere's centre");
    require_positive(margins.clearance_mm, "the clearance around the sphere");
    if (!sphere.center.allFinite()) throw QualificationError("the sphere's centre is not finite");
    if (std::abs(tool.axis.norm() - 1) > kUnitRounding) throw QualificationError("the tool's axis is no unit vector");
    if (touched_distance(sphere, tool) <= margins.center_error_mm + kMostPretravel_mm) {
        throw QualificationError("the sphere's centre is not known well enough for so small a sphere");
    }
    for (const Vector& n : directions) {
        if (!(std::abs(n.norm() - 1) <= kUnitRounding)) throw QualificationError("a direction is no unit vector");
        if (n.dot(tool.axis) < -kUnitRounding) throw QualificationError("a direction is below the equator, where the stylus touches first");
    }
    require_holder_apart(sphere, tool, margins.center_error_mm);
}

}  // namespace

std::vector<Vector> iso_directions(const Vector& axis) {
    const Frame frame(axis);
    constexpr double kTurn = kPi / 8;
    std::vector<Vector> directions{axis};
    add_ring(directions, frame, 4, 3 * kPi / 8, 0);
    add_ring(directions, frame, 8, kPi / 4, kTurn);
    add_ring(directions, frame, 4, kPi / 8, 2 * kTurn);
    add_ring(directions, frame, 8, 0, 3 * kTurn);
    return directions;
}

std::vector<Vector> qualification_directions(const Vector& axis, std::size_t count) {
    assert(count >= kIsoTouches);
    const Frame frame(axis);
    std::vector<Vector> directions = iso_directions(axis);
    const auto more = static_cast<double>(count - kIsoTouches);
    double azimuth = 0;
    for (std::size_t k = 0; directions.size() < count; ++k) {
        const double height = (static_cast<double>(k) + 0.5) / more;
        // Saff and Kuijlaars 1997: about as far from one turn to the next as along it; twice as many would cover the whole sphere.
        azimuth += 3.6 / std::sqrt(2 * more * (1 - height * height));
        directions.push_back(frame.at(std::asin(height), azimuth));
    }
    return directions;
}

std::vector<Vector> centering_directions(const Vector& axis) {
    std::vector<Vector> directions{axis};
    add_ring(directions, Frame(axis), 4, kPi / 6, 0);
    return directions;
}

std::vector<std::size_t> repeated_directions() { return {0, 5, 9, 17, 21}; }

double touched_distance(const ReferenceSphere& sphere, const ToolShape& tool) { return (sphere.diameter + tool.ball_diameter) / 2; }

double farthest_touch(const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins) {
    return touched_distance(sphere, tool) + margins.center_error_mm + kMostPretravel_mm;
}

TouchPlan plan_touches(const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins, const Point& from,
                       const std::vector<Vector>& directions) {
    require_sense(sphere, tool, margins, directions);
    const double farthest = farthest_touch(sphere, tool, margins);
    const double around = farthest + margins.clearance_mm;
    const double deepest = touched_distance(sphere, tool) - margins.center_error_mm - kMostPretravel_mm;
    const Vector out = from - sphere.center;
    if (!(out.dot(tool.axis) >= -kUnitRounding * around && out.norm() > farthest)) {
        throw QualificationError(fmt::format(
            "the tool has to stand above the sphere's equator, {:.1f} mm or more from its centre, before it goes around it", farthest));
    }
    TouchPlan plan;
    Vector at = out.normalized();
    for (const Vector& n : directions) {
        PlannedTouch touch{n, {}, sphere.center + deepest * n};
        // Straight to or from the sphere's centre first.
        if (plan.touches.empty()) touch.way.emplace_back(sphere.center + around * at);
        add_way_around(touch.way, at, n, tool.axis, sphere.center, around);
        if (touch.way.empty()) touch.way.emplace_back(sphere.center + around * n);
        plan.touches.push_back(std::move(touch));
        at = n;
    }
    add_way_around(plan.leave, at, tool.axis, tool.axis, sphere.center, around);
    return plan;
}

}  // namespace palpate
