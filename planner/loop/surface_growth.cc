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
// Of ε: a touch on the way to an audit that is nearer to the facet than that says that the facet is wrong.
constexpr double kNearFacet = 1.5;
// Of ε: touches begin so far above S if nothing else is asked for. With 1, 0.35 in place of 0.5: 19 % more, 1 % less way on eight objects.
constexpr double kStandoff = 0.5;
// Of the trust: a facet that is more likely wrong than that is touched. All facets together are far less (planner/README.md).
constexpr double kPerTrust = 8.0;
// Of ε: with a tolerance, touches that are so far from all samples become samples, whatever they were made for: the curved surface is the
// nearer for it. With 0.5 it is as near on smooth parts, but takes a tenth more touches on a bunny; with 0.7 it leaves places on that where
// it is off.
constexpr double kSpacingOfTouches = 0.3;

bool grows(const Strategy& strategy) {
    return strategy.refine == Strategy::Refine::eager && strategy.explore == Strategy::Explore::closure &&
           strategy.travel == Strategy::Travel::free_space;
}

// Touches may be wrong by that, mm.
double margin(const ProbedSpace& space, const OracleTraits& traits) {
    return std::max(kMargin * space.delaunay().surroundings().region().radius(), traits.touch_error);
}

bool guesses(const Options& options) { return options.inference() == Strategy::Infer::adaptive; }

}  // namespace

SurfaceGrowth::SurfaceGrowth(ProbedSpace& space, ProbeHead& head, const Options& options, const OracleTraits& traits,
                             const Criteria& criteria, const Observer& observer, Effort& effort)
    : space_(space),
      state_(space.delaunay()),
      head_(head),
      options_(options),
      criteria_(criteria),
      effort_(effort),
      proof_(guesses(options) ? nullptr
                              : std::make_unique<Inference>(state_, *options.reach, kRange * options.epsilon, margin(space, traits))),
      plausibility_(guesses(options) ? std::make_unique<Plausibility>(state_, options.epsilon, margin(space, traits)) : nullptr),
      model_(proof_ ? static_cast<SurfaceModel&>(*proof_) : *plausibility_),
      front_(state_, model_, {options.epsilon, options.standoff.value_or(kStandoff * options.epsilon)}),
      travel_(space, head, model_, options.epsilon, traits.retract),
      audit_(options.audit, options.random_seed),
      grows_(grows(options.strategy)) {
    model_.watch(observer.on_inference);
    note_seeds(0);
}

void SurfaceGrowth::note_seeds(std::size_t first) {
    for (const Touch& touch : head_.touches()) {
        if (touch.sample && *touch.sample >= first) model_.note_sample(*touch.sample, touch.from - touch.position);
    }
    front_.sweep();
}

void SurfaceGrowth::note_insertion(const MaintainedDelaunay::Insertion& insertion, const Touch& touch) {
    model_.note_sample(insertion.sample, touch.from - touch.position);
    if (touch.is_known && state_.surroundings().area()) ++wall_samples_;
    front_.note_insertion(insertion);
}

void SurfaceGrowth::note_other_touch(const Point& at, const Point& from) {
    const std::array<std::uint32_t, 1> beside{state_.nearest_sample(at, state_.cell_at(0))};
    model_.note_touch(at, from - at, beside);
}

void SurfaceGrowth::withdraw(DirectedEdge e, const Point& free) {
    model_.contradict(state_.facet_samples(e), free);
    distrust(e);
}

void SurfaceGrowth::distrust(DirectedEdge e) {
    model_.distrust(e);
    front_.note_edges(e);
}

void SurfaceGrowth::note_thin(DirectedEdge e) {
    if (!plausibility_) return;
    for (const std::uint32_t sample : state_.facet_samples(e)) {
        front_.note_thin(sample);
        plausibility_->doubt(sample);
    }
    // From this end S was touched.
    const DirectedEdge back = state_.opposite(e);
    if (state_.recorded_state(back) == EdgeState::crossing && state_.crossing(back).inferred) distrust(back);
}

std::optional<SurfaceGrowth::Step> SurfaceGrowth::approach(NodeId goal, const std::array<std::uint32_t, 3>& corners) {
    const bool is_thin = std::ranges::any_of(corners, [&](std::uint32_t v) { return front_.is_thin(v); });
    const auto met = grows_ ? travel_.approach(goal, corners, is_thin) : std::nullopt;
    if (!met) return std::nullopt;
    return take_from_way(*met, corners);
}

// --- touching --------------------------------------------------------------------------------------------------------

std::optional<SurfaceGrowth::Step> SurfaceGrowth::step() {
    if (!can_touch()) return std::nullopt;
    const auto asked = front_.next(space_.roadmap().at(head_.at()));
    if (!asked) return std::nullopt;
    const Point place = state_.sample(std::ranges::max(asked->beside));
    if (effort_.is_spent(place)) {
        asked->audit ? audit_.note_barred() : effort_.give_up(place);
        return Step{};  // the front asks a few times and then gives the edge up
    }
    if (plausibility_ && !asked->audit && effort_.is_guesswork(place)) return Step{};
    const std::uint64_t before = head_.cost().probes();
    const Step step = touch(*asked);
    const std::uint64_t probes = head_.cost().probes() - before;
    effort_.note_probes(place, probes);
    effort_.note_guess(place, probes, step.sample || (asked->along && state_.crossed(asked->along->inwards)));
    return step;
}

SurfaceGrowth::Step SurfaceGrowth::look_up(const FrontTouch& asked) {
    if (!asked.known) {
        if (asked.along) front_.note_missed(asked.along->corners);
        return Step{};
    }
    const Point& at = *asked.known;
    const CellId near = state_.cell_at(asked.beside[0]);
    const double distance = (state_.sample(state_.nearest_sample(at, near)) - at).norm();
    if (criteria_.is_bad(distance, at)) return Step{NewSample{at, near, head_.note_known(at, asked.start)}};
    if (!asked.along) return Step{};
    const FacetView& edge = *asked.along;
    const double height = edge.up.dot(at - edge.line.origin);
    const double around = KnownSolids::kGap * options_.epsilon;
    if (state_.recorded_state(edge.inwards) != EdgeState::unknown || model_.is_distrusted(edge.corners) || height - around < edge.bottom ||
        height + around > edge.top) {
        front_.note_missed(edge.corners);
        return Step{};
    }
    state_.learn_inferred(edge.inwards, edge.at(height + around), edge.at(height - around));
    front_.note_edges(edge.inwards);
    return Step{};
}

SurfaceGrowth::Step SurfaceGrowth::touch_foretold(const Point& place, const Vector& normal, const std::array<std::uint32_t, 3>& beside,
                                                  double spacing) {
    FrontTouch asked;
    asked.start = place + options_.standoff.value_or(kStandoff * options_.epsilon) * normal;
    asked.target = place - options_.epsilon * normal;
    asked.expected = true;
    asked.spacing = spacing;
    asked.beside = beside;
    asked.home = asked.interior_of = beside[0];
    return touch(asked);
}

SurfaceGrowth::Step SurfaceGrowth::touch(const FrontTouch& asked) {
    if (asked.known || asked.is_buried) return look_up(asked);
    if (const auto met = travel_.go_to({asked.start, asked.home})) {
        if (asked.audit) note_barred_audit(asked, *met);
        return take_from_way(*met, asked.beside);
    }
    auto met = travel_.probe(asked.target, asked.expected);
    if (!met && asked.under && !asked.certain) met = travel_.probe(*asked.under);
    if (met && met->is_failed()) {
        if (asked.audit) audit_.note_barred();
        return Step{};  // the front asks a few times and then gives the edge up
    }
    if (asked.audit) note_audit(asked, met);
    if (!met) {
        const Point& free = asked.target;
        if (asked.certain) {
            const std::array<std::uint32_t, 1> lens{asked.interior_of};
            model_.check(free, false, lens);
        }
        if (asked.along) {
            if (const auto inferred = state_.inferred(asked.along->inwards)) withdraw(*inferred, free);
            front_.note_missed(asked.along->corners);
        }
        return Step{};
    }
    const std::array<std::uint32_t, 5> lenses{asked.home, asked.interior_of, asked.beside[0], asked.beside[1], asked.beside[2]};
    model_.check(met->position, true, lenses);
    if (asked.along) learn_crossing(*asked.along, *met);
    Step step = take(*met, asked.beside, asked.spacing);
    if (!met->is_known) step.met = met->position;
    return step;
}

bool SurfaceGrowth::is_known(DirectedEdge e) const {
    const auto facet = state_.facet_samples(e);
    return state_.are_known(facet) && front_.is_far_from_object(state_.sample(facet[0]));
}

bool SurfaceGrowth::begin_audit() {
    if (!can_touch()) return false;
    std::vector<Audit::Facet> inferred;
    for_each_inferred([&](DirectedEdge e) {
        if (!is_known(e)) inferred.push_back(in_order(state_.facet_samples(e)));
    });
    const std::vector<Audit::Facet> drawn = audit_.draw(std::move(inferred), state_.sample_count(), counted_samples());
    for (const Audit::Facet& facet : drawn) front_.note_audit(*state_.find_facet(facet[0], facet[1], facet[2]));
    return !drawn.empty();
}

std::size_t SurfaceGrowth::audit_quota() const {
    constexpr std::size_t kFacetsPerSample = 2;  // nearly all of them are inferred
    return audit_.quota(kFacetsPerSample * counted_samples(), counted_samples());
}

std::uint64_t SurfaceGrowth::audits_left() const {
    const std::size_t quota = audit_quota();
    return can_touch() && quota > audit_.touched() ? quota - audit_.touched() : 0;
}

// S was met on the way to where the touch was to begin. Near the facet, that is where S was not expected.
void SurfaceGrowth::note_barred_audit(const FrontTouch& asked, const NearTravel::Met& met) {
    if (!met.is_failed() && (met.position - asked.along->line.origin).norm() < kNearFacet * options_.epsilon) return audit_.note(false);
    audit_.note_barred();
}

bool SurfaceGrowth::can_touch() const { return grows_ && !(proof_ && proof_->reach() < kUseful * options_.epsilon); }

void SurfaceGrowth::note_audit(const FrontTouch& asked, const std::optional<ProbeHead::Answer>& contact) {
    const auto inferred = state_.inferred(asked.along->inwards);
    if (!inferred) return;
    const Crossing& gap = state_.crossing(*inferred);
    const auto height = [&](const Point& p) { return asked.along->up.dot(p - asked.along->line.origin); };
    const bool is_above = contact && height(contact->position) > height(gap.near);
    const bool is_below = contact && height(contact->position) < height(gap.far);
    audit_.note(contact && !is_above && !is_below);
    // What was passed is free. Without contact all was, and the caller says so.
    if (is_below) withdraw(*inferred, Point(gap.far));
    if (is_above) distrust(*inferred);
}

SurfaceGrowth::Step SurfaceGrowth::take_from_way(const NearTravel::Met& met, const std::array<std::uint32_t, 3>& beside) {
    if (met.is_failed()) return Step{};
    if (met.on_free_way) {
        model_.check_way(met.position, beside[0]);
    } else {
        model_.check(met.position, true, beside);
    }
    return take(met, beside);
}

SurfaceGrowth::Step SurfaceGrowth::take(const ProbeHead::Answer& touched, const std::array<std::uint32_t, 3>& beside,
                                        const std::optional<double>& spacing) {
    const CellId near = state_.cell_at(beside[0]);
    const double distance = (state_.sample(state_.nearest_sample(touched.position, near)) - touched.position).norm();
    const auto wanted = !spacing && options_.tolerance ? std::optional(kSpacingOfTouches * options_.epsilon) : spacing;
    if (wanted ? distance > *wanted : criteria_.is_bad(distance, touched.position)) {
        return Step{NewSample{touched.position, near, touched.touch}};
    }
    model_.note_touch(touched.position, space_.roadmap().at(head_.contact().from) - touched.position, beside);
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
    if (proof_) {
        const std::optional<Refutation> found = proof_->take_refutation();
        if (found) lower_all(*found);
        return found.has_value();
    }
    std::vector<std::uint32_t> doubted = plausibility_->take_doubted();
    std::ranges::sort(doubted);
    doubted.erase(std::unique(doubted.begin(), doubted.end()), doubted.end());
    for (const std::uint32_t sample : doubted) reconsider_around(sample);
    return !doubted.empty();
}

void SurfaceGrowth::note_evidence(const Refutation& refutation) {
    if (evidence_.refuted && refutation.largest >= evidence_.largest) return;
    evidence_.refuted = true;
    evidence_.largest = refutation.largest;
    evidence_.detail = refutation.evidence;
}

void SurfaceGrowth::reconsider_around(std::uint32_t sample) {
    for (const CellId cell : state_.cells_around(sample)) {
        for (int i = 0; i < 4; ++i) {
            const auto inferred = state_.is_finite({cell, i}) ? state_.inferred({cell, i}) : std::nullopt;
            if (!inferred) continue;
            state_.withdraw(*inferred);
            front_.reconsider(*inferred);
        }
    }
}

void SurfaceGrowth::sweep() {
    front_.sweep();
    if (!plausibility_) return;
    std::vector<DirectedEdge> doubtful;
    for_each_inferred([&](DirectedEdge e) {
        if (is_known(e)) return;
        const double right = confidence(e);
        if (right == 0 || 1 - right > kPerTrust * options_.trust) doubtful.push_back(e);
    });
    for (const DirectedEdge e : doubtful) distrust(e);
}

void SurfaceGrowth::lower_all(const Refutation& found) {
    note_evidence(found);
    for_each_inferred([&](DirectedEdge e) { state_.withdraw(e); });
    travel_.forget_all();
    proof_->lower(std::min(found.share, kLowered));
    front_.sweep();
}

double SurfaceGrowth::confidence(DirectedEdge e) const {
    if (is_known(e)) return 1;
    const std::optional<FacetView> seen = model_.view(e);
    return seen && seen->is_crossed() ? seen->confidence : 0;
}

ReachEvidence SurfaceGrowth::evidence() const {
    ReachEvidence evidence = evidence_;
    evidence.audited = audit_.touched();
    evidence.audited_wrong = audit_.wrong();
    evidence.audit_barred = audit_.barred() + front_.audits_barred();
    evidence.is_plausible = plausibility_ != nullptr;
    evidence.used = proof_ ? proof_->reach() : 0;
    return evidence;
}

}  // namespace palpate
