#include "planner/plausibility/plausibility.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "planner/plausibility/local_solid.h"

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
// The share of a neighbour's vote that it has only where the plane agrees with its own normal: a plane that cuts a crease off lies near
// samples on both sides, and is tangent at none. With 0, 1: 4 %, 2 % more probes on eight sharp objects.
constexpr double kAgreeing = 0.5;
// Of ε: the vote of a nearer neighbour counts as if it were so far away.
constexpr double kNearestVote = 0.3;
// The share of a plane's votes that it has whatever way the probe came from.
constexpr double kBlindVote = 0.7;
// How likely a facet is wrong, by its plausibility and by the room that its likeliest crossing has in the ball (of ε): measured on 73,000
// facets of 15 objects, see planner/README.md.
constexpr double kWrongBySide = 0.05;
constexpr double kWrongByRoom = 0.3;
constexpr double kSideScale = 0.12;
constexpr double kRoomScale = 0.045;
// While the surface grows, facets are taken as they are likely, as most become likelier once there are samples on all sides of them.
constexpr double kMostDoubtful = 0.16;
// Every doubt makes a facet so many times as doubtful.
constexpr double kPerDoubt = 2.0;
// Planes steeper than that against a facet say nothing about its crossing.
constexpr double kSteepest = 0.2;
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

// Of a facet, as the constants above have it.
double chance_of_error(double plausibility, double room) {
    return kWrongBySide * std::exp(-plausibility / kSideScale) + kWrongByRoom * std::exp(-room / kRoomScale);
}

}  // namespace

// --- normals ---------------------------------------------------------------------------------------------------------

Vector Plausibility::plane_of_most(std::span<const Vector> neighbors, std::span<const Vector> normals, const Vector& outwards) const {
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
            const double facing = n.dot(outwards);
            for (std::size_t k = 0; k < neighbors.size(); ++k) {
                const Vector& to = neighbors[k];
                const double distance = to.norm();
                const double off = n.dot(to) / (kNearPlane * distance);
                if (std::abs(off) >= 1) continue;
                const double agrees = std::max(0.0, facing < 0 ? -n.dot(normals[k]) : n.dot(normals[k]));
                votes += std::lerp(1 - kAgreeing, 1, agrees * agrees) * (1 - off * off) / std::max(distance, kNearestVote * epsilon_);
            }
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
    normals_.clear();
    for (const std::uint32_t b : adjacent_) {
        neighbors_.emplace_back(places_[b].position - place.position);
        normals_.push_back(places_[b].normal);
    }
    place.normal = plane_of_most(neighbors_, normals_, place.outwards);
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
    if (const auto known = state_.surroundings().known_normal(place.position)) place.normal = *known;
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
    const KnownSolids& known = state_.surroundings().known();
    if (!known.empty()) {
        if (known.contains(vertex)) return {false, 1};
        if (known.is_buried(vertex)) return {true, 1};
    }
    LocalSolid solid;
    double radius = 0;
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
        const Place& place = places_[*corner];
        solid.add(place.position, place.normal);
        radius = (vertex - place.position).norm();  // the same for all
        sum += (vertex - place.position).dot(place.normal);
    }
    // Where the planes leave open how they are joined, they vote.
    const double height = solid.height(vertex).value_or(sum / 4);
    return {height > 0, std::abs(height) / radius};
}

void Plausibility::look_up(FacetView& facet, const std::array<Side, 2>& ends, DirectedEdge inwards) const {
    if (facet.inwards != inwards) {
        facet.inwards = inwards;
        facet.up = -facet.up;
        const double top = facet.top;
        facet.top = -facet.bottom;
        facet.bottom = -top;
    }
    const auto entry = state_.surroundings().known().first_entry({facet.at(facet.top), facet.at(facet.bottom)});
    if (!entry) return;
    const double height = facet.up.dot(*entry - facet.line.origin);
    const double rho = facet.line.circumradius;
    const double gap = KnownSolids::kGap * epsilon_;
    if (std::hypot(rho, std::abs(height) + gap) > epsilon_) return;
    const double wrong = chance_of_error(std::min(ends[0].plausibility, ends[1].plausibility), 1);
    if (wrong > kMostDoubtful) return;
    facet.confidence = 1 - wrong;
    facet.exterior = std::min(height + gap, facet.top);
    facet.interior = std::max(height - gap, facet.bottom);
    facet.exterior_of = facet.interior_of = facet.corners[0];
}

std::optional<FacetView> Plausibility::view(DirectedEdge e) const {
    const std::optional<EdgeSpan> along = state_.span(e);
    if (!along) return std::nullopt;
    Vector outwards = Vector::Zero();
    std::uint32_t doubts = 0;
    LocalSolid solid;
    for (const std::uint32_t v : state_.facet_samples(e)) {
        if (!knows(v)) return std::nullopt;
        outwards += places_[v].normal;
        doubts = std::max(doubts, places_[v].doubts);
        solid.add(places_[v].position, places_[v].normal);
    }
    FacetView result = look_along(e, *along, outwards);
    const Side here = along->starts_on_boundary ? Side{true, 1} : side(e.cell, along->start_point());
    const Side there = along->ends_on_boundary ? Side{true, 1} : side(state_.neighbor(e), along->end_point());
    if (here.is_outside == there.is_outside) return result;
    if (state_.are_known(result.corners)) {
        look_up(result, {here, there}, here.is_outside ? e : state_.opposite(e));
        return result;
    }
    if (here.is_outside != (result.inwards == e)) return result;
    const auto crossing = solid.crossing(result.line.origin, result.up);
    if (!crossing || crossing->slope < kSteepest) return result;
    // The facet is a chord of S: half way between it and the samples' planes where S is a parabola, on them where it has a crease.
    const double likeliest = expects(result.corners) ? crossing->at / 2 : crossing->at;
    const double rho = result.line.circumradius;
    const double half = kRounding * std::sqrt(std::max(0.0, epsilon_ * epsilon_ - rho * rho));  // of the dual edge within the ball
    const double room = (half - std::abs(likeliest)) / epsilon_;
    const double wrong = chance_of_error(std::min(here.plausibility, there.plausibility), room) * std::pow(kPerDoubt, doubts);
    const double high = std::min({std::max(crossing->at, 0.0) + kBeyond * epsilon_, result.top, half});
    const double low = std::max({std::min(crossing->at, 0.0) - kBeyond * epsilon_, result.bottom, -half});
    if (wrong > kMostDoubtful || !(high > low)) return result;
    result.confidence = 1 - wrong;
    result.exterior = high;
    result.interior = low;
    result.exterior_of = result.interior_of = result.corners[0];
    return result;
}

}  // namespace palpate
