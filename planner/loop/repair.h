// What is wrong with Ŝ once all that can be reached is known, where a sample would help, and what is said of what stays
// wrong (planner/DESIGN.md, "Repair").
//
// May not live here: inserting and probing (probing_loop.h).
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "planner/certificate.h"
#include "planner/criteria.h"
#include "planner/delaunay/restricted_surface.h"
#include "planner/delaunay/surface_ball.h"
#include "planner/loop/effort.h"
#include "planner/loop/grid_cell.h"
#include "planner/loop/thin_places.h"
#include "planner/loop/thin_walls.h"
#include "planner/options.h"
#include "planner/surface_oracle.h"

namespace palpate {

class Repair {
public:
    // All must outlive it.
    Repair(const MaintainedDelaunay& state, const Options& options, const OracleTraits& traits, const Criteria& criteria,
           const ThinWalls& walls)
        : state_(state), options_(options), touch_error_(traits.touch_error), criteria_(criteria), walls_(walls) {}

    // The balls to refine, largest first: the largest at every defect of Ŝ, at touches that no facet uses, at edges that S crosses twice,
    // and where components are near each other that may be one. Each place is refined so often only: the calls count.
    [[nodiscard]] std::vector<SurfaceBall> balls(const RestrictedSurface& surface);

    // What stays wrong.
    struct Findings {
        std::vector<BadPlace> bad_places;
        std::vector<BadPlace> thin_places;      // that Ŝ leaves out without harm
        std::size_t unrepresented_touches = 0;  // samples that Ŝ does not use, at bad places
        std::size_t unresolved_places = 0;      // of the bad ones: O is thinner than samples show
        std::size_t torn_components = 0;        // pairs of components that may be one
    };
    [[nodiscard]] Findings findings(const RestrictedSurface& surface, const Topology& topology, const Effort& effort) const;

private:
    [[nodiscard]] bool is_worth_it(const SurfaceBall& ball);
    // Whether the user gave a ray to the sample.
    [[nodiscard]] bool is_vouched(std::uint32_t sample) const;
    // Of components of Ŝ that nobody vouches for and that are near another: the nearest samples. What joins them may pass between samples,
    // through a Voronoi face without meeting an edge.
    [[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> torn_apart(const RestrictedSurface& surface) const;
    [[nodiscard]] BadPlace named(const ThinPlace& place) const;
    [[nodiscard]] double finest() const { return options_.epsilon * options_.refinement_floor; }

    const MaintainedDelaunay& state_;
    const Options& options_;
    const double touch_error_;  // mm
    const Criteria& criteria_;
    const ThinWalls& walls_;
    std::map<std::uint32_t, int> repairs_;  // by sample
    std::map<GridCell, int> hopeless_;      // by cube of side ε
};

}  // namespace palpate
