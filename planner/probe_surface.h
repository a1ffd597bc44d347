// Blind surface approximation: the whole run (Oudot 2005, chapter 8; planner/DESIGN.md).
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "planner/certificate.h"
#include "planner/check_options.h"
#include "planner/cost.h"
#include "planner/options.h"
#include "planner/progress.h"
#include "planner/surface_oracle.h"
#include "planner/surroundings.h"
#include "planner/topology.h"
#include "planner/touch.h"

namespace palpate {

struct Result {
    TriangleMesh mesh;                     // Ŝ, oriented outwards; its points are samples
    std::vector<std::uint32_t> sample_of;  // by point of the mesh
    std::vector<double> ball_radii;        // mm, by triangle: of its smallest surface Delaunay ball
    std::vector<Segment> dual_edges;       // by triangle, inside ω, from outside O
    // By triangle: that S crosses its dual edge within the ball, or passes it so near that it is a flip; 1 where a touch or a proof shows
    // it, else as likely as the samples around make it (planner/DESIGN.md, "Plausibility").
    std::vector<double> confidences;
    Topology topology;  // of the mesh
    Certificate certificate;
    std::vector<BadPlace> bad_places;   // empty unless the certificate is incomplete
    std::vector<BadPlace> thin_places;  // walls and sharp edges that the mesh leaves out, without harm to its topology
    Cost cost;
    std::vector<Touch> touches;  // every contact, in order
    std::optional<Area> area;    // that alone was probed, if one was given
    // By point of the mesh: 1 on a wall around the area that alone was probed, or behind one: no place of the object. Empty: no area was
    // given.
    std::vector<std::uint8_t> is_outside;
    std::size_t samples = 0;                       // |E|, whether a facet uses them or not
    std::size_t known_samples = 0;                 // of those: on known solids, not touched
    std::optional<DeviationEvidence> deviation{};  // with a tolerance
    std::optional<EarlierEvidence> earlier{};      // with touches of an earlier run
    double max_ball_radius = 0.0;                  // mm: of the facets that touches and proofs put into the mesh
    double max_plausible_ball_radius = 0.0;        // mm: of the others

    // Lower bounds for any such sample: N >= 2·area/(3√3·ε²), and (N - 1)·ε for the way through N samples that are ε apart.
    double lower_bound_samples = 0.0;
    double lower_bound_displacement = 0.0;  // mm
};

// A run as it stands. Valid during the call that it is given to.
struct RunView {
    std::span<const Touch> touches;         // every contact, in order
    std::span<const Point> samples;         // E
    std::function<TriangleMesh()> surface;  // makes Ŝ, as it is by now: linear time
};

// Who watches a run. Any may be empty. Watching changes nothing.
struct Observer {
    std::function<void(const Progress&, const RunView&)> on_progress;  // after every probe
    std::function<void(const RunView&)> on_sample;                     // after every sample that is not a seed
    std::function<void(double way_mm)> on_home;                        // before the tool goes back to where it began
    // After every crossing that was inferred: S is met between `near`, which is free, and `far`, inside O.
    std::function<void(const Point& near, const Point& far)> on_inference;
};

// Probes until every facet of Ŝ fulfils the criteria. Throws SeedError and ContradictionError (planner/errors.h),
// std::invalid_argument as check_options does or on a start of the tool inside ω, and what the oracle throws.
[[nodiscard]] Result probe_surface(SurfaceOracle& oracle, const Surroundings& surroundings, const Options& options,
                                   const Observer& observer = {});

// Touches seeds as probe_surface does first, with the same answers, and ends there: would it begin? Throws what that throws.
void check_seeds(SurfaceOracle& oracle, const Surroundings& surroundings, const Options& options);

// Lower bound on the number of samples of a surface of that area (mm²) whose balls are at most epsilon (mm): the
// density of a hexagonal lattice of circumradius epsilon.
[[nodiscard]] double lower_bound_samples(double area, double epsilon);

}  // namespace palpate
