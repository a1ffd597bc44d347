#include "sim/objects/internal/primitive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/objects/errors.h"

namespace palpate {
namespace {

template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

// S at distance r of a core whose nearest point is `foot`; `fallback` is a normal there, for p on the core itself.
Nearest offset(const Point& p, const Point& foot, double r, const Vector& fallback) {
    const Vector away = p - foot;
    const double distance = away.norm();
    return distance > 0.0 ? Nearest{distance - r, away / distance} : Nearest{-r, fallback};
}

Vector box_core(const RoundedBoxSpec& s) { return (0.5 * s.size.array() - s.fillet).max(0.0).matrix(); }

// F of the equation F(w) = 0 whose root gives the foot; r[i] = (e[i]/c)², z[i] = |p[i]|/e[i] with the smallest semi-axis c.
// Convex and decreasing for w > 0. Terms with z = 0 vanish, at w = 0 too.
struct EllipsoidEquation {
    Vector r;
    Vector z;

    [[nodiscard]] double value(double w) const {
        double sum = -1.0;
        for (int i = 0; i < 3; ++i) {
            const double x = term(i, w);
            sum += x * x;
        }
        return sum;
    }
    [[nodiscard]] double slope(double w) const {
        double sum = 0.0;
        for (int i = 0; i < 3; ++i) {
            const double x = term(i, w);
            if (x != 0.0) sum -= 2.0 * x * x / (w + (r[i] - 1.0));
        }
        return sum;
    }

private:
    [[nodiscard]] double term(int i, double w) const { return z[i] == 0.0 ? 0.0 : r[i] * z[i] / (w + (r[i] - 1.0)); }
};

// Newton's method from the left rises monotonically on a convex decreasing function; a step that leaves the bracket
// through rounding is replaced by bisection.
double root(const EllipsoidEquation& f) {
    constexpr int kMaxSteps = 2200;  // bisection alone walks through all exponents and bits of a double in fewer
    double low = 0.0;
    for (int i = 0; i < 3; ++i) low = std::max(low, f.r[i] * f.z[i] - (f.r[i] - 1.0));
    double high = std::max(low, f.r.cwiseProduct(f.z).norm());
    double w = low;
    for (int step = 0; step < kMaxSteps; ++step) {
        const double value = f.value(w);
        if (value == 0.0) break;
        (value > 0.0 ? low : high) = w;
        double next = w - value / f.slope(w);
        if (next == w) break;
        if (!(next > low && next < high)) next = low + 0.5 * (high - low);
        if (next <= low || next >= high) break;
        w = next;
    }
    return w;
}

void require(bool ok, const std::string& where, const char* what, double value) {
    if (!ok) throw ObjectError(fmt::format("{}: {}, but it is {:.6g}", where, what, value));
}

bool positive(double x) { return std::isfinite(x) && x > 0.0; }

}  // namespace

Nearest nearest(const SphereSpec& s, const Point& p) { return offset(p, Point::Zero(), s.radius, Vector::UnitX()); }

// After D. Eberly, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid": with e the semi-axes and t
// the root of Σ (e_i p_i / (t + e_i²))² = 1, the foot is e_i² p_i / (t + e_i²). We solve for w = (t + c²)/c², which keeps all digits near
// t = -c², where points close to the plane of the two larger axes have their root.
Nearest nearest(const EllipsoidSpec& s, const Point& p) {
    int smallest = 0;
    const double c = s.semi_axes.minCoeff(&smallest);
    EllipsoidEquation f{(s.semi_axes / c).cwiseAbs2(), p.cwiseAbs().cwiseQuotient(s.semi_axes)};
    f.r[smallest] = 1.0;
    Point foot = Point::Zero();
    // p in the plane of the larger axes and so deep inside that the nearest points are off that plane, on both sides of it.
    const bool off_plane = f.z[smallest] == 0.0 && f.value(0.0) < 0.0;
    const double w = off_plane ? 0.0 : root(f);
    for (int i = 0; i < 3; ++i) {
        if (f.z[i] != 0.0) foot[i] = f.r[i] * p[i] / (w + (f.r[i] - 1.0));
    }
    if (off_plane) foot[smallest] = c * std::sqrt(-f.value(0.0));
    const bool inside = f.z.squaredNorm() < 1.0;
    const double distance = (p - foot).norm();
    return {inside ? -distance : distance, foot.cwiseQuotient(s.semi_axes.cwiseAbs2()).normalized()};
}

Nearest nearest(const TorusSpec& s, const Point& p) {
    const double rho = std::sqrt(p.x() * p.x() + p.y() * p.y());
    const double ex = rho > 0.0 ? p.x() / rho : 1.0;
    const double ey = rho > 0.0 ? p.y() / rho : 0.0;
    const double u = rho - s.major;
    const double d = std::sqrt(u * u + p.z() * p.z());
    if (d == 0.0) return {-s.minor, Vector(ex, ey, 0.0)};
    return {d - s.minor, Vector(ex * u / d, ey * u / d, p.z() / d)};
}

Nearest nearest(const CapsuleSpec& s, const Point& p) {
    const double half = 0.5 * s.length;
    return offset(p, Point(0.0, 0.0, std::clamp(p.z(), -half, half)), s.radius, Vector::UnitX());
}

Nearest nearest(const RoundedBoxSpec& s, const Point& p) {
    const Vector core = box_core(s);
    const Point foot = p.cwiseMax(-core).cwiseMin(core);
    if (foot != p) return offset(p, foot, s.fillet, Vector::UnitX());
    int axis = 0;
    const double depth = (core - p.cwiseAbs()).minCoeff(&axis);
    Vector outward = Vector::Zero();
    outward[axis] = p[axis] < 0.0 ? -1.0 : 1.0;
    return {-depth - s.fillet, outward};
}

Nearest nearest(const Genus2Spec& s, const Point& p) {
    const Point q = p / s.scale;
    const auto pushed = [&](double cx, double radius) {  // from q's plane point to the circle around (cx, 0)
        const double dx = q.x() - cx;
        const double rho = std::sqrt(dx * dx + q.y() * q.y());
        const double f = rho > 0.0 ? radius / rho : 0.0;
        return rho > 0.0 ? Point(cx + dx * f, q.y() * f, 0.0) : Point(cx + radius, 0.0, 0.0);
    };
    const auto within = [&](double cx, double radius) { return (q.x() - cx) * (q.x() - cx) + q.y() * q.y() < radius * radius; };
    const double hole = std::copysign(kGenus2HalfLength, q.x());
    const double spine = std::clamp(q.x(), -kGenus2HalfLength, kGenus2HalfLength);
    Point foot(q.x(), q.y(), 0.0);
    if (within(hole, kGenus2HoleRadius)) {
        foot = pushed(hole, kGenus2HoleRadius);
    } else if (!within(spine, kGenus2PlateRadius)) {
        foot = pushed(spine, kGenus2PlateRadius);
    }
    Nearest result = offset(q, foot, kGenus2Offset, Vector::UnitZ());
    result.distance *= s.scale;
    return result;
}

Measures measures(const Primitive& primitive) {
    return std::visit(Overloaded{
                          [](const SphereSpec& s) {
                              return Measures{true, 2, s.radius, s.radius, kInfinity};
                          },
                          [](const EllipsoidSpec& s) {
                              // Least radius of curvature: at the tip of the longest axis, in the plane of the shortest.
                              const double a = s.semi_axes.maxCoeff();
                              const double c = s.semi_axes.minCoeff();
                              return Measures{true, 2, a, c * (c / a), kInfinity};
                          },
                          [](const TorusSpec& s) {
                              return Measures{false, 0, s.major + s.minor, s.minor, s.major - s.minor};
                          },
                          [](const CapsuleSpec& s) {
                              return Measures{true, 2, 0.5 * s.length + s.radius, s.radius, kInfinity};
                          },
                          [](const RoundedBoxSpec& s) {
                              return Measures{true, 2, box_core(s).norm() + s.fillet, s.fillet, kInfinity};
                          },
                          [](const Genus2Spec& s) {
                              return Measures{false, -2, s.scale * (kGenus2HalfLength + kGenus2PlateRadius + kGenus2Offset),
                                              s.scale * kGenus2Offset, s.scale * (kGenus2HoleRadius - kGenus2Offset)};
                          },
                      },
                      primitive);
}

double support(const Primitive& primitive, const Vector& n) {
    return std::visit(
        Overloaded{
            [&](const SphereSpec& s) { return s.radius * n.norm(); },
            [&](const EllipsoidSpec& s) { return s.semi_axes.cwiseProduct(n).norm(); },
            [&](const TorusSpec& s) { return s.major * n.head<2>().norm() + s.minor * n.norm(); },
            [&](const CapsuleSpec& s) { return 0.5 * s.length * std::abs(n.z()) + s.radius * n.norm(); },
            [&](const RoundedBoxSpec& s) { return box_core(s).dot(n.cwiseAbs()) + s.fillet * n.norm(); },
            [&](const Genus2Spec& s) {
                return s.scale * (kGenus2HalfLength * std::abs(n.x()) + kGenus2PlateRadius * n.head<2>().norm() + kGenus2Offset * n.norm());
            },
        },
        primitive);
}

std::string name_of(const Primitive& primitive) {
    return std::visit(Overloaded{
                          [](const SphereSpec&) { return "sphere"; },
                          [](const EllipsoidSpec&) { return "ellipsoid"; },
                          [](const TorusSpec&) { return "torus"; },
                          [](const CapsuleSpec&) { return "capsule"; },
                          [](const RoundedBoxSpec&) { return "rounded box"; },
                          [](const Genus2Spec&) { return "genus2"; },
                      },
                      primitive);
}

void require_valid(const Primitive& primitive, const std::string& where) {
    std::visit(Overloaded{
                   [&](const SphereSpec& s) { require(positive(s.radius), where, "radius must be a positive number of mm", s.radius); },
                   [&](const EllipsoidSpec& s) {
                       for (double a : s.semi_axes) require(positive(a), where, "every semi-axis must be a positive number of mm", a);
                   },
                   [&](const TorusSpec& s) {
                       require(positive(s.minor), where, "minor must be a positive number of mm", s.minor);
                       require(std::isfinite(s.major) && s.major > s.minor, where, "major must exceed minor, or the tube has no hole",
                               s.major);
                   },
                   [&](const CapsuleSpec& s) {
                       require(positive(s.radius), where, "radius must be a positive number of mm", s.radius);
                       require(std::isfinite(s.length) && s.length >= 0.0, where, "length must be zero or more mm", s.length);
                   },
                   [&](const RoundedBoxSpec& s) {
                       for (double a : s.size) require(positive(a), where, "every side must be a positive number of mm", a);
                       require(s.fillet >= 0.0 && s.fillet <= 0.5 * s.size.minCoeff(), where,
                               "fillet must lie between 0 and half the smallest side", s.fillet);
                   },
                   [&](const Genus2Spec& s) { require(positive(s.scale), where, "scale must be a positive number", s.scale); },
               },
               primitive);
}

}  // namespace palpate
