#include "planner/inference/normal_cone.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Above this sine of its opening a first cone is not worth having.
constexpr double kWidest = 0.8;

// What a slab is wide, as a limit on <u, n>.
double half_width(double distance, double reach, double margin) { return distance / (2 * reach) + 2 * margin / distance; }

}  // namespace

Vector NormalCone::axis() const {
    Vector sum = Vector::Zero();
    for (const Vector& n : extremes()) sum += n;
    return sum.normalized();
}

bool NormalCone::begin(const Vector& b, const Vector& c, const Vector& outwards, double reach, double margin) {
    const double db = b.norm();
    const double dc = c.norm();
    const double wb = half_width(db, reach, margin);
    const double wc = half_width(dc, reach, margin);
    const Vector m = b.cross(c) / (db * dc);
    const double sine = m.norm();
    const double cosine = b.dot(c) / (db * dc);
    // The part of n in the plane of b and c is longest in a corner of the two slabs.
    const double across_squared = wb * wb + wc * wc + 2 * wb * wc * std::abs(cosine);
    if (!(across_squared < kWidest * kWidest * sine * sine)) return false;
    const double s = std::sqrt(across_squared) / sine;
    reference_ = m / sine;
    if (reference_.dot(outwards) < 0) reference_ = -reference_;
    // No possible normal may point away from where the probe came from, and then no mirrored one is possible.
    if (reference_.dot(outwards) <= s * outwards.norm()) return false;
    const Vector x = b / db;
    const Vector y = reference_.cross(x);
    const double t = s / std::sqrt(1 - s * s);
    count_ = 4;
    extremes_[0] = reference_ + t * (x + y);
    extremes_[1] = reference_ + t * (y - x);
    extremes_[2] = reference_ - t * (x + y);
    extremes_[3] = reference_ + t * (x - y);
    for (std::size_t k = 0; k < 4; ++k) extremes_[k].normalize();
    if (!narrow(b, reach, margin) || !narrow(c, reach, margin)) {
        count_ = 0;
        return false;
    }
    return true;
}

bool NormalCone::narrow(const Vector& b, double reach, double margin) {
    const double distance = b.norm();
    const double limit = half_width(distance, reach, margin);
    if (limit >= 1) return true;
    const Vector u = b / distance;
    return cut(u, limit) && cut(-u, limit);
}

// Leaves the normals with <u, n> <= limit. On the plane <n, reference> = 1 that is <u, n> <= limit |n|, and |n| is at most
// that of the longest extreme.
bool NormalCone::cut(const Vector& u, double limit) {
    std::array<double, kMaxExtremes> value{};
    double cosine = 1;
    for (std::size_t k = 0; k < count_; ++k) cosine = std::min(cosine, extremes_[k].dot(reference_));
    const double bound = limit / cosine;
    bool any_out = false;
    bool any_in = false;
    for (std::size_t k = 0; k < count_; ++k) {
        value[k] = u.dot(extremes_[k]) / extremes_[k].dot(reference_) - bound;
        (value[k] > 0 ? any_out : any_in) = true;
    }
    if (!any_out) return true;
    if (!any_in) return false;
    // A convex polygon has two changes of sign. One whose corners almost coincide may have more, by rounding: at most one at each.
    std::array<Vector, 2 * kMaxExtremes> kept;
    std::size_t n = 0;
    for (std::size_t k = 0; k < count_; ++k) {
        const std::size_t next = (k + 1) % count_;
        if (value[k] <= 0) kept[n++] = extremes_[k];
        if ((value[k] > 0) != (value[next] > 0)) {
            const Vector p = extremes_[k] / extremes_[k].dot(reference_);
            const Vector q = extremes_[next] / extremes_[next].dot(reference_);
            kept[n++] = (p + value[k] / (value[k] - value[next]) * (q - p)).normalized();
        }
    }
    // A cut that would leave too many corners is not made: the cone stays wider, and true.
    if (n > kMaxExtremes) return true;
    std::copy_n(kept.begin(), n, extremes_.begin());
    count_ = static_cast<std::uint8_t>(n);
    return true;
}

}  // namespace palpate
