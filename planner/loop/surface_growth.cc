#include "planner/loop/surface_growth.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

// Touches may be wrong by that part of ω's radius at least: far above the rounding of dual edges.
constexpr double kMargin = 1e-9;
// Samples within that many ε help to know each other's normals: the ring of neighbours and a little more.
constexpr double kRange = 4.0;
// A bound that was refuted is lowered to what the evidence allows, but at least by this, so that there are few rounds.
constexpr double kLowered = 0.8;
// Below that many ε, lenses are too flat to reach from one sample to the next.
constexpr double kUseful = 2.0;
// Of ε: a local bound begins with that much, which is enough for growth, ...
constexpr double kFirst = 4.0;
// ... and is of no use for inference below that.
constexpr double kLeast = 1.5;
// Of ε: the balls beside samples that guarded motion takes to be free until a touch contradicts.
constexpr double kClearance = 4.0;

bool grows(const Strategy& strategy) {
    return strategy.refine == Strategy::Refine::eager && strategy.explore == Strategy::Explore::closure &&
           strategy.travel == Strategy::Travel::free_space;
}

ReachBound bound(const Options& options) {
    const bool is_local = options.strategy.infer == Strategy::Infer::adaptive;
    if (!is_local) return {*options.reach};
    const double first = kFirst * options.epsilon;
    return {options.reach ? std::min(*options.reach, first) : first, true, kLeast * options.epsilon, kClearance * options.epsilon};
}

}  // namespace

SurfaceGrowth::SurfaceGrowth(ProbedSpace& space, ProbeHead& head, const Options& options, const OracleTraits& traits,
                             const Criteria& criteria, const Observer& observer, Effort& effort)
    : space_(space),
      state_(space.delaunay()),
      head_(head),
      options_(options),
      criteria_(criteria),
      effort_(effort),
      inference_(state_, bound(options), kRange * options.epsilon,
                 std::max(kMargin * state_.surroundings().region().radius(), traits.touch_error)),
      front_(state_, inference_, {options.epsilon, options.standoff.value_or(options.epsilon), options.audit, options.random_seed}),
      travel_(space, head, inference_, options.epsilon, traits.retract),
      grows_(grows(options.strategy)) {
    inference_.watch(observer.on_inference);
    note_seeds(0);
}

void SurfaceGrowth::note_seeds(std::size_t first) {
    for (const Touch& touch : head_.touches()) {
        if (touch.sample && *touch.sample >= first) inference_.note_sample(*touch.sample, touch.from - touch.position);
    }
    front_.sweep();
}

void SurfaceGrowth::note_insertion(const MaintainedDelaunay::Insertion& insertion, const Touch& touch) {
    inference_.note_sample(insertion.sample, touch.from - touch.position);
    front_.note_insertion(insertion);
}

void SurfaceGrowth::withdraw(DirectedEdge e, const Point& free) {
    inference_.contradict(state_.facet_samples(e), free);
    distrust(e);
}

void SurfaceGrowth::distrust(DirectedEdge e) {
    inference_.distrust(e);
    front_.note_edges(e);
}

void SurfaceGrowth::note_thin(DirectedEdge e) {
    if (!inference_.bound().is_local) return;
    const double largest = state_.thickness(e) / 2;
    for (const std::uint32_t sample : state_.facet_samples(e)) {
        front_.note_thin(sample);
        if (inference_.reach(sample) > largest) lower(sample, largest / inference_.reach(sample));
    }
}

std::optional<SurfaceGrowth::Step> SurfaceGrowth::approach(NodeId goal, const std::array<std::uint32_t, 3>& corners) {
    const bool is_thin = std::ranges::any_of(corners, [&](std::uint32_t v) { return front_.is_thin(v); });
    const auto met = grows_ ? travel_.approach(goal, corners, is_thin) : std::nullopt;
    if (!met) return std::nullopt;
    return take_from_way(*met, corners);
}

// --- touching --------------------------------------------------------------------------------------------------------

std::optional<SurfaceGrowth::Step> SurfaceGrowth::step() {
    if (!grows_ || inference_.bound().reach < kUseful * options_.epsilon) return std::nullopt;
    const auto asked = front_.next(space_.roadmap().at(head_.at()));
    if (!asked) return std::nullopt;
    const Point place = state_.sample(std::ranges::max(asked->beside));
    if (effort_.is_spent(place)) {
        effort_.give_up(place);
        return Step{};  // the front asks a few times and then gives the edge up
    }
    if (inference_.bound().is_local && !asked->audit && effort_.is_guesswork(place)) return Step{};
    const std::uint64_t before = head_.cost().probes();
    const Step step = touch(*asked);
    const std::uint64_t probes = head_.cost().probes() - before;
    effort_.note_probes(place, probes);
    effort_.note_guess(place, probes, step.sample || (asked->along && state_.crossed(asked->along->inwards)));
    return step;
}

SurfaceGrowth::Step SurfaceGrowth::touch(const FrontTouch& asked) {
    if (const auto met = travel_.go_to({asked.start, asked.home})) return take_from_way(*met, asked.beside);
    // What a proven bound shows; of what local bounds suggest, crossings of dual edges alone are right in 99 of 100 cases (new samples
    // ahead of creases in 98).
    const bool expects = asked.certain && (asked.along || !inference_.bound().is_local);
    auto met = travel_.probe(asked.target, expects);
    if (met && met->is_failed()) return Step{};  // the front asks a few times and then gives the edge up
    if (!met && asked.under && !asked.certain) met = travel_.probe(*asked.under);
    if (met && met->is_failed()) return Step{};
    if (asked.audit) note_audit(asked, met);
    if (!met) {
        const Point& free = asked.target;
        if (asked.certain) {
            const std::array<std::uint32_t, 1> lens{asked.interior_of};
            inference_.check(free, false, lens);
        }
        if (asked.along) {
            if (const auto inferred = state_.inferred(asked.along->inwards)) withdraw(*inferred, free);
            front_.note_missed(asked.along->corners);
        }
        return Step{};
    }
    const std::array<std::uint32_t, 5> lenses{asked.home, asked.interior_of, asked.beside[0], asked.beside[1], asked.beside[2]};
    inference_.check(met->position, true, lenses);
    if (asked.along) learn_crossing(*asked.along, *met);
    return take(*met, asked.beside);
}

void SurfaceGrowth::note_audit(const FrontTouch& asked, const std::optional<ProbeHead::Answer>& contact) {
    ++evidence_.audited;
    const auto inferred = state_.inferred(asked.along->inwards);
    if (!inferred) return;
    const Crossing& gap = state_.crossing(*inferred);
    const auto height = [&](const Point& p) { return asked.along->up.dot(p - asked.along->line.origin); };
    if (contact && height(contact->position) <= height(gap.near) && height(contact->position) >= height(gap.far)) return;
    ++evidence_.audited_wrong;
    if (contact) inference_.contradict(asked.along->corners, contact->position);  // without contact it is withdrawn
}

SurfaceGrowth::Step SurfaceGrowth::take_from_way(const NearTravel::Met& met, const std::array<std::uint32_t, 3>& beside) {
    if (met.is_failed()) return Step{};
    if (met.on_free_way) {
        inference_.check_way(met.position, beside[0]);
    } else {
        inference_.check(met.position, true, beside);
    }
    return take(met, beside);
}

SurfaceGrowth::Step SurfaceGrowth::take(const ProbeHead::Answer& touched, const std::array<std::uint32_t, 3>& beside) {
    const CellId near = state_.cell_at(beside[0]);
    const double distance = (state_.sample(state_.nearest_sample(touched.position, near)) - touched.position).norm();
    if (criteria_.is_bad(distance, touched.position)) {
        return Step{NewSample{touched.position, near, touched.touch}};
    }
    inference_.note_touch(touched.position, space_.roadmap().at(head_.contact().from) - touched.position, beside);
    return Step{};
}

void SurfaceGrowth::learn_crossing(const FacetView& along, const ProbeHead::Answer& touched) {
    Roadmap& roadmap = space_.roadmap();
    const DirectedEdge e = along.inwards;
    const double height = along.up.dot(touched.position - along.line.origin);
    if (height < along.bottom || height > along.top) return front_.note_missed(along.corners);
    if (criteria_.is_bad((touched.position - state_.sample(along.corners[0])).norm(), touched.position)) return;
    if (const auto inferred = state_.inferred(e)) state_.withdraw(*inferred);
    if (state_.recorded_state(e) != EdgeState::unknown) return;
    // A probe from beyond the edge's exterior end passed it.
    const NodeId start = head_.contact().from;
    const bool beyond = along.up.dot(roadmap.at(start) - along.line.origin) > along.top;
    const NodeId from = beyond ? roadmap.split(start, head_.contact().at, along.at(along.top)) : start;
    space_.learn_contact(e, from, head_.contact().at, touched.touch, false);
    front_.note_edges(e);
}

// --- refutation ------------------------------------------------------------------------------------------------------

bool SurfaceGrowth::settle_refutation() {
    const std::vector<Refutation> found = inference_.take_refutations();
    if (found.empty()) return false;
    if (inference_.bound().is_local) {
        for (const Refutation& refutation : found) {
            // Local bounds never exceed the given one.
            if (refutation.is_proof && options_.reach && refutation.largest < *options_.reach) note_evidence(refutation);
            for (const std::uint32_t sample : refutation.samples) {
                lower(sample, std::min(refutation.share, kLowered));
            }
        }
    } else {
        lower_all(found.front());
    }
    return true;
}

void SurfaceGrowth::note_evidence(const Refutation& refutation) {
    if (evidence_.refuted && refutation.largest >= evidence_.largest) return;
    evidence_.refuted = true;
    evidence_.largest = refutation.largest;
    evidence_.detail = refutation.evidence;
}

void SurfaceGrowth::lower(std::uint32_t sample, double share) {
    inference_.lower(sample, share);
    travel_.forget(sample);
    for (const CellId cell : state_.cells_around(sample)) {
        for (int i = 0; i < 4; ++i) {
            const auto inferred = state_.is_finite({cell, i}) ? state_.inferred({cell, i}) : std::nullopt;
            if (!inferred) continue;
            state_.withdraw(*inferred);
            front_.reconsider(*inferred);
        }
    }
}

void SurfaceGrowth::lower_all(const Refutation& found) {
    note_evidence(found);
    state_.for_each_edge([&](DirectedEdge e) {
        if (state_.recorded_state(e) == EdgeState::crossing && state_.crossing(e).inferred) state_.withdraw(e);
    });
    travel_.forget_all();
    inference_.lower(std::min(found.share, kLowered));
    front_.sweep();
}

ReachEvidence SurfaceGrowth::evidence() const {
    ReachEvidence evidence = evidence_;
    evidence.is_local = inference_.bound().is_local;
    evidence.used = inference_.bound().reach;
    return evidence;
}

}  // namespace palpate
