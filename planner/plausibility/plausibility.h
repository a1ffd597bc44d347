// Where S probably runs between its samples, by these and the sides that they were touched from alone (planner/DESIGN.md, "Plausibility").
// Nothing of it is proven: what it says is counted apart, audited, and withdrawn where a touch contradicts.
//
// Notation:
//   p, n   a sample, and the outward normal of the plane through it that most of its neighbours lie near
//   v      the Voronoi vertex of a cell; p is one of the cell's four corners
//
// May not live here: bounds and proofs (planner/inference), what to touch (planner/loop).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "planner/inference/surface_model.h"

namespace palpate {

class Plausibility final : public SurfaceModel {
public:
    // `epsilon` (mm): samples farther apart than a few of it know nothing of each other. `margin` (mm): touched points may be wrong by
    // that.
    Plausibility(MaintainedDelaunay& state, double epsilon, double margin) : SurfaceModel(state), epsilon_(epsilon), margin_(margin) {}

    // The side of S that a Voronoi vertex lies on.
    struct Side {
        bool is_outside = false;
        // How far from S it lies, of its distance to the corners; 1 if motion or a touch shows the side; −1 if nothing is known.
        double plausibility = 0.0;
    };
    // `vertex`: of the cell, or where an edge from it enters ω.
    [[nodiscard]] Side side(CellId cell, const Point& vertex) const;

    void note_sample(std::uint32_t sample, const Vector& outwards) override;
    void note_touch(const Point& touched, const Vector& outwards, std::span<const std::uint32_t> beside) override;
    void check(const Point& x, bool touched, std::span<const std::uint32_t> samples) override;
    void check_way(const Point& x, std::uint32_t home) override;
    void contradict(std::span<const std::uint32_t> samples, const Point& x) override;
    // Something was wrong at the sample: more is asked of facets there from now on.
    void doubt(std::uint32_t sample);
    // The samples that doubts have fallen on since they were taken last.
    [[nodiscard]] std::vector<std::uint32_t> take_doubted() { return std::exchange(doubted_, {}); }

    [[nodiscard]] bool has_clearance(std::uint32_t sample) const override { return knows(sample) && places_[sample].clearance > 0; }
    [[nodiscard]] Lens clearance(std::uint32_t sample) const override;
    [[nodiscard]] Vector normal(std::uint32_t sample) const override { return places_[sample].normal; }
    // Nothing is ever known to be inside.
    [[nodiscard]] std::optional<Depth> inside_below(const Point&, const Vector&, std::span<const std::uint32_t>) const override {
        return std::nullopt;
    }
    // Where their normals agree.
    [[nodiscard]] bool expects(std::span<const std::uint32_t> samples) const override;
    [[nodiscard]] double inferable_radius(std::span<const std::uint32_t> samples, double epsilon) const override;
    // Without heights where S is not plausible enough to cross the edge, or not within a ball of radius ε.
    [[nodiscard]] std::optional<FacetView> view(DirectedEdge e) const override;

private:
    struct Place {
        Point position = Point::Zero();
        Vector outwards = Vector::Zero();  // unit; zero: not noted yet
        Vector normal = Vector::Zero();
        double curvature = 0.0;  // 1/mm: the largest that its neighbours show, those across a crease, too
        double clearance = 0.0;  // mm: radius of the ball on the normal that guarded motion takes to be free
        std::uint32_t doubts = 0;
    };

    [[nodiscard]] bool knows(std::uint32_t sample) const { return sample < places_.size() && !places_[sample].outwards.isZero(); }
    // S crosses that edge, between ends on those sides, where a known solid begins.
    void look_up(FacetView& facet, const std::array<Side, 2>& ends, DirectedEdge inwards) const;
    void fit_normal(std::uint32_t sample);
    // The plane through the origin that most of those points, with those normals of their own, lie near.
    [[nodiscard]] Vector plane_of_most(std::span<const Vector> neighbors, std::span<const Vector> normals, const Vector& outwards) const;
    void block(std::uint32_t sample, const Point& x);
    void note_contradiction(const FacetView&) override {}

    const double epsilon_;
    const double margin_;
    std::vector<Place> places_;  // by sample
    std::vector<std::uint32_t> doubted_;
    std::vector<std::uint32_t> ring_;      // scratch
    std::vector<std::uint32_t> adjacent_;  // scratch
    std::vector<Vector> neighbors_;        // scratch: where they are, from the sample
    std::vector<Vector> normals_;          // scratch: theirs
};

}  // namespace palpate
