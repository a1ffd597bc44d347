// One run of the planner: what is known, the probe head, walks and criteria wired into the loop of thesis 8.2.
#pragma once

#include <optional>
#include <queue>
#include <set>
#include <string>
#include <vector>

#include "planner/criteria.h"
#include "planner/delaunay/maintained_delaunay.h"
#include "planner/delaunay/restricted_surface.h"
#include "planner/delaunay/surface_ball.h"
#include "planner/loop/earlier_touches.h"
#include "planner/loop/effort.h"
#include "planner/loop/facet_quality.h"
#include "planner/loop/repair.h"
#include "planner/loop/seeding.h"
#include "planner/loop/surface_growth.h"
#include "planner/loop/thin_walls.h"
#include "planner/loop/voronoi_walk.h"
#include "planner/motion/probe_head.h"
#include "planner/motion/probed_space.h"
#include "planner/probe_surface.h"
#include "planner/progress_estimate.h"
#include "planner/tolerance/tolerance_search.h"

namespace palpate {

class ProbingLoop {
public:
    ProbingLoop(SurfaceOracle& oracle, const Surroundings& surroundings, const Options& options, const Observer& observer);

    // Until nothing is left to probe, refine or repair, and home if that is asked for. Call once.
    void execute();
    // Its beginning alone: first touches and their facets. Throws SeedError. Call once, and nothing else.
    void seed();

    [[nodiscard]] const ProbedSpace& space() const { return space_; }
    [[nodiscard]] Result result();

private:
    void probe_all();
    // Probes the edge, unless too much led to nothing there.
    void explore(DirectedEdge e);
    void probe(DirectedEdge e);
    [[nodiscard]] std::optional<ProbeHead::Expected> known_crossing(DirectedEdge e) const;
    void on_contact(DirectedEdge e);
    void note_touches();
    // A probe of that facet's dual edge took it out of Ŝ.
    void note_lost(const std::array<std::uint32_t, 3>& facet, DirectedEdge e);
    // A bad ball: waits until it is the worst, or becomes a sample at once.
    void note_bad(DirectedEdge crossing);
    void insert_bad(DirectedEdge crossing);
    void insert(DirectedEdge crossing, Touch::Role role, double spacing);
    void add_sample(const Point& p, CellId near, std::uint32_t touch, Touch::Role role);
    // The sample that a step of the front found, if it found one.
    void add_sample_of(const SurfaceGrowth::Step& step);
    // Some of what an earlier run touched, to see that the object is where it was.
    void touch_earlier_places();
    // One step of the front. False if it has nothing to do.
    bool grow();
    // The thesis' refinement: the centre of the largest bad ball becomes a sample. False if there is none.
    bool insert_worst();
    // Explores around samples that no facet of Ŝ uses: a component that was only touched, or a seed whose facet failed.
    bool explore_unrepresented();
    // Touches a facet at the first of those samples that allows it. False if none does.
    bool facet_unrepresented(const std::vector<std::uint32_t>& samples, bool seeds_only);
    // planner/DESIGN.md, "Repair": refines the largest ball at every defect of Ŝ. False if there is none to refine.
    bool repair_defects();
    // Refines the facets of a closed Ŝ that do not fulfil the criteria of sizing and angles. False if there are none.
    bool refine_facets();
    // Touches where the curved surface is foretold to be beyond the tolerance; then places at random. False if nothing is left to touch.
    bool approach_tolerance();
    void touch_places(std::vector<ToleranceSearch::Place> places, bool is_audit);
    [[nodiscard]] SampledSurface sampled_surface() const;
    [[nodiscard]] std::vector<BadFacet> bad_facets(const RestrictedSurface& surface) const;
    // Inserts the ball's centre, or has it touched first if it was inferred. False if it is gone.
    bool refine(const SurfaceBall& ball, Touch::Role role, double spacing);
    // About how many touches the tolerance takes still.
    [[nodiscard]] std::uint64_t tolerance_left(double fraction_done) const;
    [[nodiscard]] RunView view() const;
    void report();

    const Options& options_;
    const OracleTraits traits_;
    const Observer& observer_;
    const Criteria criteria_;
    ProbedSpace space_;
    MaintainedDelaunay& state_;  // of space_
    ThinWalls walls_;
    Effort effort_;
    Repair repair_;
    ProbeHead head_;
    VoronoiWalk walk_;
    std::optional<SurfaceGrowth> growth_;  // with a bound on the reach
    std::optional<EarlierTouches> earlier_;
    std::optional<ToleranceSearch> tolerance_;
    bool audited_tolerance_ = false;
    std::uint64_t touched_before_ = 0;  // when places for the tolerance were asked for last
    std::priority_queue<SurfaceBall> bad_;
    std::set<std::uint32_t> faceted_;  // first touches that were given a seed facet, or for which that was tried
    std::size_t max_samples_ = 0;
    ProgressEstimate progress_;
    std::size_t touches_noted_ = 0;
    std::string stopped_by_;  // the budget that was used up
};

}  // namespace palpate
