// What follows from the samples and a bound on the reach without a touch: normals, lenses, crossings (planner/DESIGN.md, "Inference").
//
// May not live here: what to touch next (advancing_front.h), where the tool may go (free_space.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "planner/inference/normal_cone.h"
#include "planner/inference/surface_model.h"

namespace palpate {

// What refutes a bound on the reach.
struct Refutation {
    double share = 0.0;    // of the bound: the evidence allows no more
    double largest = 0.0;  // mm: so no bound above that can hold
    std::string evidence;
};

class Inference final : public SurfaceModel {
public:
    // `reach` (mm): rch(S) is at least that. `range` (mm): samples farther apart are not asked about each other's normals. `margin` (mm):
    // touched points may be wrong by that.
    Inference(MaintainedDelaunay& state, double reach, double range, double margin)
        : SurfaceModel(state), reach_(reach), range_(range), margin_(margin) {}

    // mm: the bound that everything here rests on.
    [[nodiscard]] double reach() const { return reach_; }

    // --- learning ---------------------------------------------------------------------------------------------------
    void note_sample(std::uint32_t sample, const Vector& outwards) override;
    // It has lenses, too.
    void note_touch(const Point& touched, const Vector& outwards, std::span<const std::uint32_t> beside) override;
    // Against the lenses of those samples.
    void check(const Point& x, bool touched, std::span<const std::uint32_t> lenses) override;
    // Some lens is false.
    void check_way(const Point& x, std::uint32_t home) override;
    void contradict(std::span<const std::uint32_t> samples, const Point& x) override;
    // The worst contradiction since it was taken last.
    [[nodiscard]] bool is_refuted() const { return refutation_.has_value(); }
    [[nodiscard]] std::optional<Refutation> take_refutation() { return std::exchange(refutation_, std::nullopt); }
    // Starts over with a smaller bound, from the same touches.
    void lower(double share);

    // --- knowledge --------------------------------------------------------------------------------------------------
    // Whether the sample has lenses: its normal is known well enough.
    [[nodiscard]] bool knows(std::uint32_t sample) const { return sample < apexes_.size() && apexes_[sample].cone.is_known(); }
    // REQUIRES: knows(sample).
    [[nodiscard]] Lens lens(std::uint32_t sample, Side side) const { return lens(apexes_[sample], side); }
    [[nodiscard]] bool has_clearance(std::uint32_t sample) const override { return knows(sample); }
    // The exterior lens.
    [[nodiscard]] Lens clearance(std::uint32_t sample) const override { return lens(sample, Side::exterior); }
    // In the middle of the normals that the sample may have.
    [[nodiscard]] Vector normal(std::uint32_t sample) const override { return apexes_[sample].cone.axis(); }
    [[nodiscard]] std::optional<Depth> inside_below(const Point& place, const Vector& up,
                                                    std::span<const std::uint32_t> samples) const override;
    [[nodiscard]] bool expects(std::span<const std::uint32_t>) const override { return false; }
    [[nodiscard]] double inferable_radius(std::span<const std::uint32_t> samples, double epsilon) const override;
    // As the lenses around show it.
    [[nodiscard]] std::optional<FacetView> view(DirectedEdge e) const override;

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

    [[nodiscard]] Lens lens(const Apex& apex, Side side, double share = 1.0) const {
        return {apex.position, apex.cone.extremes(), share * reach_, margin_, side};
    }
    // Beyond 2 r a slab holds all normals; a little less far it is not worth the work.
    [[nodiscard]] double range(double share = 1.0) const { return std::min(range_, share * reach_); }
    // The samples that can say something on the normal at the apex, of those: near first.
    void sort_neighbors(const Apex& apex, std::vector<std::uint32_t>& samples) const;
    // The cone that those samples leave at the apex by that share of the bound. False if they leave none: no such bound can hold.
    [[nodiscard]] bool find_cone(Apex& apex, std::span<const std::uint32_t> neighbors, double share = 1.0) const;
    void begin(std::uint32_t sample);
    void begin(Witness& witness);
    [[nodiscard]] bool is_worse(double share) const { return !refutation_ || share < refutation_->share; }
    void note(double share, std::string evidence) { refutation_ = Refutation{share, share * reach_, std::move(evidence)}; }
    // Whether x, free or (`touched`) on S, is where the lens says that it cannot be. A touch may be off by the margin, as the lens's apex
    // may.
    [[nodiscard]] bool is_within(Lens lens, const Point& x, bool touched) const;
    void note_contradiction(const FacetView& seen) override;
    // x, free or on S, contradicts what the sample's neighbours leave of its normal.
    void refute(std::uint32_t sample, const Point& x, bool touched);

    double reach_;
    const double range_;
    const double margin_;
    std::vector<Apex> apexes_;  // by sample
    std::vector<Witness> witnesses_;
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> witnesses_of_;  // by sample
    std::optional<Refutation> refutation_;
    std::vector<std::uint32_t> neighbors_;  // scratch
    std::vector<std::uint32_t> ring_;       // scratch
};

}  // namespace palpate
