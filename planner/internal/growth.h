// Ŝ grown as a front over S, from within the exterior lenses of its samples (DESIGN section 6): the loop's part that needs a bound
// on the reach. What it leaves open is left to `exploration`.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/certificate.h"
#include "planner/criteria.h"
#include "planner/internal/effort.h"
#include "planner/internal/front.h"
#include "planner/internal/inference.h"
#include "planner/internal/pilot.h"
#include "planner/internal/tool.h"
#include "planner/options.h"
#include "planner/prober.h"

namespace palpate {

class Growth {
public:
    // REQUIRES: options.reach, unless the strategy infers adaptively. All arguments must outlive it.
    Growth(MaintainedDelaunay& state, Tool& tool, const Workspace& workspace, const Options& options, const Criteria& criteria,
           const Observer& observer, Effort& effort);

    // A touch that is to become a sample.
    struct NewSample {
        Point position = Point::Zero();
        CellId near = 0;
        std::uint32_t touch = 0;
    };
    struct Step {
        std::optional<NewSample> sample;
    };
    // One touch, wherever it helps most; nothing if none does. The caller inserts the sample, if there is one.
    std::optional<Step> step();

    // Infers what it can of an edge that is about to be probed. True if a crossing is known now.
    bool infer(DirectedEdge e) { return front_.infer(e); }
    void note_insertion(const MaintainedDelaunay::Insertion& insertion, const Touch& touch);
    // Samples from that one on were inserted by seeding.
    void note_seeds(std::size_t first);
    void note_crossing(DirectedEdge e) { front_.note_edges(e); }
    // S crosses the edge twice: balls between the two sheets are that small.
    void note_thin(DirectedEdge e);
    // Infers and notes everything afresh. Linear time.
    void sweep() { front_.sweep(); }
    // An inferred crossing where Ŝ is wrong: only a touch can say now.
    void distrust(DirectedEdge e);
    // The tool found an inferred crossing's edge free.
    void withdraw(DirectedEdge e, const Point& free);

    // Brings the tool near a node of the roadmap that was reached from outside the lenses, if that way is shorter.
    std::optional<Step> approach(NodeId goal, const std::array<std::uint32_t, 3>& corners);

    // If the bound was contradicted: lowers it and withdraws what rested on it. True if it was.
    bool settle_refutation();
    [[nodiscard]] ReachEvidence evidence() const;
    [[nodiscard]] std::size_t open_count() const { return front_.open_count(); }

private:
    [[nodiscard]] Step touch(const FrontTouch& asked);
    void note_audit(const FrontTouch& asked, const std::optional<Tool::Answer>& contact);
    void note_evidence(const Refutation& refutation);
    void lower(std::uint32_t sample, double share);
    void lower_all(const Refutation& found);
    void learn_crossing(const FacetView& along, const Tool::Answer& touched);
    // A touch becomes a sample, or a witness if it is too near to one. One that was not looked for may contradict lenses.
    Step take_from_way(const Pilot::Met& met, const std::array<std::uint32_t, 3>& beside);
    Step take(const Tool::Answer& touched, const std::array<std::uint32_t, 3>& beside);

    MaintainedDelaunay& state_;
    Tool& tool_;
    const Options& options_;
    const Criteria& criteria_;
    Effort& effort_;
    Inference inference_;
    Front front_;
    Pilot pilot_;
    bool grows_;
    ReachEvidence evidence_;
};

}  // namespace palpate
