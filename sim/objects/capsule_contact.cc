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

// The parallelogram a + s u + t v with s, t in [0, 1], or its half with s + t <= 1.
struct Face {
    Point a = Point::Zero();
    Vector u = Vector::Zero();
    Vector v = Vector::Zero();
    bool is_half = false;
    double area = 0.0;
    Vector normal = Vector::Zero();  // unit

    // Nothing if it has no area.
    [[nodiscard]] static std::optional<Face> of(const Point& a, const Vector& u, const Vector& v, bool is_half) {
        const Vector across = u.cross(v);
        const double area = across.norm();
        if (area <= kSlack * u.norm() * v.norm()) return std::nullopt;
        return Face{a, u, v, is_half, area, across / area};
    }
    [[nodiscard]] double height(const Point& p) const { return normal.dot(p - a); }
    // Whether p is above or below it; `slack` beyond its ends counts.
    [[nodiscard]] bool is_level_with(const Point& p, double slack) const {
        const Vector at = p - a;
        const double s = at.cross(v).dot(normal) / area;
        const double t = u.cross(at).dot(normal) / area;
        if (s < -slack || t < -slack) return false;
        return is_half ? s + t <= 1 + slack : s <= 1 + slack && t <= 1 + slack;
    }
};

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

    void face(const Face& face) {
        const double height = face.height(from_);
        const double rise = face.normal.dot(way_);
        // From within the slab the face is entered beside it: through its edges.
        if (std::abs(height) < radius_ - touching_ || height * rise >= 0) return;
        const double t = std::max(0.0, (std::copysign(radius_, height) - height) / rise);
        if (t <= 1 && face.is_level_with(from_ + t * way_, kSlack)) note(t);
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

// Visits what bounds the prism K ⊕ −[0, core].
template <typename VisitFace, typename VisitEdge, typename VisitCorner>
void visit_prism(const std::array<Point, 3>& k, const Vector& core, const VisitFace& visit_face, const VisitEdge& visit_edge,
                 const VisitCorner& visit_corner) {
    const bool has_core = !core.isZero(0);
    const auto visit_if_any = [&](const std::optional<Face>& face) {
        if (face) visit_face(*face);
    };
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector side = k.at((i + 1) % 3) - k.at(i);
        visit_corner(k.at(i));
        visit_edge(k.at(i), side);
        if (!has_core) continue;
        visit_corner(k.at(i) - core);
        visit_edge(k.at(i) - core, side);
        visit_edge(k.at(i), Vector(-core));
        visit_if_any(Face::of(k.at(i), side, -core, false));
    }
    visit_if_any(Face::of(k[0], k[1] - k[0], k[2] - k[0], true));
    if (has_core) visit_if_any(Face::of(k[0] - core, k[1] - k[0], k[2] - k[0], true));
}

// mm: from the prism; 0 within.
double distance_from_prism(const std::array<Point, 3>& k, const Vector& core, const Point& p) {
    // Within, if the line through p along the core passes through the triangle there.
    const std::optional<Face> triangle = Face::of(k[0], k[1] - k[0], k[2] - k[0], true);
    const double rise = triangle ? triangle->normal.dot(core) : 0;
    if (rise != 0) {
        const double along = -triangle->height(p) / rise;
        if (along >= 0 && along <= 1 && triangle->is_level_with(p + along * core, 0)) return 0;
    }
    double nearest = std::numeric_limits<double>::infinity();
    visit_prism(
        k, core,
        [&](const Face& face) {
            if (face.is_level_with(p, 0)) nearest = std::min(nearest, std::abs(face.height(p)));
        },
        [&](const Point& a, const Vector& along) {
            nearest = std::min(nearest, distance_to({a, a + along}, p));
        },
        [](const Point&) {});
    return nearest;
}

}  // namespace

std::optional<double> first_contact(const std::array<Point, 3>& triangle, const Capsule& capsule, const Segment& move) {
    const double scale = (move.target - move.source).norm() + (move.source - triangle[0]).norm() + capsule.core.norm() + capsule.radius;
    if (distance_from_prism(triangle, capsule.core, move.source) < capsule.radius - kTouching * scale) return 0;
    Entry entry(move, capsule.radius, kTouching * scale);
    visit_prism(
        triangle, capsule.core, [&](const Face& face) { entry.face(face); },
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
