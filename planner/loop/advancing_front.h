// Where to touch next so that Ŝ grows over S from its open edges (planner/DESIGN.md, "Growing").
//
// An open edge is a Delaunay edge with one facet of Ŝ. The facets around it are looked at first: one that S must cross, as lenses
// show, closes it without a touch. If S crosses one of them within a small ball but lenses cannot tell which, its dual edge
// is probed from within the lens. Otherwise a new sample is touched ahead of the edge, where it continues the hexagonal lattice of the
// samples around as well as it can: Ŝ grows as a crystal does, gaps in a row first.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "planner/inference/surface_model.h"
#include "planner/loop/fold.h"
#include "planner/loop/sample_grid.h"
#include "planner/loop/task_grid.h"

namespace palpate {

// A touch that a front asks for.
struct FrontTouch {
    Point start = Point::Zero();   // in the exterior lens of `home`
    Point target = Point::Zero();  // S lies before it
    bool certain = false;          // the interior lens of `interior_of` shows that S lies before the target
    bool expected = false;         // it is certain, or the samples beside make it plausible
    std::uint32_t home = 0;
    std::uint32_t interior_of = 0;
    bool audit = false;                     // the edge holds an inferred crossing
    std::optional<Point> known;             // a known solid begins there, and nobody need go and see
    bool is_buried = false;                 // where no tool can go, and nothing is met
    std::optional<double> spacing;          // mm: a new sample keeps that from others; none: as the criteria want it
    std::optional<Point> under;             // where to probe on to if the target is reached: S falls away steeply
    std::optional<FacetView> along;         // the dual edge that is probed; nothing: a new sample
    std::array<std::uint32_t, 3> beside{};  // samples around: the open edge and the third corner of its facet
};

class AdvancingFront {
public:
    struct Options {
        double epsilon = 0.0;   // mm
        double standoff = 0.0;  // mm: a probe starts so far above S if that is proven free, or as near to that as is
    };
    // Of ε: samples farther away than that have no bond with a new one.
    static constexpr double kRange = 3.0;

    AdvancingFront(MaintainedDelaunay& state, SurfaceModel& model, const Options& options)
        : state_(state),
          model_(model),
          options_(options),
          tasks_(2 * options.epsilon),
          on_known_(2 * options.epsilon),
          without_motion_(2 * options.epsilon),
          with_motion_(2 * options.epsilon),
          samples_(kRange * options.epsilon) {}

    // Infers what it can of an edge. True if that puts its facet into Ŝ.
    bool infer(DirectedEdge e);
    void note_insertion(const MaintainedDelaunay::Insertion& insertion);
    // The facet came into Ŝ or left it.
    void note_edges(DirectedEdge e);
    // What an inference rested on is less than it was.
    void reconsider(DirectedEdge e);
    // Infers and notes everything afresh. Linear time.
    void sweep();
    // Has an inferred facet touched anyway, if a way leads there.
    void note_audit(DirectedEdge e);
    // So many of those could not be asked for.
    [[nodiscard]] std::uint64_t audits_barred() const { return audits_barred_; }

    // S crosses the dual edge of a facet with that sample twice: two sheets are so near that touches beside samples mostly fail.
    void note_thin(std::uint32_t sample);
    [[nodiscard]] bool is_thin(std::uint32_t sample) const { return sample < thin_.size() && thin_[sample]; }
    // The facet's dual edge was touched, and whether S meets it is still not known.
    void note_missed(const std::array<std::uint32_t, 3>& facet) { missed_.insert(in_order(facet)); }
    // What to touch next: near to the tool, and where a new sample fits well. Nothing when no open edge is left that a touch near it can
    // close.
    [[nodiscard]] std::optional<FrontTouch> next(const Point& head);
    // Whether all samples that were touched are so far from the place that nothing but known solids is expected there.
    [[nodiscard]] bool is_far_from_object(const Point& place) const;
    [[nodiscard]] std::size_t open_count() const { return tasks_.size() + on_known_.size() + without_motion_.size() + with_motion_.size(); }

private:
    struct OpenEdge;

    void note_edge(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint);
    void note_edges_of(const std::array<std::uint32_t, 3>& facet, const EdgeTicket& hint);
    [[nodiscard]] double circumradius_of(const std::array<std::uint32_t, 3>& facet) const;
    // The open edge as it is now; nothing if it is closed.
    [[nodiscard]] std::optional<OpenEdge> look_at(const Task& task);
    // Looks again at the facets around the edge that was looked at last. True if one closes it.
    bool infer_around();
    // The facet ahead of the edge that S crosses most likely.
    [[nodiscard]] std::optional<FacetView> facet_ahead(const OpenEdge& edge);
    // What is taken to be free along a line near S.
    struct Clearance {
        Interval span;  // mm along the line
        std::uint32_t home = 0;

        [[nodiscard]] double clamp(double height) const;
    };
    [[nodiscard]] std::optional<Clearance> clearance_at(const Point& place, const Vector& up, std::span<const std::uint32_t> samples) const;
    // The crease that the open edge faces, if samples beyond it show one.
    struct Crease {
        Fold fold;
        std::uint32_t beyond = 0;  // a sample there
    };
    [[nodiscard]] std::optional<Crease> crease_ahead(const OpenEdge& edge) const;
    // A place for a new sample, in the tangent plane of an open edge, unfolded beyond a crease.
    struct Place {
        Point at = Point::Zero();
        double bonds = 0.0;  // with the samples around: how well it continues their lattice
    };
    // Where a new sample has the most bonds. Nothing if it would make too large a triangle at all places ahead.
    [[nodiscard]] std::optional<Place> best_place(const OpenEdge& edge, const std::optional<Crease>& crease);
    // A touch along -up, for a new sample near `place`.
    [[nodiscard]] std::optional<FrontTouch> touch_along(const Point& place, const Vector& up,
                                                        const std::array<std::uint32_t, 3>& beside) const;
    // The same at a place in the tangent plane of the open edge.
    [[nodiscard]] std::optional<FrontTouch> touch_at(const OpenEdge& edge, const std::optional<Crease>& crease, const Point& place) const;
    [[nodiscard]] std::optional<FrontTouch> touch_dual_edge(const FacetView& facet) const;
    [[nodiscard]] std::optional<FrontTouch> touch_ahead(const OpenEdge& edge, const std::optional<Crease>& crease,
                                                        const std::optional<Place>& place, const std::optional<FacetView>& ahead);
    [[nodiscard]] std::optional<FrontTouch> touch_audited(const Task& task);
    // Of the facets around the edge that was looked at last, one on known solids whose dual edge leads into one from a place that is
    // buried, or far from the object: where it does.
    [[nodiscard]] std::optional<FrontTouch> look_across() const;
    // Answers what known solids answer: where the touch would lead to one, far from the object or where no tool can go.
    void look_up(FrontTouch& touch) const;
    // A task, and the queue that it was taken from.
    struct Taken {
        Task task;
        TaskGrid* queue = nullptr;
    };
    // First what waits on S itself; then, on known solids, what these answer without motion, and what they do not.
    [[nodiscard]] std::optional<Taken> take_task(const Point& head);

    MaintainedDelaunay& state_;
    SurfaceModel& model_;
    const Options options_;
    TaskGrid tasks_;
    TaskGrid on_known_;             // both ends on a known solid: not sorted yet into those that need ...
    TaskGrid without_motion_;       // ... no motion
    TaskGrid with_motion_;          // ... and some
    Point looked_ = Point::Zero();  // where it answered last
    std::uint64_t audits_barred_ = 0;
    SampleGrid samples_;
    std::uint32_t known_ = 0;                                     // so many samples are in it
    std::set<std::array<std::uint32_t, 3>> missed_;               // facets whose dual edges were touched and taught nothing
    std::set<std::pair<std::uint32_t, std::uint32_t>> given_up_;  // open edges that touches did not close
    std::vector<bool> thin_;                                      // by sample, as far as there are any
    std::vector<DirectedEdge> around_;                            // scratch
    std::vector<std::uint32_t> adjacent_;                         // scratch
    std::vector<Eigen::Vector2d> flat_;                           // scratch: samples around an open edge, in its tangent plane
};

}  // namespace palpate
