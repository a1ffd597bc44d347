// Ŝ grown as a front over S, from within the exterior lenses of its samples (DESIGN section 6): the loop's part that needs a bound
// on the reach. What it leaves open is left to `exploration`.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/certificate.h"
#include "planner/criteria.h"
#include "planner/internal/free_space.h"
#include "planner/internal/front.h"
#include "planner/internal/inference.h"
#include "planner/internal/tool.h"
#include "planner/options.h"
#include "planner/prober.h"

namespace palpate {

class Growth {
public:
    // REQUIRES: options.reach. All arguments must outlive it.
    Growth(MaintainedDelaunay& state, Tool& tool, const Workspace& workspace, const Options& options, const Criteria& criteria,
           const Observer& observer);

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
    bool infer(DirectedEdge e);
    void note_insertion(const MaintainedDelaunay::Insertion& insertion, const Touch& touch);
    void note_crossing(DirectedEdge e) { front_.note_edges(e); }
    // Infers and notes everything afresh. Linear time.
    void sweep() { front_.sweep(); }
    // An inferred crossing where Ŝ is wrong: only a touch can say now.
    void distrust(DirectedEdge e);
    // The tool found an inferred crossing's edge free.
    void withdraw(DirectedEdge e, const Point& free);

    // Brings the tool near a node of the roadmap that was reached from outside the lenses, if that way is shorter.
    void approach(NodeId goal, const std::array<std::uint32_t, 3>& corners);

    // If the bound was contradicted: lowers it and withdraws what rested on it. True if it was.
    bool settle_refutation();
    [[nodiscard]] ReachEvidence evidence() const;
    [[nodiscard]] std::size_t open_count() const { return front_.open_count(); }

private:
    // A place of the roadmap in a lens.
    struct Door {
        NodeId node = kNoNode;
        std::uint32_t home = kNone;
    };
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    // A place in the sample's lens, on the way of the probe that touched it; none if that way is too flat.
    [[nodiscard]] Door door(std::uint32_t sample);
    bool go_to(const Point& start, std::uint32_t home);
    bool follow(const FreeSpace::Way& way);
    // From a touch back on the way to it, into a lens: no way may lead through a place on S.
    void lift();
    [[nodiscard]] std::optional<HoverPlace> place() const;
    void learn(const FrontTouch& asked, NodeId start, NodeId contact, std::uint32_t touch);

    MaintainedDelaunay& state_;
    Tool& tool_;
    const Options& options_;
    const Criteria& criteria_;
    Inference inference_;
    Front front_;
    FreeSpace free_space_;
    bool grows_;
    std::vector<Door> doors_;        // by sample, as far as they were needed
    NodeId at_ = kNoNode;            // where this left the tool, ...
    std::uint32_t home_ = kNone;     // ... and the sample in whose lens that is
    Door last_start_;                // of its last probe, ...
    NodeId last_contact_ = kNoNode;  // ... and where that touched S, if it did
    ReachEvidence evidence_;
};

}  // namespace palpate
