// Ŝ grown as a front over S, from within the space beside its samples (planner/DESIGN.md, "Growing"): the part that needs a model of S
// between them, proven or plausible. What it leaves open is left to the walks (voronoi_walk.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "planner/certificate.h"
#include "planner/criteria.h"
#include "planner/inference/inference.h"
#include "planner/loop/advancing_front.h"
#include "planner/loop/audit.h"
#include "planner/loop/effort.h"
#include "planner/motion/near_travel.h"
#include "planner/motion/probe_head.h"
#include "planner/options.h"
#include "planner/plausibility/plausibility.h"
#include "planner/probe_surface.h"

namespace palpate {

class SurfaceGrowth {
public:
    // REQUIRES: options.inference() is not `none`. All arguments must outlive it.
    SurfaceGrowth(ProbedSpace& space, ProbeHead& head, const Options& options, const OracleTraits& traits, const Criteria& criteria,
                  const Observer& observer, Effort& effort);

    // A touch that is to become a sample.
    struct NewSample {
        Point position = Point::Zero();
        CellId near = 0;
        std::uint32_t touch = 0;
    };
    struct Step {
        std::optional<NewSample> sample{};
        std::optional<Point> met{};  // a touch of a place that was foretold
    };
    // One touch, wherever it helps most; nothing if none does. The caller inserts the sample, if there is one.
    std::optional<Step> step();

    // Touches a place where S is foretold, from outside along a normal there (unit). A sample if it keeps `spacing` (mm) from others.
    // `beside`: samples around.
    Step touch_foretold(const Point& place, const Vector& normal, const std::array<std::uint32_t, 3>& beside, double spacing);
    // Infers what it can of an edge that is about to be probed. True if a crossing is known now.
    bool infer(DirectedEdge e) { return front_.infer(e); }
    void note_insertion(const MaintainedDelaunay::Insertion& insertion, const Touch& touch);
    // Unit, outwards: of S at a sample, as the samples around show it.
    [[nodiscard]] Vector normal(std::uint32_t sample) const { return model_.normal(sample); }
    // S was touched there, from there, and it is no sample.
    void note_other_touch(const Point& at, const Point& from);
    // Samples from that one on were inserted by seeding.
    void note_seeds(std::size_t first);
    void note_crossing(DirectedEdge e) { front_.note_edges(e); }
    // S crosses the edge twice: balls between the two sheets are that small.
    void note_thin(DirectedEdge e);
    // Infers and notes everything afresh, and has touched what is too doubtful for the trust that was asked for. Linear time.
    void sweep();
    // Once nothing else is left to do: chooses inferred facets that the next steps touch anyway. False if there are none. Linear time.
    bool begin_audit();
    // Whether a facet lies on known solids, far from the object: what these show is right.
    [[nodiscard]] bool is_known(DirectedEdge e) const;
    // An inferred crossing where Ŝ is wrong: only a touch can say now.
    void distrust(DirectedEdge e);
    // The tool found an inferred crossing's edge free.
    void withdraw(DirectedEdge e, const Point& free);

    // Brings the tool near a node of the roadmap that was reached from outside the lenses, if that way is shorter.
    std::optional<Step> approach(NodeId goal, const std::array<std::uint32_t, 3>& corners);

    // If the bound was contradicted: lowers it and withdraws what rested on it. True if it was.
    bool settle_refutation();
    // That an inferred facet is right, as the samples around show by now.
    [[nodiscard]] double confidence(DirectedEdge e) const;
    [[nodiscard]] std::uint64_t audited() const { return audit_.touched(); }
    // About so many facets will be audited still.
    [[nodiscard]] std::uint64_t audits_left() const;
    // So many places of Ŝ are worth an audit.
    [[nodiscard]] std::size_t audit_quota() const;
    [[nodiscard]] ReachEvidence evidence() const;
    [[nodiscard]] std::size_t open_count() const { return front_.open_count(); }

private:
    template <typename Visit>
    void for_each_inferred(const Visit& visit) const {
        state_.for_each_edge([&](DirectedEdge e) {
            if (state_.recorded_state(e) == EdgeState::crossing && state_.crossing(e).inferred) visit(e);
        });
    }
    // Whether it asks for touches, or leaves all to the walks.
    [[nodiscard]] bool can_touch() const;
    [[nodiscard]] Step touch(const FrontTouch& asked);
    // The same where known solids answer: no motion.
    [[nodiscard]] Step look_up(const FrontTouch& asked);
    void note_barred_audit(const FrontTouch& asked, const NearTravel::Met& met);
    void note_audit(const FrontTouch& asked, const std::optional<ProbeHead::Answer>& contact);
    void note_evidence(const Refutation& refutation);
    // Takes back what is inferred there and infers what it still can.
    void reconsider_around(std::uint32_t sample);
    void lower_all(const Refutation& found);
    void learn_crossing(const FacetView& along, const ProbeHead::Answer& touched);
    // A touch becomes a sample, or a witness if it is too near to one. One that was not looked for may contradict lenses.
    Step take_from_way(const NearTravel::Met& met, const std::array<std::uint32_t, 3>& beside);
    Step take(const ProbeHead::Answer& touched, const std::array<std::uint32_t, 3>& beside, const std::optional<double>& spacing = {});

    ProbedSpace& space_;
    MaintainedDelaunay& state_;
    ProbeHead& head_;
    const Options& options_;
    const Criteria& criteria_;
    Effort& effort_;
    const std::unique_ptr<Inference> proof_;            // either this ...
    const std::unique_ptr<Plausibility> plausibility_;  // ... or that
    SurfaceModel& model_;                               // the one that there is
    AdvancingFront front_;
    NearTravel travel_;
    // Of those so far: not on walls around an area, which are no part of the object.
    [[nodiscard]] std::size_t counted_samples() const { return state_.sample_count() - wall_samples_; }

    Audit audit_;
    std::size_t wall_samples_ = 0;
    bool grows_;
    ReachEvidence evidence_;
};

}  // namespace palpate
