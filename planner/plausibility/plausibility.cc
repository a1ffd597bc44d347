#include "planner/plausibility/plausibility.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

// Of ε: samples farther apart than that say nothing about each other's normals.
constexpr double kRange = 2.6;
// Samples touched from sides that look at each other like that lie on two sheets of S.
constexpr double kOtherSheet = -0.3;
// Neighbours that a plane is looked for through, two of them at a time, and those that it is held against.
constexpr std::size_t kPairs = 8;
constexpr std::size_t kVoters = 14;
// Two neighbours in directions whose sine is less give no plane.
constexpr double kLeastSine = 0.4;
// A neighbour is near a plane if it is seen under that sine from it: S bends so much over an ε at a reach of 4 ε, a crease bends more.
constexpr double kNearPlane = 0.15;
// Of ε: the vote of a nearer neighbour counts as if it were so far away.
constexpr double kNearestVote = 0.3;
// The share of a plane's votes that it has whatever way the probe came from.
constexpr double kBlindVote = 0.7;
// The least that a facet's Voronoi vertices must be on the two sides of S, and what every doubt adds. With −0.1 twice as many facets are
// wrong, with 0.3 a tenth more probes are needed (bunny).
constexpr double kPlausible = 0.0;
constexpr double kPerDoubt = 0.25;
// Planes steeper than that against a facet say nothing about its crossing.
constexpr double kSteepest = 0.2;
// Of ε: so much room the likeliest crossing has to have in the ball. Of facets on the bunny that were in doubt while all three planes had
// to meet the dual edge within the ball, 300 of 334 whose crossing does lie there pass, and 4 of 87 whose crossing does not; with 0:
// 319, 6.
constexpr double kSlack = 0.05;
// The cosine between normals on one side of all creases.
constexpr double kAgree = 0.7;
// Of ε: the crossing is looked for so far beyond where the samples' planes and the facet meet its dual edge.
constexpr double kBeyond = 0.3;
// Of ε: radius of the balls beside samples that guarded motion takes to be free until a touch contradicts.
constexpr double kClearance = 4.0;
// What a touch contradicts becomes smaller than it allows.
constexpr double kBlocked = 0.8;
// Balls end so much below ε: rounding.
constexpr double kRounding = 1 - 1e-9;
// Of ε: no new facet is to have a larger circumradius. The least and the largest both 0.9: 7 % more samples on the torus, and no fewer
// probes on the bunny.
constexpr double kLargestRadius = 0.95;

}  // namespace

// --- normals ---------------------------------------------------------------------------------------------------------

Vector Plausibility::plane_of_most(std::span<const Vector> neighbors, const Vector& outwards) const {
    Vector best = outwards;
    double most = -1;
    const std::size_t pairs = std::min(neighbors.size(), kPairs);
    for (std::size_t j = 1; j < pairs; ++j) {
        for (std::size_t i = 0; i < j; ++i) {
            Vector n = neighbors[i].cross(neighbors[j]);
            const double area = n.norm();
            if (!(area > kLeastSine * neighbors[i].norm() * neighbors[j].norm())) continue;
            n /= area;
            double votes = 0;
            for (const Vector& to : neighbors) {
                const double distance = to.norm();
                const double off = n.dot(to) / (kNearPlane * distance);
                if (std::abs(off) < 1) votes += (1 - off * off) / std::max(distance, kNearestVote * epsilon_);
            }
            const double facing = n.dot(outwards);
            votes *= std::lerp(kBlindVote, 1, std::abs(facing));
            if (votes <= most) continue;
            most = votes;
            best = facing < 0 ? Vector(-n) : n;
        }
    }
    return best;
}

void Plausibility::fit_normal(std::uint32_t sample) {
    Place& place = places_[sample];
    state_.adjacent_samples(sample, adjacent_);
    std::erase_if(adjacent_, [&](std::uint32_t b) {
        return !knows(b) || (places_[b].position - place.position).norm() > kRange * epsilon_ ||
               places_[b].outwards.dot(place.outwards) < kOtherSheet;
    });
    state_.sort_by_distance(place.position, adjacent_);
    if (adjacent_.size() > kVoters) adjacent_.resize(kVoters);
    neighbors_.clear();
    for (const std::uint32_t b : adjacent_) neighbors_.push_back(places_[b].position - place.position);
    place.normal = plane_of_most(neighbors_, place.outwards);
    // The least squares of those near the plane.
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vector& to : neighbors_) {
        const double distance = to.norm();
        if (std::abs(place.normal.dot(to)) < kNearPlane * distance) spread += to * to.transpose() / (distance * distance * distance);
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
    axes.computeDirect(spread);
    // Points on a line have no plane.
    if (axes.eigenvalues()(1) > kLeastSine * kLeastSine * axes.eigenvalues()(2)) {
        const Vector n = axes.eigenvectors().col(0);
        place.normal = n.dot(place.normal) < 0 ? Vector(-n) : n;
    }
    place.curvature = 0;
    for (const Vector& to : neighbors_) place.curvature = std::max(place.curvature, 2 * std::abs(place.normal.dot(to)) / to.squaredNorm());
}

// --- learning --------------------------------------------------------------------------------------------------------

void Plausibility::note_sample(std::uint32_t sample, const Vector& outwards) {
    if (places_.size() <= sample) places_.resize(sample + 1);
    places_[sample] = {state_.sample(sample), outwards.normalized(), outwards.normalized(), 0, kClearance * epsilon_, 0};
    fit_normal(sample);
    state_.adjacent_samples(sample, ring_);
    for (const std::uint32_t b : ring_) {
        if (knows(b) && (places_[b].position - places_[sample].position).norm() < kRange * epsilon_) fit_normal(b);
    }
}

void Plausibility::note_touch(const Point& touched, const Vector&, std::span<const std::uint32_t> beside) { check(touched, true, beside); }

void Plausibility::check(const Point& x, bool touched, std::span<const std::uint32_t> samples) {
    if (!touched) return;
    for (const std::uint32_t sample : samples) {
        if (x != state_.sample(sample) && has_clearance(sample)) block(sample, x);
    }
}

void Plausibility::check_way(const Point& x, std::uint32_t home) {
    const std::vector<std::uint32_t> around = samples_around(x, home);
    const std::uint32_t nearest = around.back();
    if (!knows(nearest)) return;
    const double before = places_[nearest].clearance;
    check(x, true, around);
    if (places_[nearest].clearance == before) places_[nearest].clearance *= kBlocked;
}

// The tool touched S at x: that was not free.
void Plausibility::block(std::uint32_t sample, const Point& x) {
    Place& place = places_[sample];
    const Vector to = x - place.position;
    const double height = to.dot(place.normal);
    if (height > margin_) place.clearance = std::min(place.clearance, kBlocked * to.squaredNorm() / (2 * height));
}

void Plausibility::contradict(std::span<const std::uint32_t> samples, const Point&) {
    for (const std::uint32_t sample : samples) doubt(sample);
}

void Plausibility::doubt(std::uint32_t sample) {
    if (!knows(sample)) return;
    ++places_[sample].doubts;
    doubted_.push_back(sample);
}

// --- knowledge -------------------------------------------------------------------------------------------------------

Lens Plausibility::clearance(std::uint32_t sample) const {
    const Place& place = places_[sample];
    return {place.position, {&place.normal, 1}, place.clearance, margin_, palpate::Side::exterior};
}

bool Plausibility::expects(std::span<const std::uint32_t> samples) const {
    return std::ranges::all_of(samples, [&](std::uint32_t a) {
        return std::ranges::all_of(samples, [&](std::uint32_t b) { return places_[a].normal.dot(places_[b].normal) > kAgree; });
    });
}

double Plausibility::inferable_radius(std::span<const std::uint32_t> samples, double epsilon) const {
    double curvature = 0;
    for (const std::uint32_t sample : samples) curvature = std::max(curvature, places_[sample].curvature);
    // S is at most twice as far from the facet's plane as a sphere of that curvature.
    return std::min(radius_within_ball(2 * curvature * epsilon), kLargestRadius) * epsilon;
}

Plausibility::Side Plausibility::side(CellId cell, const Point& vertex) const {
    if (state_.is_free(cell)) return {true, 1};
    double least = 1;
    double most = -1;
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        const DirectedEdge from_outside = state_.opposite({cell, i});
        if (state_.recorded_state(from_outside) == EdgeState::crossing && !state_.crossing(from_outside).inferred &&
            !state_.is_double(from_outside)) {
            return {false, 1};
        }
        const auto corner = state_.sample_of(cell, i);
        if (!corner) return {true, 1};  // at infinity
        if (!knows(*corner)) return {false, -1};
        const Vector to = vertex - places_[*corner].position;
        const double cosine = to.dot(places_[*corner].normal) / to.norm();
        least = std::min(least, cosine);
        most = std::max(most, cosine);
        sum += cosine;
    }
    return sum > 0 ? Side{true, least} : Side{false, -most};
}

std::optional<FacetView> Plausibility::view(DirectedEdge e) const {
    const std::optional<EdgeSpan> along = state_.span(e);
    if (!along) return std::nullopt;
    Vector outwards = Vector::Zero();
    double wanted = kPlausible;
    for (const std::uint32_t v : state_.facet_samples(e)) {
        if (!knows(v)) return std::nullopt;
        outwards += places_[v].normal;
        wanted = std::max(wanted, kPlausible + kPerDoubt * places_[v].doubts);
    }
    FacetView result = look_along(e, *along, outwards);
    const Side here = along->starts_on_boundary ? Side{true, 1} : side(e.cell, along->start_point());
    const Side there = along->ends_on_boundary ? Side{true, 1} : side(state_.neighbor(e), along->end_point());
    const bool is_crossed = here.is_outside != there.is_outside && here.is_outside == (result.inwards == e) &&
                            std::min(here.plausibility, there.plausibility) >= wanted;
    if (!is_crossed) return result;
    // S runs between the facet, which is a chord of it, and the samples' planes; at a crease that bends either way, too. Half way where it
    // is a parabola.
    std::array<double, 3> heights{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Place& corner = places_[result.corners[k]];
        const double slope = corner.normal.dot(result.up);
        if (slope < kSteepest) return result;
        heights[k] = corner.normal.dot(corner.position - result.line.origin) / slope;
    }
    std::ranges::sort(heights);
    const double rho = result.line.circumradius;
    const double room = kRounding * std::sqrt(std::max(0.0, epsilon_ * epsilon_ - rho * rho));
    if (std::abs(heights[1] / 2) + kSlack * epsilon_ > room) return result;
    const double high = std::min({std::max(heights[2], 0.0) + kBeyond * epsilon_, result.top, room});
    const double low = std::max({std::min(heights[0], 0.0) - kBeyond * epsilon_, result.bottom, -room});
    if (!(high > low)) return result;
    result.exterior = high;
    result.interior = low;
    result.exterior_of = result.interior_of = result.corners[0];
    return result;
}

}  // namespace palpate
