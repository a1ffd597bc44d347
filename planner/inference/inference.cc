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
// Lenses of reach r leave most crossings at a facet of circumradius ρ to a gap that reaches no farther from its plane than kGap ρ²/2r.
// With 4.5 there are fewer samples and more facets in doubt, with 6.5 it is the other way round, for about as many probes.
constexpr double kGap = 5.0;

}  // namespace

// --- normals ---------------------------------------------------------------------------------------------------------

void Inference::sort_neighbors(const Apex& apex, std::vector<std::uint32_t>& samples) const {
    const Point& p = apex.position;
    std::erase_if(samples, [&](std::uint32_t b) { return (state_.sample(b) - p).norm() > range(); });
    state_.sort_by_distance(p, samples);
}

bool Inference::find_cone(Apex& apex, std::span<const std::uint32_t> neighbors, double share) const {
    const double reach = share * reach_;
    apex.cone = {};
    const auto to = [&](std::uint32_t b) { return Vector(state_.sample(b) - apex.position); };
    const std::size_t n = std::min(neighbors.size(), kPairs);
    for (std::size_t j = 1; j < n && !apex.cone.is_known(); ++j) {
        for (std::size_t i = 0; i < j && !apex.cone.is_known(); ++i) {
            apex.cone.begin(to(neighbors[i]), to(neighbors[j]), apex.outwards, reach, margin_);
        }
    }
    if (!apex.cone.is_known()) return true;
    return std::all_of(neighbors.begin(), neighbors.end(), [&](std::uint32_t b) { return apex.cone.narrow(to(b), reach, margin_); });
}

void Inference::begin(std::uint32_t sample) {
    Apex& apex = apexes_[sample];
    state_.adjacent_samples(sample, neighbors_);
    sort_neighbors(apex, neighbors_);
    if (!find_cone(apex, neighbors_)) {
        refute(sample, apex.position, true);
        apex.cone = {};
    }
}

void Inference::note_sample(std::uint32_t sample, const Vector& outwards) {
    if (apexes_.size() <= sample) apexes_.resize(sample + 1);
    Apex& apex = apexes_[sample];
    apex.position = state_.sample(sample);
    apex.outwards = outwards;
    state_.adjacent_samples(sample, ring_);
    begin(sample);
    for (const std::uint32_t b : ring_) {
        if (b >= apexes_.size() || apexes_[b].outwards.isZero()) continue;
        Apex& other = apexes_[b];
        const Vector to = apex.position - other.position;
        if (to.norm() > range()) continue;
        if (!other.cone.is_known()) {
            begin(b);
        } else if (!other.cone.narrow(to, reach_, margin_)) {
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
        if (!knows(b) || to.norm() < std::sqrt(margin_ * reach_) || apexes_[b].cone.narrow(to, reach_, margin_)) continue;
        refute(b, touched, true);
    }
    Witness witness{{touched, outwards, {}}, {beside.begin(), beside.end()}};
    sort_neighbors(witness.apex, witness.beside);
    begin(witness);
    if (!witness.apex.cone.is_known()) return;
    for (const std::uint32_t b : witness.beside) witnesses_of_[b].push_back(static_cast<std::uint32_t>(witnesses_.size()));
    witnesses_.push_back(std::move(witness));
}

void Inference::begin(Witness& witness) {
    if (!find_cone(witness.apex, witness.beside)) witness.apex.cone = {};
}

// --- refutation ------------------------------------------------------------------------------------------------------

void Inference::check(const Point& x, bool touched, std::span<const std::uint32_t> lenses) {
    for (const std::uint32_t sample : lenses) {
        if (x == state_.sample(sample)) continue;
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

void Inference::contradict(std::span<const std::uint32_t>, const Point& x) {
    if (is_worse(1)) note(1, fmt::format("S was not met at {}, where the bound makes it cross", point_text(x)));
}

void Inference::check_way(const Point& x, std::uint32_t home) {
    check(x, true, samples_around(x, home));
    if (!is_refuted()) note(1, fmt::format("the touch at {} was met on a way that the bound makes free", point_text(x)));
}

void Inference::refute(std::uint32_t sample, const Point& x, bool touched) {
    const Apex& apex = apexes_[sample];
    std::vector<std::uint32_t> neighbors;
    state_.adjacent_samples(sample, neighbors);
    sort_neighbors(apex, neighbors);
    const auto allows = [&](double share) {
        Apex trial{apex.position, apex.outwards, {}};
        if (!find_cone(trial, neighbors, share)) return false;
        if (!trial.cone.is_known() || x == apex.position) return true;
        if (is_within(lens(trial, Side::interior, share), x, touched)) return false;
        return !touched || (!is_within(lens(trial, Side::exterior, share), x, touched) &&
                            trial.cone.narrow(x - trial.position, share * reach_, margin_));
    };
    const double share = largest_share(allows);
    if (!is_worse(share)) return;
    note(share, fmt::format("{} {} contradicts the normals that the samples around {} allow", touched ? "the touch at" : "the free place",
                            point_text(x), point_text(apex.position)));
}

void Inference::note_contradiction(const FacetView& seen) {
    // The samples' own lenses may show it at a smaller bound, too; otherwise all that is known is that this bound is false.
    const auto allows = [&](double share) {
        std::optional<double> exterior;
        std::optional<double> interior;
        for (const auto& [sample, side] : {std::pair{seen.exterior_of, Side::exterior}, {seen.interior_of, Side::interior}}) {
            const Apex& apex = apexes_[sample];
            Apex trial{apex.position, apex.outwards, {}};
            state_.adjacent_samples(sample, neighbors_);
            sort_neighbors(trial, neighbors_);
            if (!find_cone(trial, neighbors_, share)) return false;
            if (!trial.cone.is_known()) return true;
            const auto inside = lens(trial, side, share).clip(seen.line.origin, seen.up);
            if (!inside) return true;
            if (side == Side::exterior) exterior = inside->low;
            if (side == Side::interior) interior = inside->high;
        }
        return *exterior > *interior;
    };
    const double share = largest_share(allows);
    if (!is_worse(share)) return;
    note(share,
         fmt::format("the samples around {} would make a place there free and inside the object at once", point_text(seen.line.origin)));
}

void Inference::lower(double share) {
    reach_ *= share;
    refutation_.reset();
    for (std::uint32_t sample = 0; sample < apexes_.size(); ++sample) {
        apexes_[sample].cone = {};
        if (!apexes_[sample].outwards.isZero()) begin(sample);
    }
    const std::vector<Witness> witnesses = std::move(witnesses_);
    witnesses_.clear();
    witnesses_of_.clear();
    for (const Witness& w : witnesses) note_touch(w.apex.position, w.apex.outwards, w.beside);
}

// --- crossings -------------------------------------------------------------------------------------------------------

std::optional<FacetView> Inference::view(DirectedEdge e) const {
    const std::optional<EdgeSpan> along = state_.span(e);
    if (!along) return std::nullopt;
    Vector outwards = Vector::Zero();
    for (const std::uint32_t v : state_.facet_samples(e)) {
        if (knows(v)) outwards += normal(v);
    }
    if (outwards.isZero()) return std::nullopt;
    FacetView result = look_along(e, *along, outwards);

    const auto look = [&](const Apex& apex, std::uint32_t of) {
        // One sheet of S only: two are 2 r apart.
        const double window = reach_ / 2;
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

std::optional<SurfaceModel::Depth> Inference::inside_below(const Point& place, const Vector& up,
                                                           std::span<const std::uint32_t> samples) const {
    std::optional<Depth> best;
    for (const std::uint32_t v : samples) {
        if (!knows(v)) continue;
        const auto in = lens(v, Side::interior).clip(place, up);
        if (in && (!best || in->high > best->height)) best = Depth{in->high, v};
    }
    return best;
}

double Inference::inferable_radius(std::span<const std::uint32_t>, double epsilon) const {
    return radius_within_ball(kGap * epsilon / reach_) * epsilon;
}

}  // namespace palpate
