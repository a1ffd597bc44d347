#include "planner/loop/probing_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "planner/errors.h"
#include "planner/loop/budget.h"
#include "planner/loop/graze.h"

namespace palpate {
namespace {

// Of ε: see ProbeWatch.
constexpr double kLongestHop = 6.0;

constexpr const char* kTooClose = "ProbingLoop: a sample would break the packing bound that termination rests on";

// Balls of half the spacing around samples are disjoint and lie in ω, grown by half the spacing.
std::size_t packing_bound(const Region& region, double spacing) {
    const double bound = std::pow((region.radius() + spacing / 2) / (spacing / 2), 3);
    constexpr double kBeyondAnyRun = 1e18;  // fits a size_t, with room for the seeds
    return static_cast<std::size_t>(std::min(bound, kBeyondAnyRun)) + 1;
}

// mm: samples nearer to each other than that show errors of touches rather than the surface.
double least_useful_spacing(double tolerance, double touch_error) {
    constexpr double kTouchErrors = 20.0;  // planner/DESIGN.md, "Numerics"
    return std::max(tolerance, kTouchErrors * touch_error);
}

std::optional<ProbeWatch> watch_for(const Options& options, const OracleTraits& traits) {
    if (!traits.overtravel) return std::nullopt;
    // Adaptive motion waits for no proof; the others keep to what is proven.
    const bool hops = options.inference() == Strategy::Infer::adaptive;
    return ProbeWatch(*traits.overtravel, options.epsilon, hops ? kLongestHop * options.epsilon : 0.0);
}

}  // namespace

ProbingLoop::ProbingLoop(SurfaceOracle& oracle, const Surroundings& surroundings, const Options& options, const Observer& observer)
    : options_(options),
      traits_(oracle.traits()),
      observer_(observer),
      criteria_(options),
      space_(surroundings, traits_.touch_error),
      state_(space_.delaunay()),
      walls_(options.epsilon, criteria_.repair_spacing()),
      effort_(options.epsilon),
      repair_(state_, options, traits_, criteria_, walls_),
      head_(oracle, surroundings, space_.roadmap(), watch_for(options, traits_)),
      walk_(state_, options.strategy.explore),
      progress_(options.epsilon) {}

void ProbingLoop::execute() {
    try {
        probe_all();
    } catch (const SeedError&) {
        if (options_.goes_home) head_.go_home(observer_.on_home);
        throw;
    }
    head_.end_of_run();
    if (options_.goes_home) head_.go_home(observer_.on_home);
}

void ProbingLoop::seed() {
    if (!options_.earlier.empty()) {
        earlier_.emplace(options_, traits_.touch_error, criteria_, space_, head_);
        return;
    }
    const std::vector<SeedFacet> seeds = touch_seeds(options_, space_, head_);
    for (const SeedFacet& seed : seeds) faceted_.insert(seed.samples.begin(), seed.samples.end());
}

void ProbingLoop::probe_all() {
    report();  // the first moves may take long
    seed();
    // Seeds are exempt from the spacing; there are few of them.
    max_samples_ = state_.sample_count() + packing_bound(state_.surroundings().region(), criteria_.least_spacing());
    if (options_.inference() != Strategy::Infer::none) growth_.emplace(space_, head_, options_, traits_, criteria_, observer_, effort_);
    if (growth_ && options_.tolerance) {
        const double spacing_min = options_.spacing_min.value_or(least_useful_spacing(*options_.tolerance, traits_.touch_error));
        tolerance_.emplace(ToleranceSearch::Options{*options_.tolerance, options_.epsilon, spacing_min, traits_.touch_error,
                                                    options_.random_seed, options_.tolerance_box});
    }
    if (earlier_) touch_earlier_places();
    walk_.sweep();
    while ((stopped_by_ = used_up(options_.budget, head_.cost(), traits_.rates)).empty()) {
        if (grow()) continue;
        if (const auto e = walk_.next()) {
            explore(*e);
            continue;
        }
        if (insert_worst()) continue;
        // What follows is linear in the sample and happens a few times in a run.
        walk_.sweep();
        if (growth_) growth_->sweep();
        if (grow() || walk_.next() || explore_unrepresented() || repair_defects() || refine_facets() || approach_tolerance()) continue;
        if (growth_ && growth_->begin_audit()) continue;
        break;
    }
}

void ProbingLoop::touch_earlier_places() {
    for (const EarlierTouches::Other& touch : earlier_->others()) growth_->note_other_touch(touch.position, touch.from);
    const double no_sample = std::numeric_limits<double>::infinity();
    const auto normal = [&](std::uint32_t sample) { return growth_->normal(sample); };
    while (const auto place = earlier_->next(normal)) {
        const std::size_t touches = head_.touches().size();
        const std::uint64_t failed = head_.cost().failed;
        const SurfaceGrowth::Step step =
            growth_->touch_foretold(place->at, place->outwards, {place->sample, place->sample, place->sample}, no_sample);
        note_touches();
        EarlierTouches::Found found{step.met, {}, head_.cost().failed > failed};
        if (!step.met && head_.touches().size() > touches) found.on_the_way = head_.touches().back().position;
        earlier_->note(*place, found);
        add_sample_of(step);
        while (growth_->settle_refutation()) {
        }
        report();
    }
    head_.end_of_seeding();
}

void ProbingLoop::explore(DirectedEdge e) {
    // The facet's newest sample: first touches have facets everywhere for a while.
    const Point place = state_.sample(std::ranges::max(state_.facet_samples(e)));
    if (effort_.is_spent(place)) {
        effort_.give_up(place);
        return state_.note_failed(e);
    }
    const std::uint64_t before = head_.cost().probes();
    probe(e);
    effort_.note_probes(place, head_.cost().probes() - before);
}

void ProbingLoop::probe(DirectedEdge e) {
    const std::optional<EdgeSpan> along = state_.span(e);
    if (!along) throw std::logic_error("ProbingLoop: an edge outside the workspace is to be probed");
    if (growth_ && growth_->infer(e)) return walk_.note_crossing(*state_.crossed(e));
    if (along->starts_on_boundary && !state_.surroundings().is_enterable(along->start_point())) return state_.note_failed(e);
    const NodeId start = space_.start_of(e, *along);
    if (growth_) {
        if (const auto met = growth_->approach(start, state_.facet_samples(e))) {
            add_sample_of(*met);
            return;
        }
    }
    const auto facet = state_.facet_samples(e);
    const bool was_in_surface = state_.in_surface(e);
    head_.go_to(start);
    const ProbeHead::Answer answer = head_.probe(space_.end_of(e, *along), Touch::Role::crossing, known_crossing(state_.opposite(e)));
    if (answer.is_failed()) {
        state_.note_failed(e);
    } else if (answer.is_contact()) {
        space_.learn_contact(e, start, head_.at(), answer.touch);
        if (was_in_surface && !state_.in_surface(e)) note_lost(facet, e);
        if (state_.is_double(e)) {
            walls_.note((state_.crossing(e).near + state_.crossing(state_.opposite(e)).near) / 2, state_.thickness(e));
            if (growth_) growth_->note_thin(e);  // may take the other crossing back
        }
        on_contact(e);
    } else {
        if (const auto inferred = state_.inferred(e)) growth_->withdraw(*inferred, Point(state_.crossing(*inferred).far));
        const CellId far_cell = state_.neighbor(e);
        const bool was_free = state_.is_free(far_cell);
        const std::optional<Crossing> graze = space_.learn_clear(e, start, head_.at());
        if (was_in_surface && !state_.in_surface(e)) note_lost(facet, e);
        if (!was_free) walk_.note_free(far_cell);
        if (graze && traits_.touch_error == 0) expect_graze(head_, *graze, state_.surroundings().region().radius());
    }
    report();
}

void ProbingLoop::note_lost(const std::array<std::uint32_t, 3>& facet, DirectedEdge e) {
    walk_.note_lost(facet);
    if (growth_) growth_->note_crossing(e);
}

// S was touched on that edge: whoever comes from its other end has to touch it there at the latest.
std::optional<ProbeHead::Expected> ProbingLoop::known_crossing(DirectedEdge e) const {
    if (state_.recorded_state(e) != EdgeState::crossing || state_.crossing(e).inferred) return std::nullopt;
    return ProbeHead::Expected{Point(state_.crossing(e).near)};
}

void ProbingLoop::note_touches() {
    const std::vector<Touch>& touches = head_.touches();
    for (; touches_noted_ < touches.size(); ++touches_noted_) {
        const Touch& t = touches[touches_noted_];
        if (t.is_known) continue;
        const Vector way = t.position - t.from;
        if (way.norm() > 0) walls_.note_touch(t.position, way.normalized());
    }
}

void ProbingLoop::on_contact(DirectedEdge e) {
    note_touches();
    const DirectedEdge worst = larger_ball(state_, e);
    const Crossing& c = state_.crossing(worst);
    const bool is_bad = criteria_.is_bad(c.ball_radius, c.near);
    if (!is_bad && !(c.ball_radius > walls_.size_at(c.near))) {
        walk_.note_crossing(e);
        if (growth_) growth_->note_crossing(e);
    } else if (!is_bad || options_.strategy.refine == Strategy::Refine::eager) {
        // The thesis knows no thin walls: they are refined at once, whatever the order of the rest.
        insert_bad(worst);
    } else {
        note_bad(worst);
        walk_.note_crossing(e);
    }
}

void ProbingLoop::note_bad(DirectedEdge crossing) { bad_.push(ball_of(state_, crossing)); }

void ProbingLoop::insert_bad(DirectedEdge crossing) {
    const Crossing& c = state_.crossing(crossing);
    if (criteria_.is_bad(c.ball_radius, c.near)) return insert(crossing, Touch::Role::refinement, criteria_.spacing(c.near));
    insert(crossing, Touch::Role::repair, criteria_.repair_spacing());  // for a thin wall
}

void ProbingLoop::insert(DirectedEdge crossing, Touch::Role role, double spacing) {
    const Crossing& c = state_.crossing(crossing);
    // The ball is empty, so its radius is the distance to the nearest sample (planner/DESIGN.md, "Insertion"), ...
    if (c.ball_radius < spacing) throw std::logic_error(kTooClose);
    // ... to rounding: by itself no edge leads nearer to a sample than seeds are. If one did, it would be left alone.
    const Point p = c.near;
    if ((state_.sample(state_.nearest_sample(p, crossing.cell)) - p).norm() < std::min(criteria_.least_spacing(), spacing) / 2) {
        effort_.give_up(p);
        return state_.note_failed(crossing);
    }
    add_sample(p, crossing.cell, c.touch, role);
}

void ProbingLoop::add_sample(const Point& p, CellId near, std::uint32_t touch, Touch::Role role) {
    if (state_.sample_count() >= max_samples_) throw std::logic_error(kTooClose);
    const MaintainedDelaunay::Insertion insertion = space_.insert(p, near);
    head_.assign(touch, role, insertion.sample);
    effort_.note_sample(p);
    if (growth_) growth_->note_insertion(insertion, head_.touches()[touch]);
    walk_.note_insertion(insertion);
    // What is left of an edge that was crossed twice was not looked at by itself.
    for (const DirectedEdge e : insertion.gained) {
        const Crossing& left = state_.crossing(e);
        if (!left.inferred && criteria_.is_bad(left.ball_radius, left.near)) note_bad(e);
    }
    if (observer_.on_sample) observer_.on_sample(view());
}

void ProbingLoop::add_sample_of(const SurfaceGrowth::Step& step) {
    if (step.sample) add_sample(step.sample->position, step.sample->near, step.sample->touch, Touch::Role::refinement);
}

bool ProbingLoop::grow() {
    if (!growth_) return false;
    const std::optional<SurfaceGrowth::Step> step = growth_->step();
    note_touches();
    if (step) add_sample_of(*step);
    bool refuted = false;
    while (growth_->settle_refutation()) refuted = true;
    if (step) report();
    return step.has_value() || refuted;
}

bool ProbingLoop::insert_worst() {
    while (!bad_.empty()) {
        const SurfaceBall worst = bad_.top();
        bad_.pop();
        if (const auto e = state_.edge_of(worst.id, worst.generation)) {
            insert_bad(*e);
            return true;
        }
    }
    return false;
}

bool ProbingLoop::explore_unrepresented() {
    std::vector<std::uint32_t> samples = extract_surface(state_).unused_samples(state_.sample_count());
    // Around a wall that is thinner than the samples are apart, facets are known and are not in Ŝ: they have to be refined.
    std::erase_if(samples, [&](std::uint32_t sample) { return state_.is_thin_at(sample) || state_.is_known(sample); });
    // A component that seeding touched and no facet reached: with a facet of its own it grows.
    if (growth_ && facet_unrepresented(samples, true)) return true;
    for (const std::uint32_t sample : samples) walk_.note_surroundings(sample);
    if (walk_.next()) return true;
    // Around a first touch nothing need be free yet but the way to it: it may need a facet of its own. So may a touch of
    // another component.
    return facet_unrepresented(samples, false);
}

bool ProbingLoop::facet_unrepresented(const std::vector<std::uint32_t>& samples, bool seeds_only) {
    const std::vector<Touch> touches = head_.touches();  // a copy: more come
    for (const Touch& touch : touches) {
        if (!touch.sample || touch.role == Touch::Role::seed_facet || !std::binary_search(samples.begin(), samples.end(), *touch.sample))
            continue;
        if (seeds_only && touch.role != Touch::Role::seed) continue;
        if (!faceted_.insert(*touch.sample).second) continue;
        const Vector approach = (touch.position - touch.from).normalized();
        const std::size_t known = state_.sample_count();
        const bool made = touch_seed_facet(options_, space_, head_, *touch.sample, approach).has_value();
        if (growth_) growth_->note_seeds(known);
        if (!made) continue;
        walk_.sweep();
        return true;
    }
    return false;
}

bool ProbingLoop::repair_defects() {
    bool changed = false;
    for (const SurfaceBall& ball : repair_.balls(extract_surface(state_)))
        changed |= refine(ball, Touch::Role::repair, criteria_.repair_spacing());
    return changed;
}

std::vector<BadFacet> ProbingLoop::bad_facets(const RestrictedSurface& surface) const {
    if (!criteria_.look_at_facets()) return {};
    std::vector<bool> is_seed(state_.sample_count());
    for (const Touch& touch : head_.touches()) {
        if (touch.sample) is_seed[*touch.sample] = touch.role == Touch::Role::seed || touch.role == Touch::Role::seed_facet;
    }
    return find_bad_facets(state_, surface, criteria_, is_seed);
}

bool ProbingLoop::refine_facets() {
    if (!criteria_.look_at_facets()) return false;
    const RestrictedSurface surface = extract_surface(state_);
    std::vector<BadFacet> facets = bad_facets(surface);
    std::sort(facets.begin(), facets.end(), [&](const BadFacet& f, const BadFacet& g) {
        const double rf = surface.ball_radii[f.facet];
        const double rg = surface.ball_radii[g.facet];
        return rf != rg ? rf > rg : f.facet < g.facet;
    });
    // By crossing, not by edge: an insertion may move or remove the next one.
    std::vector<SurfaceBall> balls;
    balls.reserve(facets.size());
    for (const BadFacet& f : facets) balls.push_back(ball_of(state_, surface.dual_edges[f.facet]));
    bool changed = false;
    for (std::size_t k = 0; k < facets.size(); ++k) changed |= refine(balls[k], Touch::Role::refinement, facets[k].spacing);
    return changed;
}

SampledSurface ProbingLoop::sampled_surface() const {
    RestrictedSurface found = extract_surface(state_);
    SampledSurface surface;
    for (const DirectedEdge e : found.dual_edges) {
        surface.ball_centres.push_back(state_.crossing(e).near);
        surface.is_known.push_back(growth_->is_known(e) ? 1 : 0);
    }
    surface.mesh = std::move(found.mesh);
    surface.ball_radii = std::move(found.ball_radii);
    surface.sample_of = std::move(found.sample_of);
    return surface;
}

bool ProbingLoop::approach_tolerance() {
    if (!tolerance_) return false;
    const SampledSurface surface = sampled_surface();
    if (surface.mesh.triangles.empty()) return false;
    std::vector<ToleranceSearch::Place> places = tolerance_->places(surface);
    touched_before_ = tolerance_->evidence().touched;
    const bool is_audit = places.empty();
    if (is_audit && std::exchange(audited_tolerance_, true)) return false;
    if (is_audit) places = tolerance_->draw(surface, growth_->audit_quota());
    if (places.empty()) return false;
    touch_places(std::move(places), is_audit);
    return true;
}

void ProbingLoop::touch_places(std::vector<ToleranceSearch::Place> places, bool is_audit) {
    const std::size_t known = state_.sample_count();
    while (!places.empty() && used_up(options_.budget, head_.cost(), traits_.rates).empty()) {
        const Point at = space_.roadmap().at(head_.at());
        const auto nearest = std::ranges::min_element(places, {}, [&](const auto& place) { return (place.at - at).squaredNorm(); });
        const ToleranceSearch::Place place = *nearest;
        places.erase(nearest);
        const std::uint32_t sample = state_.nearest_sample(place.at, state_.cell_at(place.samples[0]));
        if (!is_audit && (state_.sample(sample) - place.at).norm() < place.spacing) {
            // One of this round may have helped. One that was there before will be there again.
            if (sample < known) tolerance_->give_up(place);
            continue;
        }
        const SurfaceGrowth::Step step = growth_->touch_foretold(place.at, place.normal, place.samples, place.spacing);
        note_touches();
        is_audit ? tolerance_->note_audit(place, step.met) : tolerance_->note(place, step.met, step.sample.has_value());
        add_sample_of(step);
        while (growth_->settle_refutation()) {
        }
        report();
    }
}

bool ProbingLoop::refine(const SurfaceBall& ball, Touch::Role role, double spacing) {
    const auto e = state_.edge_of(ball.id, ball.generation);
    if (!e) return false;
    if (state_.crossing(*e).inferred) {
        if (growth_->is_known(*e)) return false;
        growth_->distrust(*e);
    } else {
        insert(*e, role, spacing);
    }
    return true;
}

void ProbingLoop::report() {
    if (!observer_.on_progress) return;
    Progress progress;
    progress.samples = state_.sample_count();
    progress.probes = head_.cost().probes();
    progress.worst_ball_radius = bad_.empty() ? options_.epsilon : bad_.top().radius;
    progress.epsilon = options_.epsilon;
    progress.open_edges = walk_.open_count() + (growth_ ? growth_->open_count() : 0);
    if (growth_) {
        progress.audited = growth_->audited();
        progress.audits_left = growth_->audits_left();
    }
    progress.fraction_done = progress_.fraction(head_.touches(), state_.sample_count());
    if (tolerance_) progress.tolerance_left = tolerance_left(progress.fraction_done);
    observer_.on_progress(progress, view());
}

std::uint64_t ProbingLoop::tolerance_left(double fraction_done) const {
    double left = 0;
    if (const auto expected = tolerance_->expected_touches()) {
        left = *expected - static_cast<double>(tolerance_->evidence().touched - touched_before_);
    } else if (fraction_done > 0) {
        const double samples = static_cast<double>(state_.sample_count()) / fraction_done;
        left = samples * (expected_refinement(*options_.tolerance, options_.epsilon) - 1);
    }
    return static_cast<std::uint64_t>(std::max(left, 0.0));
}

RunView ProbingLoop::view() const {
    return {head_.touches(), state_.samples(), [this] { return extract_surface(state_).mesh; }};
}

Result ProbingLoop::result() {
    Result result;
    result.cost = head_.cost();
    result.cost.grazes = state_.grazes();
    RestrictedSurface surface = extract_surface(state_);
    result.topology = analyse_topology(surface.mesh);
    Evidence evidence;
    if (growth_) evidence.reach = growth_->evidence();
    const bool guesses = evidence.reach && evidence.reach->is_plausible;
    for (std::size_t t = 0; t < surface.dual_edges.size(); ++t) {
        const DirectedEdge e = surface.dual_edges[t];
        const std::optional<EdgeSpan> along = state_.span(e);
        const Point& met = state_.crossing(e).near;
        result.dual_edges.push_back(along ? Segment{along->start_point(), along->end_point()} : Segment{met, met});
        const bool is_inferred = state_.inferred(e).has_value();
        const bool is_plausible = is_inferred && guesses;
        result.confidences.push_back(is_plausible ? growth_->confidence(e) : 1);
        if (is_inferred) ++(is_plausible ? result.cost.plausible_contact : result.cost.inferred_contact);
        double& largest = is_plausible ? result.max_plausible_ball_radius : result.max_ball_radius;
        largest = std::max(largest, surface.ball_radii[t]);
    }
    evidence.max_ball_radius = result.max_ball_radius;
    evidence.max_plausible_ball_radius = result.max_plausible_ball_radius;
    if (evidence.reach) {
        evidence.reach->inferred = result.cost.inferred_contact + result.cost.plausible_contact;
        if (guesses && !result.confidences.empty()) evidence.reach->least_confidence = std::ranges::min(result.confidences);
    }
    evidence.components = result.topology.components;
    Repair::Findings found = repair_.findings(surface, result.topology, effort_);
    evidence.unrepresented_touches = found.unrepresented_touches;
    evidence.unresolved_places = found.unresolved_places;
    evidence.minor_places = found.thin_places.size();
    evidence.torn_components = found.torn_components;
    evidence.given_up = effort_.given_up().size();
    evidence.open_edges = walk_.open_count();
    evidence.stopped_by = stopped_by_;
    if (tolerance_) evidence.deviation = tolerance_->evidence();
    if (earlier_) evidence.earlier = earlier_->evidence();
    evidence.has_facet_criteria = criteria_.look_at_facets();
    evidence.bad_facets = bad_facets(surface).size();
    evidence.failed_probes = result.cost.failed;
    evidence.grazes = result.cost.grazes;
    evidence.seeds_given = !options_.seed_rays.empty();
    evidence.touch_error = traits_.touch_error;
    const Surroundings& surroundings = state_.surroundings();
    evidence.has_fixtures = surroundings.known().has_fixtures();
    evidence.has_area = surroundings.area().has_value();
    evidence.assumes_clear = surroundings.assumes_clear();
    evidence.known_samples =
        static_cast<std::size_t>(std::ranges::count_if(head_.touches(), [](const Touch& touch) { return touch.is_known && touch.sample; }));
    std::vector<std::uint8_t> is_outside;  // by sample
    if (surroundings.area()) {
        is_outside.resize(state_.sample_count());
        for (std::uint32_t s = 0; s < is_outside.size(); ++s) {
            const bool is_in = is_inside(*surroundings.area(), state_.sample(s), KnownSolids::kGap * options_.epsilon);
            is_outside[s] = state_.is_known(s) && !is_in ? 1 : 0;
            evidence.wall_samples += is_outside[s];
        }
    }
    result.deviation = evidence.deviation;
    result.earlier = evidence.earlier;
    result.certificate = certify(options_, result.topology, evidence);
    // A front that a budget stopped has open edges everywhere, and no epsilon would mend them.
    if (stopped_by_.empty()) {
        if (result.certificate.status == Certificate::Status::incomplete) result.bad_places = std::move(found.bad_places);
        result.thin_places = std::move(found.thin_places);
    }
    result.touches = head_.touches();
    result.samples = state_.sample_count();
    result.known_samples = evidence.known_samples;
    result.lower_bound_samples = lower_bound_samples(surface_area(surface.mesh), options_.epsilon);
    result.lower_bound_displacement = static_cast<double>(result.samples - 1) * options_.epsilon;
    result.mesh = std::move(surface.mesh);
    result.sample_of = std::move(surface.sample_of);
    result.area = surroundings.area();
    if (surroundings.area()) {
        for (const std::uint32_t s : result.sample_of) result.is_outside.push_back(is_outside[s]);
    }
    result.ball_radii = std::move(surface.ball_radii);
    return result;
}

}  // namespace palpate
