// What follows from the samples and a bound on the reach without a touch: normals, lenses, crossings (DESIGN section 6).
//
// May not live here: what to touch next (front.h), where the tool may go (free_space.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "planner/internal/lens.h"
#include "planner/internal/maintained_delaunay.h"
#include "planner/internal/normal_cone.h"

namespace palpate {

// A dual edge near S. Heights are along the facet's line, above the facet's plane, outwards.
struct FacetView {
    DirectedEdge inwards;  // the edge from its exterior end
    std::array<std::uint32_t, 3> corners{};
    DualLine line;
    Vector up = Vector::Zero();      // unit, outwards along the line
    double top = 0.0;                // mm: height of the edge's exterior end, inside ω
    double bottom = 0.0;             // mm: of its interior end
    std::optional<double> exterior;  // mm: free just above; the smallest that a lens shows ...
    std::optional<double> interior;  // mm: inside O just below; the largest that a lens shows ...
    std::uint32_t exterior_of = 0;   // ... and whose lenses those are
    std::uint32_t interior_of = 0;

    [[nodiscard]] Point at(double height) const { return line.origin + height * up; }
    // S meets the edge, between those heights.
    [[nodiscard]] bool is_crossed() const { return exterior && interior && *exterior <= top && *interior >= bottom; }
    // What lenses show cannot be: some bound or touch is wrong.
    [[nodiscard]] bool is_contradictory() const { return exterior && interior && *exterior <= *interior; }
    // The whole edge lies on one side of S, as far as lenses reach.
    [[nodiscard]] bool is_passed() const { return (exterior && bottom >= *exterior) || (interior && top <= *interior); }
    // Of the largest surface Delaunay ball that the gap allows. REQUIRES: exterior and interior.
    [[nodiscard]] double ball_radius() const;
};

// What refutes a bound on the reach.
struct Refutation {
    double largest_reach = 0.0;  // mm: the evidence allows no larger bound
    Point where = Point::Zero();
    std::string evidence;
};

class Inference {
public:
    // `reach` (mm): rch(S) is at least that, says the user. `range` (mm): samples farther apart are not asked about each other's
    // normals. `margin` (mm): touched points may be wrong by that.
    Inference(MaintainedDelaunay& state, double reach, double range, double margin)
        : state_(state), reach_(reach), range_(range), margin_(margin) {}

    [[nodiscard]] double reach() const { return reach_; }

    // --- learning ---------------------------------------------------------------------------------------------------
    // A sample was inserted; `outwards` points to where the probe that touched it came from.
    void note_sample(std::uint32_t sample, const Vector& outwards);
    // A touch that did not become a sample, beside those samples: it has lenses, too.
    void note_touch(const Point& touched, const Vector& outwards, std::span<const std::uint32_t> beside);
    // The tool was at x, so x is free, or (`touched`) on S: tested against the lenses of those samples.
    void check(const Point& x, bool touched, std::span<const std::uint32_t> lenses);
    // The tool touched S at x on a way through those lenses: some lens is false.
    void check_way(const Point& x, std::span<const std::uint32_t> lenses);
    // The first contradiction since the bound was lowered last.
    [[nodiscard]] const std::optional<Refutation>& refutation() const { return refutation_; }
    // Starts over with a smaller bound, from the same touches.
    void lower(double reach);

    // --- knowledge --------------------------------------------------------------------------------------------------
    // Whether the sample has lenses: its normal is known well enough.
    [[nodiscard]] bool knows(std::uint32_t sample) const { return sample < apexes_.size() && apexes_[sample].cone.is_known(); }
    // REQUIRES: knows(sample).
    [[nodiscard]] Vector normal(std::uint32_t sample) const { return apexes_[sample].cone.axis(); }
    [[nodiscard]] Lens lens(std::uint32_t sample, Side side) const { return lens(apexes_[sample], side); }

    // The edge as the lenses around it show it; nothing if it lies outside ω, or no lens is near.
    [[nodiscard]] std::optional<FacetView> view(DirectedEdge e) const;
    // If S must cross the edge within a ball of that radius, learns so and returns the edge from its exterior end.
    std::optional<DirectedEdge> infer(DirectedEdge e, double max_ball_radius);
    // Takes an inferred crossing back and never infers that facet again: only a touch can say.
    void distrust(DirectedEdge e);
    [[nodiscard]] std::uint64_t inferred() const { return inferred_; }
    // Is told of everything that infer() learns: both ends of the gap.
    void watch(std::function<void(const Point& near, const Point& far)> watcher) { watcher_ = std::move(watcher); }

private:
    struct Apex {
        Point position = Point::Zero();
        Vector outwards = Vector::Zero();  // zero: not noted yet
        NormalCone cone;
    };
    struct Witness {
        Apex apex;
        std::vector<std::uint32_t> beside;
    };

    [[nodiscard]] Lens lens(const Apex& apex, Side side) const { return {apex.position, apex.cone, reach_, margin_, side}; }
    // Beyond 2 r a slab holds all normals; a little less far it is not worth the work.
    [[nodiscard]] double range() const { return std::min(range_, reach_); }
    // The samples that can say something on the normal at p, of those: near first.
    void sort_neighbors(const Point& p, std::vector<std::uint32_t>& samples) const;
    // The cone that those samples leave at the apex. False if they leave none: no such bound can hold.
    [[nodiscard]] bool find_cone(Apex& apex, std::span<const std::uint32_t> neighbors, double reach) const;
    void begin(std::uint32_t sample);
    template <typename Allows>
    [[nodiscard]] double largest_reach(const Allows& allows) const;
    void refute(const FacetView& seen);
    // x, free or on S, contradicts what the sample's neighbours leave of its normal.
    void refute(std::uint32_t sample, const Point& x, bool touched);

    MaintainedDelaunay& state_;
    double reach_;
    const double range_;
    const double margin_;
    std::vector<Apex> apexes_;  // by sample
    std::vector<Witness> witnesses_;
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> witnesses_of_;  // by sample
    std::optional<Refutation> refutation_;
    std::set<std::array<std::uint32_t, 3>> distrusted_;  // facets, each with its samples in order
    std::uint64_t inferred_ = 0;
    std::function<void(const Point&, const Point&)> watcher_;
    std::vector<std::uint32_t> neighbors_;  // scratch
    std::vector<std::uint32_t> ring_;       // scratch
};

}  // namespace palpate
