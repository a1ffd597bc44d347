#include "sim/objects/internal/line_trace.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace palpate {
namespace {

struct Interval {
    double begin = 0.0;
    double end = 0.0;
};

// Where o + t u is inside the unit ball. Measured from the point nearest to the centre, so nothing cancels far away.
std::optional<Interval> in_unit_ball(const Vector& o, const Vector& u) {
    const double uu = u.squaredNorm();
    const double middle = -o.dot(u) / uu;
    const double square = 1.0 - (o + middle * u).squaredNorm();
    if (square < 0.0) return std::nullopt;
    const double half = std::sqrt(square / uu);
    return Interval{middle - half, middle + half};
}

Point at(const Ray& ray, double t) { return ray.origin + t * ray.direction; }

Ray reversed(const Ray& ray) { return {at(ray, ray.length), -ray.direction, ray.length}; }

// Last Newton step, for the digits below the tolerance. Only where it is well-conditioned: a grazing ray is as near as it gets.
double polished(double t, double d, double c, double length) {
    constexpr double kGrazing = 1e-3;  // cosine
    return c < -kGrazing ? std::clamp(t - d / c, 0.0, length) : t;
}

// Sphere, ellipsoid: the whole line's stretch inside.
std::optional<Interval> stretch(const SphereSpec& s, const Ray& ray) {
    return in_unit_ball(ray.origin / s.radius, ray.direction / s.radius);
}
std::optional<Interval> stretch(const EllipsoidSpec& s, const Ray& ray) {
    return in_unit_ball(ray.origin.cwiseQuotient(s.semi_axes), ray.direction.cwiseQuotient(s.semi_axes));
}

// First point of a convex S from outside.
template <class S>
std::optional<double> enter_convex(const S& s, const Ray& ray, double tolerance) {
    double t = 0.0;
    while (true) {
        const Nearest n = nearest(s, at(ray, t));
        const double c = n.outward.dot(ray.direction);
        if (n.distance <= tolerance) return polished(t, n.distance, c, ray.length);
        if (c >= 0.0) return std::nullopt;  // the tangent plane's far side is all free
        const double next = t - n.distance / c;
        if (next > ray.length + tolerance) return std::nullopt;
        if (!(next > t)) return t;  // rounding ends the approach
        t = std::min(next, ray.length);
    }
}

// Length of free path at distance d of S: to the end of the ball of radius d, or of the tangent ball if that is larger.
double free_path(double d, double c, double reach) {
    if (d >= reach) return d;
    const double b = (reach - d) * c;
    const double q = d * (2.0 * reach - d);
    const double s = std::sqrt(b * b + q);
    return c < 0.0 ? q / (s - b) : s + b;
}

// One side of S.
struct Side {
    double sign = 1.0;   // of the signed distance there
    double reach = 0.0;  // mm
};

struct Approach {
    double t = 0.0;
    double c = 0.0;  // cosine, < 0: heading for S
};

template <class S>
std::optional<Approach> approach(const S& s, const Ray& ray, double t, const Side& side, double tolerance) {
    while (t <= ray.length) {
        const Nearest n = nearest(s, at(ray, t));
        const double d = side.sign * n.distance;
        const double c = side.sign * n.outward.dot(ray.direction);
        if (d <= tolerance && c < 0.0) return Approach{polished(t, d, c, ray.length), c};
        const double next = t + free_path(std::max(d, tolerance), c, side.reach);
        if (!(next > t)) return Approach{t, c};
        t = (t < ray.length && next > ray.length && next <= ray.length + tolerance) ? ray.length : next;
    }
    return std::nullopt;
}

template <class S>
void append_by_reach(const S& s, const Ray& ray, double tolerance, std::vector<double>& out) {
    const Measures m = measures(s);
    Side side{1.0, m.reach_outside};
    Side other{-1.0, m.reach_inside};
    if (nearest(s, ray.origin).distance < 0.0) std::swap(side, other);
    double t = 0.0;
    while (const auto hit = approach(s, ray, t, side, tolerance)) {
        // Is the middle of the chord through the tangent ball on the other side really there? Else it was a touch.
        t = hit->t + std::max(other.reach * std::abs(hit->c), std::sqrt(2.0 * other.reach * tolerance));
        if (other.sign * nearest(s, at(ray, t)).distance > tolerance) {
            out.push_back(hit->t);
            std::swap(side, other);
        }
    }
}

template <class S>
constexpr bool kClosedForm = std::is_same_v<S, SphereSpec> || std::is_same_v<S, EllipsoidSpec>;
template <class S>
constexpr bool kTraced = std::is_same_v<S, TorusSpec> || std::is_same_v<S, Genus2Spec>;

template <class S>
std::optional<double> first_hit_of(const S& s, const Ray& ray, double tolerance) {
    const double start = nearest(s, ray.origin).distance;
    if (std::abs(start) <= tolerance) return 0.0;
    if constexpr (kClosedForm<S>) {
        const auto inside = stretch(s, ray);
        if (!inside) return std::nullopt;
        const double t = start > 0.0 ? inside->begin : inside->end;
        if (t < 0.0 || t > ray.length + tolerance) return std::nullopt;
        return std::min(t, ray.length);
    } else if constexpr (kTraced<S>) {
        const Measures m = measures(s);
        const Side side = start > 0.0 ? Side{1.0, m.reach_outside} : Side{-1.0, m.reach_inside};
        const auto hit = approach(s, ray, 0.0, side, tolerance);
        return hit ? std::optional(hit->t) : std::nullopt;
    } else {
        if (start > 0.0) return enter_convex(s, ray, tolerance);
        if (nearest(s, at(ray, ray.length)).distance < 0.0) return std::nullopt;  // convex: all inside
        const auto back = enter_convex(s, reversed(ray), tolerance);
        return back ? ray.length - *back : ray.length;
    }
}

// Both ends of a convex solid's stretch on the line, from the ends of the ray that are outside.
template <class S>
void append_convex(const S& s, const Ray& ray, double tolerance, std::vector<double>& out) {
    std::optional<double> in;
    std::optional<double> exit;
    if (nearest(s, ray.origin).distance > 0.0) {
        in = enter_convex(s, ray, tolerance);
        if (!in) return;
    }
    if (nearest(s, at(ray, ray.length)).distance > 0.0) {
        const auto back = enter_convex(s, reversed(ray), tolerance);
        if (back) exit = ray.length - *back;
        if (in && (!exit || *exit <= *in)) return;  // a touch
    }
    if (in) out.push_back(*in);
    if (exit) out.push_back(*exit);
}

template <class S>
void append_of(const S& s, const Ray& ray, double tolerance, std::vector<double>& out) {
    if constexpr (kClosedForm<S>) {
        const auto inside = stretch(s, ray);
        if (!inside || inside->begin == inside->end) return;
        for (double t : {inside->begin, inside->end}) {
            if (t >= 0.0 && t <= ray.length) out.push_back(t);
        }
    } else if constexpr (kTraced<S>) {
        append_by_reach(s, ray, tolerance, out);
    } else {
        append_convex(s, ray, tolerance, out);
    }
}

// The part of the ray inside the bounding sphere, with the length cut off before it; nothing if they miss.
struct Clipped {
    Ray ray;
    double before = 0.0;
};
std::optional<Clipped> clipped(const Primitive& primitive, const Ray& ray) {
    constexpr double kSlack = 1.0 + 1e-6;  // keeps the clipped ends off S
    const double radius = kSlack * measures(primitive).bounding_radius;
    const auto inside = in_unit_ball(ray.origin / radius, ray.direction / radius);
    if (!inside || inside->end < 0.0 || inside->begin > ray.length) return std::nullopt;
    const double begin = std::max(0.0, inside->begin);
    const double end = std::min(ray.length, inside->end);
    return Clipped{{at(ray, begin), ray.direction, end - begin}, begin};
}

}  // namespace

std::optional<double> first_hit(const Primitive& primitive, const Ray& ray, double tolerance) {
    const auto part = clipped(primitive, ray);
    if (!part) return std::nullopt;
    const auto hit = std::visit([&](const auto& s) { return first_hit_of(s, part->ray, tolerance); }, primitive);
    return hit ? std::optional(part->before + *hit) : std::nullopt;
}

void append_crossings(const Primitive& primitive, const Ray& ray, double tolerance, std::vector<double>& out) {
    const auto part = clipped(primitive, ray);
    if (!part) return;
    const std::size_t first = out.size();
    std::visit([&](const auto& s) { append_of(s, part->ray, tolerance, out); }, primitive);
    for (std::size_t i = first; i < out.size(); ++i) out[i] += part->before;
}

}  // namespace palpate
