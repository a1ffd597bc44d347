#include "sim/objects/capsule_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

// Of a feature's own size: so far beyond its ends it still counts, so that nothing slips between two of them.
constexpr double kSlack = 1e-9;
// mm per mm of what is involved: nearer than that to the radius, a move begins in touch.
constexpr double kTouching = 1e-9;

// A ray, and the first thing that it enters.
class Entry {
public:
    // `touching` (mm): nearer than that to the radius, the ray begins on the boundary.
    Entry(const Segment& move, double radius, double touching)
        : from_(move.source), way_(move.target - move.source), radius_(radius), touching_(touching) {}

    void ball(const Point& centre) {
        enter_quadric(from_ - centre, way_, [](double) { return true; });
    }

    // Without its ends: balls are there.
    void cylinder(const Point& a, const Vector& along) {
        const double squared = along.squaredNorm();
        if (squared == 0) return;
        const Vector to = from_ - a;
        const double start = to.dot(along) / squared;
        const double step = way_.dot(along) / squared;
        enter_quadric(to - start * along, way_ - step * along, [&](double t) {
            const double at = start + t * step;
            return at >= -kSlack && at <= 1 + kSlack;
        });
    }

    // The parallelogram a + s u + t v with s, t in [0, 1], or its half with s + t <= 1.
    void face(const Point& a, const Vector& u, const Vector& v, bool is_half) {
        const Vector normal = u.cross(v);
        const double area = normal.norm();
        if (area <= kSlack * u.norm() * v.norm()) return;
        const Vector n = normal / area;
        const double height = n.dot(from_ - a);
        const double rise = n.dot(way_);
        // From within the slab the face is entered beside it: through its edges.
        if (std::abs(height) < radius_ - touching_ || height * rise >= 0) return;
        const double t = std::max(0.0, (std::copysign(radius_, height) - height) / rise);
        if (t > 1) return;
        const Vector at = from_ + t * way_ - a;
        const double s = at.cross(v).dot(n) / area;
        const double r = u.cross(at).dot(n) / area;
        if (s < -kSlack || r < -kSlack) return;
        if (is_half ? s + r > 1 + kSlack : s > 1 + kSlack || r > 1 + kSlack) return;
        note(t);
    }

    [[nodiscard]] std::optional<double> first() const { return first_; }

private:
    // When |to + t way| falls to the radius, where `counts(t)`.
    template <typename Counts>
    void enter_quadric(const Vector& to, const Vector& way, const Counts& counts) {
        const double a = way.squaredNorm();
        const double b = to.dot(way);
        const double c = to.squaredNorm() - radius_ * radius_;
        if (a == 0 || b >= 0) return;
        const double discriminant = b * b - a * c;
        if (discriminant < 0) return;
        // What passes no deeper than the slack slides along, from one feature to the next.
        const double least = std::max(0.0, radius_ - touching_);
        if (to.squaredNorm() - b * b / a > least * least) return;
        // c over the other root: nothing cancels.
        const double t = c < 0 && c > -2 * radius_ * touching_ ? 0.0 : c / (-b + std::sqrt(discriminant));
        if (t >= 0 && t <= 1 && counts(t)) note(t);
    }
    void note(double t) { first_ = first_ ? std::min(*first_, t) : t; }

    const Point from_;
    const Vector way_;
    const double radius_;
    const double touching_;
    std::optional<double> first_;
};

double squared_distance(const Point& p, const Point& a, const Vector& along) {
    const double squared = along.squaredNorm();
    const double t = squared > 0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
    return (p - a - t * along).squaredNorm();
}

// Whether the point is over the parallelogram, or its half, and how far from its plane.
std::optional<double> distance_over(const Point& p, const Point& a, const Vector& u, const Vector& v, bool is_half) {
    const Vector normal = u.cross(v);
    const double area = normal.norm();
    if (area <= kSlack * u.norm() * v.norm()) return std::nullopt;
    const Vector n = normal / area;
    const Vector at = p - a;
    const double s = at.cross(v).dot(n) / area;
    const double r = u.cross(at).dot(n) / area;
    if (s < 0 || r < 0 || (is_half ? s + r > 1 : s > 1 || r > 1)) return std::nullopt;
    return std::abs(n.dot(at));
}

// Visits what bounds the prism K ⊕ −[0, core].
template <typename Face, typename Edge, typename Corner>
void visit_prism(const std::array<Point, 3>& k, const Vector& core, const Face& face, const Edge& edge, const Corner& corner) {
    const bool has_core = !core.isZero(0);
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector side = k.at((i + 1) % 3) - k.at(i);
        corner(k.at(i));
        edge(k.at(i), side);
        if (!has_core) continue;
        corner(k.at(i) - core);
        edge(k.at(i) - core, side);
        edge(k.at(i), Vector(-core));
        face(k.at(i), side, Vector(-core), false);
    }
    face(k[0], Vector(k[1] - k[0]), Vector(k[2] - k[0]), true);
    if (has_core) face(k[0] - core, Vector(k[1] - k[0]), Vector(k[2] - k[0]), true);
}

// mm: from the prism; 0 within.
double distance_from_prism(const std::array<Point, 3>& k, const Vector& core, const Point& p) {
    // Within, if the line through p along the core passes through the triangle there.
    const Vector normal = (k[1] - k[0]).cross(k[2] - k[0]);
    const double rise = normal.dot(core);
    if (rise != 0) {
        const double along = normal.dot(k[0] - p) / rise;
        if (along >= 0 && along <= 1) {
            const auto over = distance_over(p + along * core, k[0], k[1] - k[0], k[2] - k[0], true);
            if (over) return 0;
        }
    }
    double squared = std::numeric_limits<double>::infinity();
    visit_prism(
        k, core,
        [&](const Point& a, const Vector& u, const Vector& v, bool is_half) {
            if (const auto over = distance_over(p, a, u, v, is_half)) squared = std::min(squared, *over * *over);
        },
        [&](const Point& a, const Vector& along) { squared = std::min(squared, squared_distance(p, a, along)); }, [](const Point&) {});
    return std::sqrt(squared);
}

}  // namespace

std::optional<double> first_contact(const std::array<Point, 3>& triangle, const Capsule& capsule, const Segment& move) {
    const double scale = (move.target - move.source).norm() + (move.source - triangle[0]).norm() + capsule.core.norm() + capsule.radius;
    if (distance_from_prism(triangle, capsule.core, move.source) < capsule.radius - kTouching * scale) return 0;
    Entry entry(move, capsule.radius, kTouching * scale);
    visit_prism(
        triangle, capsule.core, [&](const Point& a, const Vector& u, const Vector& v, bool is_half) { entry.face(a, u, v, is_half); },
        [&](const Point& a, const Vector& along) { entry.cylinder(a, along); }, [&](const Point& centre) { entry.ball(centre); });
    return entry.first();
}

std::optional<double> first_contact_with_half_space(const Vector& normal, double offset, const Capsule& capsule, const Segment& move) {
    const double lowest = std::min(0.0, normal.dot(capsule.core)) - capsule.radius - offset;
    const double height = normal.dot(move.source) + lowest;
    const double rise = normal.dot(move.target - move.source);
    const double scale = (move.target - move.source).norm() + std::abs(offset) + capsule.core.norm() + capsule.radius;
    if (height < -kTouching * scale) return 0;
    if (rise >= 0 || height + rise > 0) return std::nullopt;
    return std::clamp(-height / rise, 0.0, 1.0);
}

}  // namespace palpate
