#include "planner/criteria.h"

#include <algorithm>
#include <cmath>

namespace palpate {

Criteria::Criteria(const Options& options)
    : epsilon_(options.epsilon),
      floor_(options.refinement_floor * options.epsilon),
      least_(floor_),
      sizing_(options.sizing),
      min_angle_(options.min_angle) {
    sizing_.smallest = options.sizing.smallest.value_or(2 * floor_);
    for (const RegionOfInterest& region : sizing_.regions) least_ = std::min(least_, region.size);
    if (options.tolerance) least_ = std::min(least_, options.spacing_min.value_or(*options.tolerance));
    if (sizing_.radii_of_curvature > 0) least_ = std::min(least_, *sizing_.smallest);
    // Seed facets, nearer than ε to each other, are where the shortest edges are.
    if (min_angle_ > 0) least_ = std::min(least_, kSeedSpacing * epsilon_);
}

double Criteria::size_at(const Point& p) const {
    double size = epsilon_;
    for (const RegionOfInterest& region : sizing_.regions) {
        const Point nearest = p.cwiseMax(region.box.min).cwiseMin(region.box.max);
        size = std::min(size, region.size + region.slope * (p - nearest).norm());
    }
    return size;
}

bool Criteria::is_too_flat(double ball_radius, double radius_of_curvature) const {
    return sizing_.radii_of_curvature > 0 && ball_radius > std::max(*sizing_.smallest, sizing_.radii_of_curvature * radius_of_curvature);
}

bool Criteria::is_skinny(const Point& a, const Point& b, const Point& c) const {
    if (min_angle_ <= 0) return false;
    const auto cosine = [](const Point& at, const Point& p, const Point& q) { return (p - at).normalized().dot((q - at).normalized()); };
    return std::max({cosine(a, b, c), cosine(b, c, a), cosine(c, a, b)}) > std::cos(min_angle_);
}

}  // namespace palpate
