// A surface in space through a few touches, as the zero of an implicit spline.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "planner/geometry.h"

namespace palpate {

// With lengths in units of a scale h, f(x) = Σ cᵢ |x − xᵢ|³ + d₀ + d·x + x·D x / 2 is what bends least from a quadric (a polyharmonic
// spline of Duchon) of the functions that are 0 at touches and ±kOffset at points so far out and in along the normals there. The diagonal
// of the system has a ridge for what is not exact: normals that are estimated, and touches that err.
class LocalSpline {
public:
    struct Site {
        Point point = Point::Zero();
        Vector normal = Vector::UnitZ();  // unit, outwards
        double error = 0.0;               // mm: how far the touch may be from the surface
        bool has_normal = true;           // points beside it are wanted
    };
    static constexpr std::size_t kFewestSites = 4;
    // Three rings of a regular mesh are 37. More cost time by their cube.
    static constexpr std::size_t kMostSites = 40;

    // Through `sites`, of which the first is the middle, and the `near` first are it and those around it. `scale`: mm, > 0. Nothing where
    // there are too few, or where they do not determine it. D is 0 where `trend` says so, and where touches are few or too coarse for it.
    enum class Trend { plane, quadric };
    [[nodiscard]] static std::optional<LocalSpline> fit(std::span<const Site> sites, std::size_t near, double scale, Trend trend);

    struct Jet {
        double value = 0.0;                // mm: about the distance to the surface, positive outside
        Vector gradient = Vector::Zero();  // about a unit vector
    };
    [[nodiscard]] Jet jet(const Point& p) const;
    struct SecondJet : Jet {
        Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();  // 1/mm
    };
    [[nodiscard]] SecondJet second_jet(const Point& p) const;

    // mm: how far the middle touch is from what the others predict, it and its normal left out; and what those predict that are not near.
    // The rate at which that falls tells how much is left between touches. Infinite where those do not determine a spline.
    [[nodiscard]] double surprise() const { return surprise_; }
    [[nodiscard]] double far_surprise() const { return far_surprise_; }
    [[nodiscard]] double scale() const { return scale_; }

private:
    Point origin_ = Point::Zero();
    double scale_ = 1.0;
    using Column = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3 * kMostSites, 1>;  // on the stack
    Eigen::Array<double, Eigen::Dynamic, 3> centres_;    // from the origin, in units of the scale, as all that follows
    Eigen::ArrayXd weights_;                             // c
    Eigen::Vector4d plane_ = Eigen::Vector4d::Zero();    // d₀, d
    Eigen::Matrix3d quadric_ = Eigen::Matrix3d::Zero();  // D
    double surprise_ = 0.0;                              // mm
    double far_surprise_ = 0.0;                          // mm
};

}  // namespace palpate
