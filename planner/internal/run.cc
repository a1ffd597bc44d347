#include "planner/internal/run.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "planner/errors.h"
#include "planner/machine_time.h"

namespace palpate {
namespace {

// Of the progress estimate: a typical surface has about this share of the area of its bounding box, ...
constexpr double kAreaPerBox = 0.6;
// ... and a finished sample about this many times the samples of the hexagonal bound.
constexpr double kSamplesPerBound = 1.75;
// An estimate is never the end.
constexpr double kAlmostDone = 0.99;

// Of ε: see ProbeWatch.
constexpr double kLongestHop = 6.0;

// So often Ŝ is refined around a touch that no facet uses.
constexpr int kMaxRepairs = 24;

constexpr const char* kTooClose = "Run: a sample would break the packing bound that termination rests on";

// Balls of half the spacing around samples are disjoint and lie in ω, grown by half the spacing.
std::size_t packing_bound(const Workspace& workspace, double spacing) {
    const double bound = std::pow((workspace.radius() + spacing / 2) / (spacing / 2), 3);
    constexpr double kBeyondAnyRun = 1e18;  // fits a size_t, with room for the seeds
    return static_cast<std::size_t>(std::min(bound, kBeyondAnyRun)) + 1;
}

std::optional<ProbeWatch> watch_for(const Options& options) {
    if (!options.overtravel) return std::nullopt;
    // Adaptive motion waits for no proof; the others keep to what is proven.
    const bool hops = options.strategy.infer == Strategy::Infer::adaptive;
    return ProbeWatch(*options.overtravel, options.epsilon, hops ? kLongestHop * options.epsilon : 0.0);
}

}  // namespace

Run::Run(SurfaceOracle& oracle, const Workspace& workspace, const Options& options, const Observer& observer)
    : workspace_(workspace),
      options_(options),
      observer_(observer),
      criteria_(options),
      state_(workspace, options.touch_error),
      tool_(oracle, workspace, state_.roadmap(), watch_for(options)),
      exploration_(state_, options.strategy.explore),
      touched_min_(Point::Constant(std::numeric_limits<double>::infinity())),
      touched_max_(-touched_min_) {}

void Run::execute() {
    try {
        probe_all();
    } catch (const SeedError&) {
        if (options_.goes_home) tool_.go_home(observer_.on_home);
        throw;
    }
    tool_.end_of_run();
    if (options_.goes_home) tool_.go_home(observer_.on_home);
}

void Run::probe_all() {
    const std::vector<SeedFacet> seeds = touch_seeds(workspace_, options_, state_, tool_);
    for (const SeedFacet& seed : seeds) faceted_.insert(seed.samples[0]);
    // Seeds are exempt from the spacing; there are few of them.
    max_samples_ = state_.sample_count() + packing_bound(workspace_, criteria_.least_spacing());
    if (options_.strategy.infer == Strategy::Infer::adaptive || (options_.strategy.infer == Strategy::Infer::reach && options_.reach))
        growth_.emplace(state_, tool_, workspace_, options_, criteria_, observer_);
    exploration_.sweep();
    while (!is_budget_used_up()) {
        if (grow()) continue;
        if (const auto e = exploration_.next()) {
            probe(*e);
            continue;
        }
        if (insert_worst()) continue;
        // What follows is linear in the sample and happens a few times in a run.
        exploration_.sweep();
        if (growth_) growth_->sweep();
        if (grow() || exploration_.next() || explore_unrepresented() || repair_defects() || refine_facets()) continue;
        break;
    }
}

void Run::probe(DirectedEdge e) {
    const std::optional<EdgeSpan> along = state_.span(e);
    if (!along) throw std::logic_error("Run: an edge outside the workspace is to be probed");
    if (growth_ && growth_->infer(e)) return exploration_.note_crossing(*state_.crossed(e));
    const NodeId start = state_.probe_start(e, *along);
    if (growth_) {
        if (const auto met = growth_->approach(start, state_.facet_samples(e))) {
            add_sample_of(*met);
            return;
        }
    }
    tool_.go_to(start);
    const Tool::Answer answer = tool_.probe(state_.probe_target(e, *along), Touch::Role::crossing, known_crossing(state_.opposite(e)));
    if (answer.failed) {
        state_.note_failed(e);
    } else if (answer.contact) {
        const NodeId contact = state_.roadmap().add(start, answer.position);
        tool_.arrive(contact);
        state_.learn_contact(e, start, contact, answer.touch);
        on_contact(e);
    } else {
        if (const auto inferred = state_.inferred(e)) growth_->withdraw(*inferred, Point(state_.crossing(*inferred).far));
        const CellId far_cell = state_.neighbor(e);
        const bool was_free = state_.is_free(far_cell);
        tool_.arrive(state_.learn_clear(e, *along, start, answer.position));
        if (!was_free) exploration_.note_free(far_cell);
    }
    report();
}

// S was touched on that edge: whoever comes from its other end has to touch it there at the latest.
std::optional<Tool::Expected> Run::known_crossing(DirectedEdge e) const {
    if (state_.recorded_state(e) != EdgeState::crossing || state_.crossing(e).inferred) return std::nullopt;
    return Tool::Expected{Point(state_.crossing(e).near)};
}

void Run::on_contact(DirectedEdge e) {
    const double radius = state_.crossing(e).ball_radius;
    if (!criteria_.is_bad(radius, state_.crossing(e).near)) {
        exploration_.note_crossing(e);
        if (growth_) growth_->note_crossing(e);
    } else if (options_.strategy.refine == Strategy::Refine::eager) {
        insert(e, Touch::Role::refinement, criteria_.spacing(state_.crossing(e).near));
    } else {
        const CrossingId id = state_.crossing_id(e);
        bad_.push_back({radius, id, state_.generation_of(id)});
        std::push_heap(bad_.begin(), bad_.end());
        exploration_.note_crossing(e);
    }
}

void Run::insert(DirectedEdge crossing, Touch::Role role, double spacing) {
    const Crossing& c = state_.crossing(crossing);
    // The ball is empty, so its radius is the distance to the nearest sample (DESIGN section 3).
    if (c.ball_radius < spacing) throw std::logic_error(kTooClose);
    add_sample(Point(c.near), crossing.cell, c.touch, role);
}

void Run::add_sample(const Point& p, CellId near, std::uint32_t touch, Touch::Role role) {
    if (state_.sample_count() >= max_samples_) throw std::logic_error(kTooClose);
    const MaintainedDelaunay::Insertion insertion = state_.insert(p, near);
    tool_.assign(touch, role, insertion.sample);
    if (growth_) growth_->note_insertion(insertion, tool_.touches()[touch]);
    exploration_.note_insertion(insertion);
    if (observer_.on_insertion) observer_.on_insertion(state_);
}

void Run::add_sample_of(const Growth::Step& step) {
    if (step.sample) add_sample(step.sample->position, step.sample->near, step.sample->touch, Touch::Role::refinement);
}

bool Run::grow() {
    if (!growth_) return false;
    const std::optional<Growth::Step> step = growth_->step();
    if (step) add_sample_of(*step);
    bool refuted = false;
    while (growth_->settle_refutation()) refuted = true;
    if (step) report();
    return step.has_value() || refuted;
}

bool Run::insert_worst() {
    while (!bad_.empty()) {
        std::pop_heap(bad_.begin(), bad_.end());
        const Bad worst = bad_.back();
        bad_.pop_back();
        if (const auto e = state_.edge_of(worst.id, worst.generation)) {
            insert(*e, Touch::Role::refinement, criteria_.spacing(state_.crossing(*e).near));
            return true;
        }
    }
    return false;
}

std::vector<std::uint32_t> Run::unrepresented(const RestrictedSurface& surface) const {
    std::vector<std::uint32_t> samples;
    std::size_t next = 0;
    for (std::uint32_t sample = 0; sample < state_.sample_count(); ++sample) {
        if (next < surface.sample_of.size() && surface.sample_of[next] == sample) {
            ++next;
        } else {
            samples.push_back(sample);
        }
    }
    return samples;
}

bool Run::explore_unrepresented() {
    const std::vector<std::uint32_t> samples = unrepresented(extract_surface(state_));
    // A component that seeding touched and no facet reached: with a facet of its own it grows.
    if (growth_ && facet_unrepresented(samples, true)) return true;
    for (const std::uint32_t sample : samples) exploration_.note_surroundings(sample);
    if (exploration_.next()) return true;
    // Around a first touch nothing need be free yet but the way to it: it may need a facet of its own. So may a touch of
    // another component.
    return facet_unrepresented(samples, false);
}

bool Run::facet_unrepresented(const std::vector<std::uint32_t>& samples, bool seeds_only) {
    const std::vector<Touch> touches = tool_.touches();  // a copy: more come
    for (const Touch& touch : touches) {
        if (!touch.sample || !std::binary_search(samples.begin(), samples.end(), *touch.sample)) continue;
        if (seeds_only && touch.role != Touch::Role::seed) continue;
        if (!faceted_.insert(*touch.sample).second) continue;
        const Vector approach = (touch.position - touch.from).normalized();
        const std::size_t known = state_.sample_count();
        const bool made = touch_seed_facet(workspace_, options_, state_, tool_, *touch.sample, approach).has_value();
        if (growth_) growth_->note_seeds(known);
        if (!made) continue;
        exploration_.sweep();
        return true;
    }
    return false;
}

bool Run::repair_defects() {
    const RestrictedSurface surface = extract_surface(state_);
    // By crossing, not by edge: an insertion may move or remove the next one.
    std::vector<Bad> to_refine;
    const auto refine_largest = [&](const std::vector<std::uint32_t>& facets) {
        Bad largest;
        for (const std::uint32_t facet : facets) largest = std::max(largest, ball_of(surface, facet));
        if (criteria_.may_repair(largest.ball_radius)) to_refine.push_back(largest);
    };
    for (const Defect& defect : analyse_topology(surface.mesh).defects) refine_largest(defect.facets);
    // A touch that no facet uses is a defect as well: Ŝ is too coarse to see what was touched.
    // But it may be a false touch, which nothing will ever join to Ŝ: on a machine, touches around it are not for nothing.
    for (const std::uint32_t sample : unrepresented(surface)) {
        if (++repairs_[sample] <= kMaxRepairs) refine_largest(facets_near(surface, sample));
    }
    std::sort(to_refine.rbegin(), to_refine.rend());
    bool changed = false;
    for (const Bad& ball : to_refine) changed |= refine(ball, Touch::Role::repair, criteria_.repair_spacing());
    return changed;
}

std::vector<BadFacet> Run::bad_facets(const RestrictedSurface& surface) const {
    if (!criteria_.look_at_facets()) return {};
    std::vector<bool> is_seed(state_.sample_count());
    for (const Touch& touch : tool_.touches()) {
        if (touch.sample) is_seed[*touch.sample] = touch.role == Touch::Role::seed || touch.role == Touch::Role::seed_facet;
    }
    return find_bad_facets(state_, surface, criteria_, is_seed);
}

bool Run::refine_facets() {
    if (!criteria_.look_at_facets()) return false;
    const RestrictedSurface surface = extract_surface(state_);
    std::vector<BadFacet> facets = bad_facets(surface);
    std::sort(facets.begin(), facets.end(), [&](const BadFacet& f, const BadFacet& g) {
        const double rf = surface.ball_radii[f.facet];
        const double rg = surface.ball_radii[g.facet];
        return rf != rg ? rf > rg : f.facet < g.facet;
    });
    // By crossing, not by edge: an insertion may move or remove the next one.
    std::vector<Bad> balls;
    for (const BadFacet& f : facets) balls.push_back(ball_of(surface, f.facet));
    bool changed = false;
    for (std::size_t k = 0; k < facets.size(); ++k) changed |= refine(balls[k], Touch::Role::refinement, facets[k].spacing);
    return changed;
}

Run::Bad Run::ball_of(const RestrictedSurface& surface, std::uint32_t facet) const {
    const CrossingId id = state_.crossing_id(surface.dual_edges[facet]);
    return {surface.ball_radii[facet], id, state_.generation_of(id)};
}

bool Run::refine(const Bad& ball, Touch::Role role, double spacing) {
    const auto e = state_.edge_of(ball.id, ball.generation);
    if (!e) return false;
    if (state_.crossing(*e).inferred) {
        growth_->distrust(*e);
    } else {
        insert(*e, role, spacing);
    }
    return true;
}

bool Run::is_budget_used_up() {
    const Account& account = tool_.account();
    const Budget& budget = options_.budget;
    // Asked before every action: nothing is built until it is used up.
    const auto stop = [&](const auto& amount, const char* of_what) {
        std::ostringstream why;
        why << amount << of_what;
        stopped_by_ = why.str();
        return true;
    };
    if (budget.probes && account.probes() >= *budget.probes) {
        return stop(*budget.probes, " probes");
    }
    if (budget.displacement && account.displacement() >= *budget.displacement) {
        return stop(*budget.displacement, " mm of displacement");
    }
    if (budget.machine_time && estimate_machine_time(account, options_.rates).count() >= *budget.machine_time) {
        return stop(*budget.machine_time, " s of machine time");
    }
    return false;
}

std::vector<std::uint32_t> Run::facets_near(const RestrictedSurface& surface, std::uint32_t sample) const {
    std::vector<std::uint32_t> neighbors;
    state_.adjacent_samples(sample, neighbors);
    std::sort(neighbors.begin(), neighbors.end());
    std::vector<std::uint32_t> facets;
    for (std::uint32_t facet = 0; facet < surface.mesh.triangles.size(); ++facet) {
        const auto& t = surface.mesh.triangles[facet];
        const auto is_near = [&](std::uint32_t v) { return std::binary_search(neighbors.begin(), neighbors.end(), surface.sample_of[v]); };
        if (std::any_of(t.begin(), t.end(), is_near)) facets.push_back(facet);
    }
    return facets;
}

std::vector<BadPlace> Run::bad_places(const RestrictedSurface& surface, const Topology& topology) const {
    std::vector<BadPlace> places;
    for (const Defect& defect : topology.defects) {
        constexpr std::array<const char*, 4> kWhat = {"boundary edge", "non-manifold edge", "inconsistently oriented edge", "split vertex"};
        double largest = 0;
        for (const std::uint32_t facet : defect.facets) largest = std::max(largest, surface.ball_radii[facet]);
        places.push_back({(surface.mesh.points[defect.vertices[0]] + surface.mesh.points[defect.vertices[1]]) / 2,
                          kWhat.at(static_cast<std::size_t>(defect.kind)), largest});
    }
    const std::string unused = "touch that no facet uses; if it is on a component of its own, give probing.seed_rays a ray to it";
    for (const std::uint32_t sample : unrepresented(surface)) {
        places.push_back({state_.sample(sample), unused, options_.epsilon * options_.refinement_floor});
    }
    return places;
}

double Run::estimate_fraction() {
    const std::vector<Touch>& touches = tool_.touches();
    for (; touches_seen_ < touches.size(); ++touches_seen_) {
        touched_min_ = touched_min_.cwiseMin(touches[touches_seen_].position);
        touched_max_ = touched_max_.cwiseMax(touches[touches_seen_].position);
    }
    const Vector size = touched_max_ - touched_min_;
    const double area = kAreaPerBox * 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    const double expected = kSamplesPerBound * lower_bound_samples(area, options_.epsilon);
    const double fraction = expected > 0 ? static_cast<double>(state_.sample_count()) / expected : 0;
    return fraction_done_ = std::max(fraction_done_, std::min(fraction, kAlmostDone));
}

void Run::report() {
    if (!observer_.on_progress) return;
    Progress progress;
    progress.samples = state_.sample_count();
    progress.probes = tool_.account().probes();
    progress.worst_ball_radius = bad_.empty() ? options_.epsilon : bad_.front().ball_radius;
    progress.epsilon = options_.epsilon;
    progress.open_edges = exploration_.open_count() + (growth_ ? growth_->open_count() : 0);
    progress.fraction_done = estimate_fraction();
    observer_.on_progress(progress);
}

Result Run::result() {
    Result result;
    result.account = tool_.account();
    result.account.grazes = state_.grazes();
    RestrictedSurface surface = extract_surface(state_);
    result.topology = analyse_topology(surface.mesh);
    for (const double radius : surface.ball_radii) result.max_ball_radius = std::max(result.max_ball_radius, radius);
    Evidence evidence;
    evidence.max_ball_radius = result.max_ball_radius;
    evidence.components = result.topology.components;
    evidence.unrepresented_touches = unrepresented(surface).size();
    evidence.open_edges = exploration_.open_count();
    evidence.stopped_by = stopped_by_;
    evidence.has_facet_criteria = criteria_.look_at_facets();
    evidence.bad_facets = bad_facets(surface).size();
    evidence.failed_probes = result.account.failed;
    evidence.grazes = result.account.grazes;
    evidence.seeds_given = !options_.seed_rays.empty();
    for (const DirectedEdge e : surface.dual_edges) result.account.inferred_contact += state_.inferred(e) ? 1 : 0;
    if (growth_) {
        evidence.reach = growth_->evidence();
        evidence.reach->inferred = result.account.inferred_contact;
    }
    result.certificate = certify(options_, result.topology, evidence);
    // A front that a budget stopped has open edges everywhere, and no epsilon would mend them.
    if (result.certificate.status == Certificate::Status::incomplete && stopped_by_.empty())
        result.bad_places = bad_places(surface, result.topology);
    result.touches = tool_.touches();
    result.samples = state_.sample_count();
    result.lower_bound_samples = lower_bound_samples(surface_area(surface.mesh), options_.epsilon);
    result.lower_bound_displacement = static_cast<double>(result.samples - 1) * options_.epsilon;
    result.mesh = std::move(surface.mesh);
    result.ball_radii = std::move(surface.ball_radii);
    return result;
}

}  // namespace palpate
