#include "planner/inference/inference.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "planner/number_text.h"

namespace palpate {
namespace {

// Neighbours that a cone is begun with: some pair of the nearest ones spans the tangent plane.
constexpr std::size_t kPairs = 8;
// Samples farther from a facet's centre than this many of its circumradii do not help to see where S crosses.
constexpr double kNear = 3.0;
// The largest bound that evidence allows is found to one part in that.
constexpr int kBisections = 30;
// Of the radius of curvature that its neighbours show, a sample's local bound is at most that.
constexpr double kCaution = 0.5;
// A clearance that a touch contradicts becomes smaller than the touch allows.
constexpr double kBlocked = 0.8;

}  // namespace

double FacetView::ball_radius() const { return std::hypot(line.circumradius, std::max(std::abs(*exterior), std::abs(*interior))); }

// --- normals ---------------------------------------------------------------------------------------------------------

void Inference::sort_neighbors(const Apex& apex, std::vector<std::uint32_t>& samples) const {
    const Point& p = apex.position;
    std::erase_if(samples, [&](std::uint32_t b) { return (state_.sample(b) - p).norm() > range(apex); });
    state_.sort_by_distance(p, samples);
}

bool Inference::find_cone(Apex& apex, std::span<const std::uint32_t> neighbors) const {
    apex.cone = {};
    const auto to = [&](std::uint32_t b) { return Vector(state_.sample(b) - apex.position); };
    const std::size_t n = std::min(neighbors.size(), kPairs);
    for (std::size_t j = 1; j < n && !apex.cone.is_known(); ++j) {
        for (std::size_t i = 0; i < j && !apex.cone.is_known(); ++i) {
            apex.cone.begin(to(neighbors[i]), to(neighbors[j]), apex.outwards, apex.reach, margin_);
        }
    }
    if (!apex.cone.is_known()) return true;
    return std::all_of(neighbors.begin(), neighbors.end(), [&](std::uint32_t b) { return apex.cone.narrow(to(b), apex.reach, margin_); });
}

void Inference::begin(std::uint32_t sample) {
    Apex& apex = apexes_[sample];
    if (apex.reach < bound_.least) return;
    state_.adjacent_samples(sample, neighbors_);
    sort_neighbors(apex, neighbors_);
    if (!find_cone(apex, neighbors_)) {
        refute(sample, apex.position, true);
        apex.cone = {};
    }
    if (!bound_.is_local || !apex.cone.is_known()) return;
    apex.normal = apex.cone.axis();
    double share = 1;
    for (const std::uint32_t b : neighbors_) share = std::min(share, curvature_share(apex, state_.sample(b) - apex.position));
    if (share < 1) note({{sample}, share, 0, {}, false});
}

double Inference::curvature_share(const Apex& apex, const Vector& to) const {
    const double curvature = 2 * std::abs(to.dot(apex.normal)) / to.squaredNorm();
    return curvature * apex.reach > kCaution ? kCaution / (curvature * apex.reach) : 1;
}

Lens Inference::clearance(std::uint32_t sample) const {
    const Apex& apex = apexes_[sample];
    if (!bound_.is_local) return lens(apex, Side::exterior);
    return {apex.position, {&apex.normal, 1}, apex.clearance, margin_, Side::exterior};
}

// The tool touched S at x: that was not free.
void Inference::block(std::uint32_t sample, const Point& x) {
    Apex& apex = apexes_[sample];
    const Vector v = x - apex.position;
    const double height = v.dot(apex.normal);
    if (height > 0) apex.clearance = std::min(apex.clearance, kBlocked * v.squaredNorm() / (2 * height));
}

void Inference::note_sample(std::uint32_t sample, const Vector& outwards) {
    if (apexes_.size() <= sample) apexes_.resize(sample + 1);
    Apex& apex = apexes_[sample];
    apex.position = state_.sample(sample);
    apex.outwards = outwards;
    state_.adjacent_samples(sample, ring_);
    apex.reach = first_reach(sample);
    apex.normal = outwards.normalized();
    apex.clearance = bound_.clearance;
    begin(sample);
    for (const std::uint32_t b : ring_) {
        if (b >= apexes_.size() || apexes_[b].outwards.isZero()) continue;
        Apex& other = apexes_[b];
        const Vector to = apex.position - other.position;
        if (to.norm() > range(other)) continue;
        if (!other.cone.is_known()) {
            begin(b);
        } else if (other.cone.narrow(to, other.reach, margin_)) {
            if (!bound_.is_local) continue;
            other.normal = other.cone.axis();
            const double share = curvature_share(other, to);
            if (share < 1) note({{b}, share, 0, {}, false});
        } else {
            refute(b, apex.position, true);
            other.cone = {};
        }
    }
}

void Inference::note_touch(const Point& touched, const Vector& outwards, std::span<const std::uint32_t> beside) {
    check(touched, true, beside);
    for (const std::uint32_t b : beside) {
        const Vector to = touched - state_.sample(b);
        // Nearer than its own margin a touch says nothing on the normal.
        if (!knows(b) || to.norm() < std::sqrt(margin_ * reach(b)) || apexes_[b].cone.narrow(to, reach(b), margin_)) continue;
        refute(b, touched, true);
    }
    Witness witness{{touched, outwards, bound_.reach, {}}, {beside.begin(), beside.end()}};
    sort_neighbors(witness.apex, witness.beside);
    begin(witness);
    if (!witness.apex.cone.is_known()) return;
    for (const std::uint32_t b : witness.beside) witnesses_of_[b].push_back(static_cast<std::uint32_t>(witnesses_.size()));
    witnesses_.push_back(std::move(witness));
}

void Inference::begin(Witness& witness) {
    Apex& apex = witness.apex;
    for (const std::uint32_t b : witness.beside) apex.reach = std::min(apex.reach, reach(b));
    if (apex.reach < bound_.least || !find_cone(apex, witness.beside)) apex.cone = {};
}

// --- refutation ------------------------------------------------------------------------------------------------------

void Inference::check(const Point& x, bool touched, std::span<const std::uint32_t> lenses) {
    for (const std::uint32_t sample : lenses) {
        if (x == state_.sample(sample)) continue;
        if (bound_.is_local && touched && has_clearance(sample) && is_within(clearance(sample), x, touched)) block(sample, x);
        if (!knows(sample)) continue;
        if (!is_within(lens(sample, Side::interior), x, touched) && !(touched && is_within(lens(sample, Side::exterior), x, touched)))
            continue;
        refute(sample, x, touched);
    }
}

bool Inference::is_within(Lens lens, const Point& x, bool touched) const {
    if (touched) lens.margin += margin_;
    return lens.contains(x);
}

// The largest share of a bound that is allowed.
template <typename Allows>
static double largest_share(const Allows& allows) {
    double good = 0;
    double bad = 1;
    for (int k = 0; k < kBisections; ++k) {
        const double middle = (good + bad) / 2;
        (allows(middle) ? good : bad) = middle;
    }
    return bad;
}

void Inference::note(Refutation refutation) {
    for (const std::uint32_t sample : refutation.samples) {
        refutation.largest = std::max(refutation.largest, refutation.share * reach(sample));
    }
    if (!bound_.is_local) refutations_.clear();
    refutations_.push_back(std::move(refutation));
}

void Inference::contradict(std::span<const std::uint32_t> samples, const Point& x) {
    if (!is_worse(1)) return;
    note({{samples.begin(), samples.end()}, 1, 0, fmt::format("S was not met at {}, where the bound makes it cross", point_text(x))});
}

void Inference::check_way(const Point& x, std::uint32_t home) {
    const std::uint32_t nearest = state_.nearest_sample(x, state_.cell_at(home));
    std::vector<std::uint32_t> lenses;
    state_.adjacent_samples(nearest, lenses);
    lenses.push_back(nearest);
    const double clearance_before = apexes_[nearest].clearance;
    check(x, true, lenses);
    if (bound_.is_local && apexes_[nearest].clearance == clearance_before) apexes_[nearest].clearance *= kBlocked;
    if (bound_.is_local || is_refuted()) return;
    note({{nearest}, 1, 0, fmt::format("the touch at {} was met on a way that the bound makes free", point_text(x))});
}

void Inference::refute(std::uint32_t sample, const Point& x, bool touched) {
    const Apex& apex = apexes_[sample];
    std::vector<std::uint32_t> neighbors;
    state_.adjacent_samples(sample, neighbors);
    sort_neighbors(apex, neighbors);
    const auto allows = [&](double share) {
        Apex trial{apex.position, apex.outwards, share * apex.reach, {}};
        if (!find_cone(trial, neighbors)) return false;
        if (!trial.cone.is_known() || x == apex.position) return true;
        if (is_within(lens(trial, Side::interior), x, touched)) return false;
        return !touched ||
               (!is_within(lens(trial, Side::exterior), x, touched) && trial.cone.narrow(x - trial.position, trial.reach, margin_));
    };
    const double share = largest_share(allows);
    if (!is_worse(share)) return;
    note({{sample},
          share,
          0,
          fmt::format("{} {} contradicts the normals that the samples around {} allow", touched ? "the touch at" : "the free place",
                      point_text(x), point_text(apex.position))});
}

void Inference::refute(const FacetView& seen) {
    // The samples' own lenses may show it at a smaller bound, too; otherwise all that is known is that this bound is false.
    const auto allows = [&](double share) {
        std::optional<double> exterior;
        std::optional<double> interior;
        for (const auto& [sample, side] : {std::pair{seen.exterior_of, Side::exterior}, {seen.interior_of, Side::interior}}) {
            const Apex& apex = apexes_[sample];
            Apex trial{apex.position, apex.outwards, share * apex.reach, {}};
            state_.adjacent_samples(sample, neighbors_);
            sort_neighbors(trial, neighbors_);
            if (!find_cone(trial, neighbors_)) return false;
            if (!trial.cone.is_known()) return true;
            const auto inside = lens(trial, side).clip(seen.line.origin, seen.up);
            if (!inside) return true;
            if (side == Side::exterior) exterior = inside->low;
            if (side == Side::interior) interior = inside->high;
        }
        return *exterior > *interior;
    };
    const double share = largest_share(allows);
    if (!is_worse(share)) return;
    note({{seen.exterior_of, seen.interior_of},
          share,
          0,
          fmt::format("the samples around {} would make a place there free and inside the object at once", point_text(seen.line.origin))});
}

void Inference::lower(double share) {
    bound_.reach *= share;
    refutations_.clear();
    for (std::uint32_t sample = 0; sample < apexes_.size(); ++sample) {
        apexes_[sample].cone = {};
        apexes_[sample].reach = bound_.reach;
        if (!apexes_[sample].outwards.isZero()) begin(sample);
    }
    const std::vector<Witness> witnesses = std::move(witnesses_);
    witnesses_.clear();
    witnesses_of_.clear();
    for (const Witness& w : witnesses) note_touch(w.apex.position, w.apex.outwards, w.beside);
}

void Inference::lower(std::uint32_t sample, double share) {
    Apex& apex = apexes_[sample];
    apex.reach *= share;
    apex.cone = {};
    if (!apex.outwards.isZero()) begin(sample);
    const auto found = witnesses_of_.find(sample);
    if (found == witnesses_of_.end()) return;
    for (const std::uint32_t w : found->second) begin(witnesses_[w]);
}

// What was refuted beside a new sample is not believed there either: distances to the medial axis differ by no more than samples do.
double Inference::first_reach(std::uint32_t sample) const {
    double reach = bound_.reach;
    if (!bound_.is_local) return reach;
    for (const std::uint32_t b : ring_) {
        if (b < apexes_.size() && apexes_[b].reach > 0)
            reach = std::min(reach, apexes_[b].reach + (state_.sample(b) - state_.sample(sample)).norm());
    }
    return reach;
}

// --- crossings -------------------------------------------------------------------------------------------------------

std::optional<FacetView> Inference::view(DirectedEdge e) const {
    const std::optional<EdgeSpan> along = state_.span(e);
    if (!along) return std::nullopt;
    FacetView result;
    result.corners = state_.facet_samples(e);
    Vector normal = Vector::Zero();
    for (const std::uint32_t v : result.corners) {
        if (has_clearance(v)) normal += this->normal(v);
    }
    if (normal.isZero()) return std::nullopt;
    result.line = along->line;
    const double outwards = normal.dot(along->line.direction) >= 0 ? 1 : -1;
    result.up = outwards * along->line.direction;
    const double start = outwards * along->start;
    const double end = outwards * along->end;
    result.inwards = start >= end ? e : state_.opposite(e);
    result.top = std::max(start, end);
    result.bottom = std::min(start, end);

    const auto look = [&](const Apex& apex, std::uint32_t of) {
        // One sheet of S only: two are 2 r apart.
        const double window = apex.reach / 2;
        const auto outside = lens(apex, Side::exterior).clip(result.line.origin, result.up);
        if (outside && outside->low < window && outside->high > -window && (!result.exterior || outside->low < *result.exterior)) {
            result.exterior = outside->low;
            result.exterior_of = of;
        }
        const auto inside = lens(apex, Side::interior).clip(result.line.origin, result.up);
        if (inside && inside->low < window && inside->high > -window && (!result.interior || inside->high > *result.interior)) {
            result.interior = inside->high;
            result.interior_of = of;
        }
    };
    const auto look_from = [&](std::uint32_t sample) {
        if (knows(sample)) look(apexes_[sample], sample);
        if (witnesses_.empty()) return;
        const auto found = witnesses_of_.find(sample);
        if (found == witnesses_of_.end()) return;
        for (const std::uint32_t w : found->second) {
            if (witnesses_[w].apex.cone.is_known()) look(witnesses_[w].apex, sample);
        }
    };
    for (const std::uint32_t v : result.corners) look_from(v);
    const DirectedEdge back = state_.opposite(e);
    for (const auto& beyond : {state_.sample_of(e.cell, e.facet), state_.sample_of(back.cell, back.facet)}) {
        if (beyond && (state_.sample(*beyond) - result.line.origin).norm() < kNear * result.line.circumradius) look_from(*beyond);
    }
    return result;
}

void Inference::distrust(DirectedEdge e) {
    distrusted_.insert(in_order(state_.facet_samples(e)));
    state_.withdraw(e);
}

std::optional<DirectedEdge> Inference::infer(DirectedEdge e, double max_ball_radius) {
    if (state_.crossed(e)) return std::nullopt;
    const std::optional<FacetView> seen = view(e);
    if (seen && seen->is_contradictory()) {
        refute(*seen);
        return std::nullopt;
    }
    if (!seen || !seen->is_crossed() || seen->ball_radius() > max_ball_radius) return std::nullopt;
    if (state_.recorded_state(seen->inwards) != EdgeState::unknown) return std::nullopt;
    if (!distrusted_.empty() && distrusted_.contains(in_order(seen->corners))) return std::nullopt;
    state_.learn_inferred(seen->inwards, seen->at(*seen->exterior), seen->at(*seen->interior));
    if (watcher_) watcher_(seen->at(*seen->exterior), seen->at(*seen->interior));
    return seen->inwards;
}

}  // namespace palpate
