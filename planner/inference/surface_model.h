// What is taken to be known of S between its samples without a touch: what the front grows by and guarded motion goes by.
//
// One model proves what it says from a bound on the reach (inference.h), another thinks it plausible (planner/plausibility).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "planner/delaunay/maintained_delaunay.h"
#include "planner/inference/lens.h"

namespace palpate {

// A dual edge near S. Heights are along the facet's line, above the facet's plane, outwards.
struct FacetView {
    DirectedEdge inwards;  // the edge from its exterior end
    std::array<std::uint32_t, 3> corners{};
    DualLine line;
    Vector up = Vector::Zero();      // unit, outwards along the line
    double top = 0.0;                // mm: height of the edge's exterior end, inside ω
    double bottom = 0.0;             // mm: of its interior end
    std::optional<double> exterior;  // mm: free just above; the smallest that is known
    std::optional<double> interior;  // mm: inside O just below; the largest that is known
    std::uint32_t exterior_of = 0;   // the sample that `exterior` is known from
    std::uint32_t interior_of = 0;   // the sample that `interior` is known from
    double confidence = 1.0;         // that it is so: 1 if proven

    [[nodiscard]] Point at(double height) const { return line.origin + height * up; }
    // S meets the edge, between those heights.
    [[nodiscard]] bool is_crossed() const { return exterior && interior && *exterior <= top && *interior >= bottom; }
    // That cannot be: something that it rests on is wrong.
    [[nodiscard]] bool is_contradictory() const { return exterior && interior && *exterior <= *interior; }
    // Of the largest surface Delaunay ball that the gap allows. REQUIRES: exterior and interior.
    [[nodiscard]] double ball_radius() const;
};

class SurfaceModel {
public:
    explicit SurfaceModel(MaintainedDelaunay& state) : state_(state) {}
    virtual ~SurfaceModel() = default;
    SurfaceModel(const SurfaceModel&) = delete;
    SurfaceModel& operator=(const SurfaceModel&) = delete;

    // --- learning ---------------------------------------------------------------------------------------------------
    // A sample was inserted; `outwards` points to where the probe that touched it came from.
    virtual void note_sample(std::uint32_t sample, const Vector& outwards) = 0;
    // A touch that did not become a sample, beside those samples.
    virtual void note_touch(const Point& touched, const Vector& outwards, std::span<const std::uint32_t> beside) = 0;
    // The tool was at x, so x is free, or (`touched`) on S: tested against what is said of the space beside those samples.
    virtual void check(const Point& x, bool touched, std::span<const std::uint32_t> samples) = 0;
    // The tool touched S at x on a way through that sample's clearance.
    virtual void check_way(const Point& x, std::uint32_t home) = 0;
    // The tool passed where S was said to cross between those samples: at x.
    virtual void contradict(std::span<const std::uint32_t> samples, const Point& x) = 0;
    // Takes an inferred crossing back and never infers that facet again: only a touch can say.
    void distrust(DirectedEdge e);
    [[nodiscard]] bool is_distrusted(const std::array<std::uint32_t, 3>& facet) const { return distrusted_.contains(in_order(facet)); }
    // Is told of everything that infer() learns: both ends of the gap.
    void watch(std::function<void(const Point& near, const Point& far)> watcher) { watcher_ = std::move(watcher); }

    // --- knowledge --------------------------------------------------------------------------------------------------
    // Whether guarded motion may take space beside the sample to be free, ...
    [[nodiscard]] virtual bool has_clearance(std::uint32_t sample) const = 0;
    // ... and which. REQUIRES: has_clearance(sample).
    [[nodiscard]] virtual Lens clearance(std::uint32_t sample) const = 0;
    // Unit, outwards: as far as it is known. REQUIRES: has_clearance(sample).
    [[nodiscard]] virtual Vector normal(std::uint32_t sample) const = 0;
    // Below a place near S, along a direction `up` out of it: where a sample shows that the inside has begun.
    struct Depth {
        double height = 0.0;   // mm above `place`, the largest that one of the samples shows
        std::uint32_t of = 0;  // that sample
    };
    [[nodiscard]] virtual std::optional<Depth> inside_below(const Point& place, const Vector& up,
                                                            std::span<const std::uint32_t> samples) const = 0;
    // Whether S is expected below all places beside those samples, though nothing proves it: a touch that stays away is asked for again.
    [[nodiscard]] virtual bool expects(std::span<const std::uint32_t> samples) const = 0;
    // mm: the circumradius of facets between those samples whose crossings can mostly be inferred within balls of radius `epsilon`.
    [[nodiscard]] virtual double inferable_radius(std::span<const std::uint32_t> samples, double epsilon) const = 0;
    // The edge as the samples around show it; nothing if it lies outside ω, or they show nothing.
    [[nodiscard]] virtual std::optional<FacetView> view(DirectedEdge e) const = 0;
    // If S crosses the edge within a ball of that radius, as far as this can tell, learns so and returns the edge from its exterior end.
    std::optional<DirectedEdge> infer(DirectedEdge e, double max_ball_radius);

protected:
    // Of ε: smaller facets make more samples, whatever a model can infer.
    static constexpr double kLeastRadius = 0.85;
    // Of ε: the largest circumradius ρ of a facet whose ball does not exceed ε, if S is at most bend·ρ²/2ε from the facet's plane, or
    // kLeastRadius.
    [[nodiscard]] static double radius_within_ball(double bend);
    // The sample nearest to x, last, and those joined to it; `home` is a sample nearby.
    [[nodiscard]] std::vector<std::uint32_t> samples_around(const Point& x, std::uint32_t home) const;
    // The edge, seen from the side that `outwards` points to, with nothing known of it.
    [[nodiscard]] FacetView look_along(DirectedEdge e, const EdgeSpan& along, const Vector& outwards) const;
    // What view() showed cannot be.
    virtual void note_contradiction(const FacetView& seen) = 0;

    MaintainedDelaunay& state_;

private:
    std::set<std::array<std::uint32_t, 3>> distrusted_;  // facets, each with its samples in order
    std::function<void(const Point&, const Point&)> watcher_;
};

}  // namespace palpate
