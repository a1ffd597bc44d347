#include "planner/curved/internal/blend.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr int kSteps = 12;
// Of the farthest that a place may go: steps that are smaller lead there.
constexpr double kLastStep = 1e-4;
// A spline's gradient is about a unit vector. Where it is not, or looks elsewhere, the spline says nothing.
constexpr double kLeastSlope = 0.3;
// Of a crease: the least sine between its sides.
constexpr double kLeastSine = 0.17;

}  // namespace

Blend::Blend(std::array<Share, 3> shares) : shares_(shares) {
    double sum = 0;
    is_valid_ = true;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(shares_[k].share > 0)) continue;
        is_valid_ &= shares_[k].surface->spline.has_value() && !shares_[k].side->normal.isZero();
        weights_[k] = std::pow(shares_[k].share, 3);
        sum += weights_[k];
        direction_ += shares_[k].share * shares_[k].side->normal;
    }
    for (double& w : weights_) w /= sum;
    is_valid_ &= direction_.norm() > 0.1;
    if (is_valid_) direction_.normalize();
}

LocalSpline::Jet Blend::jet(const Point& p) const {
    LocalSpline::Jet sum;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(weights_[k] > 0)) continue;
        const LocalSpline::Jet one = shares_[k].surface->spline->jet(p);
        sum.value += weights_[k] * one.value;
        sum.gradient += weights_[k] * one.gradient;
    }
    return sum;
}

std::optional<BlendedPlace> Blend::project(const Point& from, double most) const {
    double t = 0;
    for (int step = 0; step < kSteps; ++step) {
        const LocalSpline::Jet here = jet(from + t * direction_);
        const double slope = here.gradient.dot(direction_);
        if (!(slope > kLeastSlope)) return std::nullopt;
        const double by = -here.value / slope;
        t += by;
        if (!(std::abs(t) <= most)) return std::nullopt;
        // The error that is left is about the square of the step.
        if (std::abs(by) <= kLastStep * most) return at(from + t * direction_);
    }
    return std::nullopt;
}

BlendedPlace Blend::at(const Point& p) const {
    BlendedPlace place{p, direction_, {0, 0}};
    LocalSpline::SecondJet sum;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(weights_[k] > 0)) continue;
        const LocalSpline::SecondJet one = shares_[k].surface->spline->second_jet(p);
        sum.gradient += weights_[k] * one.gradient;
        sum.hessian += weights_[k] * one.hessian;
    }
    const double norm = sum.gradient.norm();
    if (!(norm > kLeastSlope)) return place;
    place.normal = sum.gradient / norm;
    // The shape operator in two axes of the tangent plane.
    const Vector u = place.normal.unitOrthogonal();
    const Vector w = place.normal.cross(u);
    const double uu = u.dot(sum.hessian * u);
    const double uw = u.dot(sum.hessian * w);
    const double ww = w.dot(sum.hessian * w);
    const double mean = (uu + ww) / (2 * norm);
    const double apart = std::hypot((uu - ww) / 2, uw) / norm;
    place.curvature = {mean + apart, mean - apart};
    return place;
}

std::optional<Point> crease_place(const Blend& one, const Blend& other, const Point& from, double most) {
    Point p = from;
    for (int step = 0; step < kSteps; ++step) {
        const LocalSpline::Jet f = one.jet(p);
        const LocalSpline::Jet g = other.jet(p);
        // The least way to where both tangent planes are met: a g₁ + b g₂.
        const double ff = f.gradient.squaredNorm();
        const double gg = g.gradient.squaredNorm();
        const double fg = f.gradient.dot(g.gradient);
        const double determinant = ff * gg - fg * fg;
        if (!(ff > kLeastSlope * kLeastSlope && gg > kLeastSlope * kLeastSlope && determinant > kLeastSine * kLeastSine * ff * gg))
            return std::nullopt;
        const double a = (-f.value * gg + g.value * fg) / determinant;
        const double b = (-g.value * ff + f.value * fg) / determinant;
        const Vector by = a * f.gradient + b * g.gradient;
        p += by;
        if (!((p - from).norm() <= most)) return std::nullopt;
        if (by.norm() <= kLastStep * most) return p;
    }
    return std::nullopt;
}

}  // namespace palpate
