#include "planner/progress_estimate.h"

#include <algorithm>

#include "planner/probe_surface.h"

namespace palpate {
namespace {

// A typical surface has about this share of the area of its bounding box, ...
constexpr double kAreaPerBox = 0.6;
// ... and a finished sample about this many times the samples of the hexagonal bound.
constexpr double kSamplesPerBound = 1.75;
// An estimate is never the end.
constexpr double kAlmostDone = 0.99;

}  // namespace

double ProgressEstimate::fraction(const std::vector<Touch>& touches, std::size_t samples) {
    for (; seen_ < touches.size(); ++seen_) {
        min_ = min_.cwiseMin(touches[seen_].position);
        max_ = max_.cwiseMax(touches[seen_].position);
    }
    const Vector size = max_ - min_;
    const double area = kAreaPerBox * 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    const double expected = kSamplesPerBound * lower_bound_samples(area, epsilon_);
    const double fraction = expected > 0 ? static_cast<double>(samples) / expected : 0;
    return fraction_ = std::max(fraction_, std::min(fraction, kAlmostDone));
}

}  // namespace palpate
