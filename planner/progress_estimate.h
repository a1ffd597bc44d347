// How far a run is: the share of the samples that it will probably need.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "planner/touch.h"

namespace palpate {

// Of a run over a body of which only the bounding box (mm) is known: a guess, within a factor of two mostly.
[[nodiscard]] double expected_samples(const Vector& size, double epsilon);

// By what a tolerance multiplies these samples: a guess, within a factor of three and a half on the examples, as shapes differ.
[[nodiscard]] double expected_refinement(double tolerance, double epsilon);

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
