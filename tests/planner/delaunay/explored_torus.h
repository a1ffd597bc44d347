// A triangulation of samples of a torus or sphere, with every edge that can be reached probed on the surface in closed form.
#pragma once

#include <algorithm>
#include <vector>

#include "planner/motion/probed_space.h"
#include "tests/planner/delaunay/probe_edge.h"
#include "tests/planner/torus.h"

namespace palpate {

class ExploredTorus {
public:
    ExploredTorus(const Torus& torus, const std::vector<Point>& samples)
        : torus_(torus), space_(Region(Ball{Point::Zero(), 2 * (torus.major + torus.minor)})) {
        state().initialise(samples);
        for (bool asked = true; asked;) {
            asked = false;
            state().for_each_edge([&](DirectedEdge e) {
                if (!state().is_reachable(e) || state().state(e) != EdgeState::unknown) return;
                probe(e);
                asked = true;
            });
        }
    }

    [[nodiscard]] MaintainedDelaunay& state() { return space_.delaunay(); }
    [[nodiscard]] const Torus& torus() const { return torus_; }

    // Samples that are at least so far apart (mm), as many as there is room for.
    [[nodiscard]] static std::vector<Point> spread(const Torus& torus, double spacing, Random& random) {
        std::vector<Point> samples;
        for (int failed = 0; failed < 1000;) {
            const Point p = torus.random_place(random).point;
            const bool fits = std::ranges::all_of(samples, [&](const Point& q) { return (p - q).norm() > spacing; });
            failed = fits ? 0 : failed + 1;
            if (fits) samples.push_back(p);
        }
        return samples;
    }

private:
    void probe(DirectedEdge e) {
        (void)probe_edge(
            space_, e, [this](const Point& from, const Point& to) { return torus_.first_hit(from, to); }, touches_);
    }

    const Torus torus_;
    ProbedSpace space_;
    std::uint32_t touches_ = 0;
};

}  // namespace palpate
