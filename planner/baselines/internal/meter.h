// What baselines share: an account of what they did, and lines to probe along.
#pragma once

#include <optional>
#include <random>
#include <vector>

#include "planner/cost.h"
#include "planner/geometry.h"
#include "planner/surface_oracle.h"
#include "planner/surroundings.h"

namespace palpate {

// The oracle with an account of what it did.
class Meter {
public:
    explicit Meter(SurfaceOracle& oracle) : oracle_(oracle), at_(oracle.position()) {}

    void travel(const std::vector<Point>& path);
    // Where S was met.
    std::optional<Point> probe(const Point& target);

    [[nodiscard]] const Point& at() const { return at_; }
    [[nodiscard]] const Cost& cost() const { return cost_; }

private:
    SurfaceOracle& oracle_;
    Cost cost_;
    Point at_;
};

// Of all lines that meet the ball around ω one of those that meet ω, and of that what lies in ω.
[[nodiscard]] Segment random_chord(const Surroundings& surroundings, std::mt19937_64& random);

}  // namespace palpate
