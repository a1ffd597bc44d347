// How far a run is: the share of the samples that it will probably need.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "planner/touch.h"

namespace palpate {

class ProgressEstimate {
public:
    // `epsilon`: mm.
    explicit ProgressEstimate(double epsilon) : epsilon_(epsilon) {}

    // In [0, 1), never falling. `touches` are all so far: the same and more with every call.
    [[nodiscard]] double fraction(const std::vector<Touch>& touches, std::size_t samples);

private:
    const double epsilon_;
    Point min_ = Point::Constant(std::numeric_limits<double>::infinity());  // of the touches seen
    Point max_ = -min_;
    std::size_t seen_ = 0;
    double fraction_ = 0.0;
};

}  // namespace palpate
