// What follows from the samples and a bound on the reach without a touch: normals, lenses, crossings (planner/DESIGN.md, "Inference").
//
// May not live here: what to touch next (advancing_front.h), where the tool may go (free_space.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "planner/delaunay/maintained_delaunay.h"
#include "planner/inference/lens.h"
#include "planner/inference/normal_cone.h"

namespace palpate {

// A dual edge near S. Heights are along the facet's line, above the facet's plane, outwards.
struct FacetView {
    DirectedEdge inwards;  // the edge from its exterior end
    std::array<std::uint32_t, 3> corners{};
    DualLine line;
    Vector up = Vector::Zero();      // unit, outwards along the line
    double top = 0.0;                // mm: height of the edge's exterior end, inside ω
    double bottom = 0.0;             // mm: of its interior end
    std::optional<double> exterior;  // mm: free just above; the smallest that a lens shows
    std::optional<double> interior;  // mm: inside O just below; the largest that a lens shows
    std::uint32_t exterior_of = 0;   // the sample whose lens shows `exterior`
    std::uint32_t interior_of = 0;   // the sample whose lens shows `interior`

    [[nodiscard]] Point at(double height) const { return line.origin + height * up; }
    // S meets the edge, between those heights.
    [[nodiscard]] bool is_crossed() const { return exterior && interior && *exterior <= top && *interior >= bottom; }
    // What lenses show cannot be: some bound or touch is wrong.
    [[nodiscard]] bool is_contradictory() const { return exterior && interior && *exterior <= *interior; }
    // Of the largest surface Delaunay ball that the gap allows. REQUIRES: exterior and interior.
    [[nodiscard]] double ball_radius() const;
};

// What the bound is that everything here rests on.
struct ReachBound {
    double reach = 0.0;      // mm: rch(S) is at least that; or, if the bound is local, what every sample begins with
    bool is_local = false;   // every sample has a bound of its own: balls of that radius that touch S there miss S
    double least = 0.0;      // mm: a local bound below that is of no use
    double clearance = 0.0;  // mm: of the balls beside samples that guarded motion takes to be free, if the bound is local
};

// What refutes a bound on the reach.
struct Refutation {
    std::vector<std::uint32_t> samples;  // whose bounds contradict each other, or what was found
    double share = 0.0;                  // of those bounds: the evidence allows no more
    double largest = 0.0;                // mm: so no bound for all of S above that can hold
    std::string evidence;
    bool is_proof = true;  // not caution: no bound above that share can hold
};

class Inference {
public:
    // `range` (mm): samples farther apart are not asked about each other's normals. `margin` (mm): touched points may be
    // wrong by that.
    Inference(MaintainedDelaunay& state, const ReachBound& bound, double range, double margin)
        : state_(state), bound_(bound), range_(range), margin_(margin) {}

    [[nodiscard]] const ReachBound& bound() const { return bound_; }
    [[nodiscard]] double reach(std::uint32_t sample) const { return apexes_[sample].reach; }

    // --- learning ---------------------------------------------------------------------------------------------------
    // A sample was inserted; `outwards` points to where the probe that touched it came from.
    void note_sample(std::uint32_t sample, const Vector& outwards);
    // A touch that did not become a sample, beside those samples: it has lenses, too.
    void note_touch(const Point& touched, const Vector& outwards, std::span<const std::uint32_t> beside);
    // The tool was at x, so x is free, or (`touched`) on S: tested against the lenses of those samples.
    void check(const Point& x, bool touched, std::span<const std::uint32_t> lenses);
    // The tool touched S at x on a way to that sample's lens: some lens is false.
    void check_way(const Point& x, std::uint32_t home);
    // The tool passed where those samples' lenses make S cross: at x.
    void contradict(std::span<const std::uint32_t> samples, const Point& x);
    // The contradictions since they were taken last; of a bound for all samples, the worst.
    [[nodiscard]] bool is_refuted() const { return !refutations_.empty(); }
    [[nodiscard]] std::vector<Refutation> take_refutations() { return std::exchange(refutations_, {}); }
    // Starts over with a smaller bound, from the same touches.
    void lower(double share);
    // The same for the bound of one sample.
    void lower(std::uint32_t sample, double share);

    // --- knowledge --------------------------------------------------------------------------------------------------
    // Whether the sample has lenses: its normal is known well enough.
    [[nodiscard]] bool knows(std::uint32_t sample) const { return sample < apexes_.size() && apexes_[sample].cone.is_known(); }
    // REQUIRES: knows(sample).
    [[nodiscard]] Lens lens(std::uint32_t sample, Side side) const { return lens(apexes_[sample], side); }
    // Whether guarded motion may take space beside the sample to be free.
    [[nodiscard]] bool has_clearance(std::uint32_t sample) const {
        return bound_.is_local ? sample < apexes_.size() && apexes_[sample].clearance > 0 : knows(sample);
    }
    // What space that is: the exterior lens, or with local bounds what no touch has contradicted. REQUIRES: has_clearance(sample).
    [[nodiscard]] Lens clearance(std::uint32_t sample) const;
    // In the middle of the normals that the sample may have, as far as they are known. REQUIRES: has_clearance(sample).
    [[nodiscard]] Vector normal(std::uint32_t sample) const {
        return bound_.is_local ? apexes_[sample].normal : apexes_[sample].cone.axis();
    }

    // The edge as the lenses around it show it; nothing if it lies outside ω, or no lens is near.
    [[nodiscard]] std::optional<FacetView> view(DirectedEdge e) const;
    // If S must cross the edge within a ball of that radius, learns so and returns the edge from its exterior end.
    std::optional<DirectedEdge> infer(DirectedEdge e, double max_ball_radius);
    // Takes an inferred crossing back and never infers that facet again: only a touch can say.
    void distrust(DirectedEdge e);
    // Is told of everything that infer() learns: both ends of the gap.
    void watch(std::function<void(const Point& near, const Point& far)> watcher) { watcher_ = std::move(watcher); }

private:
    struct Apex {
        Point position = Point::Zero();
        Vector outwards = Vector::Zero();  // zero: not noted yet
        double reach = 0.0;
        NormalCone cone;
        Vector normal = Vector::Zero();  // of local bounds: also where the cone is lost
        double clearance = 0.0;
    };
    struct Witness {
        Apex apex;
        std::vector<std::uint32_t> beside;
    };

    [[nodiscard]] Lens lens(const Apex& apex, Side side) const { return {apex.position, apex.cone.extremes(), apex.reach, margin_, side}; }
    // Beyond 2 r a slab holds all normals; a little less far it is not worth the work.
    [[nodiscard]] double range(const Apex& apex) const { return std::min(range_, apex.reach); }
    // The samples that can say something on the normal at the apex, of those: near first.
    void sort_neighbors(const Apex& apex, std::vector<std::uint32_t>& samples) const;
    // The cone that those samples leave at the apex. False if they leave none: no such bound can hold.
    [[nodiscard]] bool find_cone(Apex& apex, std::span<const std::uint32_t> neighbors) const;
    void begin(std::uint32_t sample);
    void begin(Witness& witness);
    [[nodiscard]] bool is_worse(double share) const { return bound_.is_local || refutations_.empty() || share < refutations_[0].share; }
    void note(Refutation refutation);
    // What a new sample's bound begins with. REQUIRES: ring_ holds the samples around.
    [[nodiscard]] double first_reach(std::uint32_t sample) const;
    // Local bounds follow the curvature that samples around show.
    [[nodiscard]] double curvature_share(const Apex& apex, const Vector& to) const;
    void block(std::uint32_t sample, const Point& x);
    // Whether x, free or (`touched`) on S, is where the lens says that it cannot be. A touch may be off by the margin, as the lens's apex
    // may.
    [[nodiscard]] bool is_within(Lens lens, const Point& x, bool touched) const;
    void refute(const FacetView& seen);
    // x, free or on S, contradicts what the sample's neighbours leave of its normal.
    void refute(std::uint32_t sample, const Point& x, bool touched);

    MaintainedDelaunay& state_;
    ReachBound bound_;
    const double range_;
    const double margin_;
    std::vector<Apex> apexes_;  // by sample
    std::vector<Witness> witnesses_;
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> witnesses_of_;  // by sample
    std::vector<Refutation> refutations_;
    std::set<std::array<std::uint32_t, 3>> distrusted_;  // facets, each with its samples in order
    std::function<void(const Point&, const Point&)> watcher_;
    std::vector<std::uint32_t> neighbors_;  // scratch
    std::vector<std::uint32_t> ring_;       // scratch
};

}  // namespace palpate
