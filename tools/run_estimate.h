// How much of a run is done, and how long the rest takes, from what its mesh covers by now.
#pragma once

#include <chrono>
#include <optional>

#include "planner/geometry.h"
#include "planner/progress.h"
#include "tools/terminal/time_left.h"

namespace palpate {

// Of all moments from half of a run on, the time that is left is within a third in 83 % on the bunny with walks, 55 to 84 % on the torus
// and 48 to 75 % on genus 2, whose fronts leave large holes that nobody can know the surface in; in up to 45 % only on the bunny with
// `adaptive`, which leaves the most costly facets, at creases, for its end.
class RunEstimate {
public:
    // `surface`: as it is by `now`, which never falls.
    void note(std::chrono::nanoseconds now, const Progress& progress, const TriangleMesh& surface);

    // In [0, 1).
    [[nodiscard]] double fraction_done(const Progress& progress) const;
    [[nodiscard]] const TimeLeft& time_left() const { return time_left_; }

private:
    std::optional<double> covered_;  // share of the surface
    double share_ = 0.0;             // of the facets that there will be
    TimeLeft time_left_;
};

}  // namespace palpate
