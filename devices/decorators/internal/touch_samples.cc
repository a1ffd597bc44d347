#include "devices/decorators/internal/touch_samples.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace palpate {

double TouchSamples::range() const {
    assert(!places_.empty());
    const auto [low, high] = std::ranges::minmax(places_);
    return high - low;
}

double TouchSamples::median() const {
    assert(!places_.empty());
    std::vector<double> sorted = places_;
    std::ranges::sort(sorted);
    const std::size_t middle = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[middle] : sorted[middle - 1] + (sorted[middle] - sorted[middle - 1]) / 2;
}

double TouchSamples::drop_farthest() {
    const double middle = median();
    // Two places are equally far from their mean, whatever rounding says.
    const auto farthest = places_.size() == 2
                              ? places_.begin()
                              : std::ranges::max_element(places_, {}, [&](double place) { return std::abs(place - middle); });
    const double dropped = *farthest;
    places_.erase(farthest);
    return dropped;
}

}  // namespace palpate
