#include "planner/progress_estimate.h"

#include <algorithm>
#include <cmath>

#include "planner/probe_surface.h"

namespace palpate {
namespace {

// A typical surface has about this share of the area of its bounding box, ...
constexpr double kAreaPerBox = 0.6;
// ... and a finished sample about this many times the samples of the hexagonal bound: 1.2 to 1.6 on the examples.
constexpr double kSamplesPerBound = 1.35;
// An estimate is never the end.
constexpr double kAlmostDone = 0.99;

}  // namespace

double expected_samples(const Vector& size, double epsilon) {
    const double area = kAreaPerBox * 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    return kSamplesPerBound * lower_bound_samples(area, epsilon);
}

double expected_refinement(double tolerance, double epsilon) {
    // Torus, bunny, rounded box and genus 2, epsilon 3 to 250 times the tolerance: 1.5 to 8.
    constexpr double kExponent = 0.4;
    return std::max(1.0, std::pow(epsilon / tolerance, kExponent));
}

double ProgressEstimate::fraction(const std::vector<Touch>& touches, std::size_t samples) {
    for (; seen_ < touches.size(); ++seen_) {
        min_ = min_.cwiseMin(touches[seen_].position);
        max_ = max_.cwiseMax(touches[seen_].position);
    }
    const double expected = expected_samples(max_ - min_, epsilon_);
    const double fraction = expected > 0 ? static_cast<double>(samples) / expected : 0;
    return fraction_ = std::max(fraction_, std::min(fraction, kAlmostDone));
}

}  // namespace palpate
