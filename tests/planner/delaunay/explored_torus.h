// A triangulation of samples of a torus or sphere, with every edge that can be reached probed on the surface in closed form.
#pragma once

#include <optional>
#include <vector>

#include "planner/motion/probed_space.h"
#include "tests/planner/torus.h"

namespace palpate {

class ExploredTorus {
public:
    ExploredTorus(const Torus& torus, const std::vector<Point>& samples)
        : torus_(torus), space_(Region(Ball{Point::Zero(), 2 * (torus.major + torus.minor)})) {
        state().initialise(samples);
        for (bool asked = true; asked;) {
            asked = false;
            for_each_edge([&](DirectedEdge e) {
                if (!state().is_reachable(e) || state().state(e) != EdgeState::unknown) return;
                probe(e);
                asked = true;
            });
        }
    }

    [[nodiscard]] MaintainedDelaunay& state() { return space_.delaunay(); }
    [[nodiscard]] const Torus& torus() const { return torus_; }

    template <typename Visit>
    void for_each_edge(const Visit& visit) {
        for (CellId cell = 0; cell < state().cell_slots(); ++cell) {
            for (int i = 0; i < 4; ++i) {
                if (state().is_live(cell)) visit(DirectedEdge{cell, i});
            }
        }
    }

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
        const EdgeSpan along = *state().span(e);
        const NodeId start = space_.start_of(e, along);
        const Destination end = space_.end_of(e, along);
        Roadmap& roadmap = space_.roadmap();
        if (const auto hit = torus_.first_hit(roadmap.at(start), end.position)) {
            space_.learn_contact(e, start, roadmap.add(start, *hit), touches_++);
        } else {
            space_.learn_clear(e, start, roadmap.add(start, end));
        }
    }

    const Torus torus_;
    ProbedSpace space_;
    std::uint32_t touches_ = 0;
};

}  // namespace palpate
