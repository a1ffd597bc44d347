#include "planner/delaunay/dual_line.h"

#include <CGAL/Exact_rational.h>
#include <CGAL/number_utils.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

using Exact = CGAL::Exact_rational;
using ExactVector = std::array<Exact, 3>;

// A quotient whose divisor is smaller than 1/kConditionLimit of the size of its terms loses more than about
// kConditionLimit · 2^-52 ~ 2e-11 of its digits' worth: it is computed exactly instead.
constexpr double kConditionLimit = 1e5;

// Bounds the rounding of the few sums of products below, relative to the size of their terms.
constexpr double kRounding = 256 * std::numeric_limits<double>::epsilon();

ExactVector exact(const Point& p) { return {Exact(p.x()), Exact(p.y()), Exact(p.z())}; }

ExactVector operator-(const ExactVector& u, const ExactVector& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
ExactVector operator+(const ExactVector& u, const ExactVector& v) { return {u[0] + v[0], u[1] + v[1], u[2] + v[2]}; }
ExactVector operator*(const Exact& s, const ExactVector& v) { return {s * v[0], s * v[1], s * v[2]}; }
Exact dot(const ExactVector& u, const ExactVector& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
ExactVector cross(const ExactVector& u, const ExactVector& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
Vector rounded(const ExactVector& v) { return {CGAL::to_double(v[0]), CGAL::to_double(v[1]), CGAL::to_double(v[2])}; }

// The circumcentre of a triangle with one vertex at the origin, in any number type: ((|u|² v - |v|² u) × (u × v)) / 2|u × v|²
// with the normal u × v.
struct ExactLine {
    ExactVector origin;
    ExactVector normal;  // not of unit length
};

ExactLine exact_line(const Point& a, const Point& b, const Point& c) {
    const ExactVector ea = exact(a);
    const ExactVector u = exact(b) - ea;
    const ExactVector v = exact(c) - ea;
    const ExactVector normal = cross(u, v);
    const ExactVector from_a = cross(dot(u, u) * v - dot(v, v) * u, normal);
    return {ea + (Exact(1) / (Exact(2) * dot(normal, normal))) * from_a, normal};
}

// A unit vector along v, whatever its magnitude: scaled exactly first, so that nothing underflows.
Vector unit(const ExactVector& v) {
    const Exact largest = std::max({CGAL::abs(v[0]), CGAL::abs(v[1]), CGAL::abs(v[2])});
    return rounded({v[0] / largest, v[1] / largest, v[2] / largest}).normalized();
}

double norm(const ExactVector& v) {
    const Exact largest = std::max({CGAL::abs(v[0]), CGAL::abs(v[1]), CGAL::abs(v[2])});
    return CGAL::to_double(largest) * rounded({v[0] / largest, v[1] / largest, v[2] / largest}).norm();
}

}  // namespace

DualLine dual_line(const Point& a, const Point& b, const Point& c) {
    const Vector u = b - a;
    const Vector v = c - a;
    const Vector normal = u.cross(v);
    const double size = std::max({u.squaredNorm(), v.squaredNorm(), (c - b).squaredNorm()});
    const double doubled_area = normal.norm();
    if (doubled_area * std::sqrt(kConditionLimit) < size) {  // squared area in the divisor
        const ExactLine line = exact_line(a, b, c);
        const Point origin = rounded(line.origin);
        return {origin, unit(line.normal), (origin - a).norm()};
    }
    const Vector from_a = (u.squaredNorm() * v - v.squaredNorm() * u).cross(normal) / (2 * doubled_area * doubled_area);
    return {a + from_a, normal / doubled_area, from_a.norm()};
}

double circumcentre_parameter(const DualLine& line, const Point& a, const Point& b, const Point& c, const Point& d, int side,
                              double limit) {
    // |m + t n - a|² = |m + t n - d|², with n orthogonal to m - a.
    const Vector to_d = d - a;
    const double height = line.direction.dot(to_d);
    const double size = std::max({to_d.norm(), (d - line.origin).norm(), line.circumradius});
    const double power = (d - line.origin).squaredNorm() - line.circumradius * line.circumradius;
    if (std::abs(height) * kConditionLimit < size) {
        const double power_error = kRounding * size * (size + line.origin.norm());
        const double farther_than = (std::abs(power) - power_error) / (2 * (std::abs(height) + kRounding * size));
        if (farther_than > limit) return power * side > 0 ? farther_than : -farther_than;
        const ExactLine exact_form = exact_line(a, b, c);
        const ExactVector ed = exact(d);
        const ExactVector ea = exact(a);
        const ExactVector from_d = exact_form.origin - ed;
        const ExactVector from_a = exact_form.origin - ea;
        const Exact divisor = Exact(2) * dot(exact_form.normal, ed - ea);
        return CGAL::to_double((dot(from_d, from_d) - dot(from_a, from_a)) / divisor) * norm(exact_form.normal);
    }
    return power / (2 * height);
}

Point circumcentre(const Point& a, const Point& b, const Point& c, const Point& d, double limit) {
    const Vector u = b - a;
    const Vector v = c - a;
    const Vector w = d - a;
    const double uu = u.squaredNorm();
    const double vv = v.squaredNorm();
    const double ww = w.squaredNorm();
    const double volume = u.dot(v.cross(w));
    const double size = std::sqrt(uu * vv * ww);
    const Vector numerator = uu * v.cross(w) + vv * w.cross(u) + ww * u.cross(v);
    if (std::abs(volume) * kConditionLimit >= size) return a + numerator / (2 * volume);

    // Far out even if the volume is as large as rounding allows?
    const double longest = std::sqrt(std::max({uu, vv, ww}));
    const double at_least = (numerator.norm() - kRounding * size * longest) / (2 * (std::abs(volume) + kRounding * size));
    if (at_least > limit) return a + (2 * at_least / numerator.norm()) * numerator;

    const ExactVector ea = exact(a);
    const ExactVector eu = exact(b) - ea;
    const ExactVector ev = exact(c) - ea;
    const ExactVector ew = exact(d) - ea;
    const Exact divisor = Exact(2) * dot(eu, cross(ev, ew));
    const ExactVector sum = dot(eu, eu) * cross(ev, ew) + dot(ev, ev) * cross(ew, eu) + dot(ew, ew) * cross(eu, ev);
    return rounded(ea + (Exact(1) / divisor) * sum);
}

}  // namespace palpate
