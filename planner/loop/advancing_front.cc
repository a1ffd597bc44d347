#include "planner/loop/advancing_front.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

// Touches for one open edge that changed nothing, after which it is left to a walk over Voronoi edges.
constexpr std::uint32_t kMaxAttempts = 3;
// The same where looking costs nothing.
constexpr std::uint32_t kMaxLooks = 12;
// Of ε: nothing but known solids is expected so far from all that was touched. With 3: 3 % more probes on a bunny, which go where what was
// touched and what is known leave nothing else.
constexpr double kFar = 2.0;
// Attempts that may go to a dual edge in doubt.
constexpr std::uint32_t kDualAttempts = 2;
// Of ε: an edge whose facet ahead is in doubt is taken to be so much farther away. New samples beside it mostly settle the doubt.
constexpr double kDoubtWaits = 4.0;
// With fewer bonds a new sample begins a row instead of filling one: for each that it lacks, its edge is taken to be an ε farther away.
constexpr double kBonds = 2.5;
// Of ε: places for new samples are looked at around one so far ahead of the edge, two such steps to all sides; then finer, around the best.
constexpr double kAhead = 1.15;
constexpr double kStep = 0.25;
// Of the wanted circumradius: no new triangle is larger, ...
constexpr double kLargest = 1.03;
// ... nor than that many ε, as balls are larger than their facets.
constexpr double kLargestOfAll = 0.99;
// A facet ahead is larger than ε by this much before its centre is too far away to aim at.
constexpr double kLarge = 2.0;
// New samples keep a distance of that many ε: rounding aside.
constexpr double kSpacing = 1 + 1e-7;
// Samples that are farther from a tangent plane than that many ε are not beside the open edge.
constexpr double kSheet = 1.5;
// Facets steeper than this against the open edge's tangent plane are not ahead.
constexpr double kSteepest = 0.5;
// Of ε: how far below a tangent plane S is looked for. Where it falls away faster a second touch meets it below the open edge. With 2 and 1
// in place of both: 10 % more probes on eight sharp objects, 50 % on a plate of 1.5 ε.
constexpr double kLow = 1.0;
// Of the distance ahead: so far below the open edge that second touch aims.
constexpr double kUnder = 0.6;
// Of ε: samples so far from a place ahead show creases there, ...
constexpr double kCreaseRange = 2.0;
// ... if their normals' cosine with that of the open edge is smaller.
constexpr double kSameSide = 0.7;
// Of ε: places nearer than that behind a crease are touched as if it were not there.
constexpr double kPast = 0.1;
// A start is put inside a lens by this part of the way: not on its boundary.
constexpr double kInside = 1e-3;

// What a sample at that distance (in circumradii of the triangles wanted) is worth to a new one: 1 where the two make an edge of a
// hexagonal lattice, and less than nothing where they are much nearer, or too far for an edge and too near for two. Flat at the
// top on the near side: with straight lines on both sides 1 to 5 % more probes are needed.
double bond(double distance) {
    constexpr double kEdge = std::numbers::sqrt3;
    constexpr double kNextBut = 3.0;  // of the lattice, too: across an edge from one triangle to the next
    constexpr double kBetween = (kEdge + kNextBut) / 2;
    constexpr double kShort = 0.525;  // an edge that lacks so much is worth nothing
    constexpr double kLoss = 0.5;     // at kBetween
    if (distance < kEdge) return 1 - std::pow((kEdge - distance) / kShort, 2);
    if (distance < kBetween) return std::lerp(1, -kLoss, (distance - kEdge) / (kBetween - kEdge));
    return distance < kNextBut ? std::lerp(-kLoss, 0, (distance - kBetween) / (kNextBut - kBetween)) : 0;
}

}  // namespace

struct AdvancingFront::OpenEdge {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    std::uint32_t c = 0;  // third corner of the one facet
    DirectedEdge facet;   // its dual edge, with the crossing
    std::uint32_t attempts = 0;
    Point middle = Point::Zero();
    double half = 0.0;              // mm: half the edge's length
    Vector up = Vector::Zero();     // unit: outwards, orthogonal to the edge
    Vector ahead = Vector::Zero();  // unit: away from c, in the tangent plane
};

// --- noting ----------------------------------------------------------------------------------------------------------

// Only open edges wait: the nearest is found without looking at others.
void AdvancingFront::note_edge(std::uint32_t a, std::uint32_t b, const EdgeTicket& hint) {
    if (a > b) std::swap(a, b);
    const Task task{{a, b, Task::kNoSample}, 0, (state_.sample(a) + state_.sample(b)) / 2, hint};
    TaskGrid& tasks = state_.is_known(a) && state_.is_known(b) ? on_known_ : tasks_;
    if (!given_up_.contains({a, b}) && state_.count_facets_at(a, b, hint).in_surface == 1) {
        tasks.add(task);
    } else {
        tasks.remove(task);
        without_motion_.remove(task);
        with_motion_.remove(task);
    }
}

void AdvancingFront::note_edges_of(const std::array<std::uint32_t, 3>& facet, const EdgeTicket& hint) {
    note_edge(facet[0], facet[1], hint);
    note_edge(facet[1], facet[2], hint);
    note_edge(facet[2], facet[0], hint);
}

void AdvancingFront::note_edges(DirectedEdge e) { note_edges_of(state_.facet_samples(e), state_.ticket(e)); }

double AdvancingFront::circumradius_of(const std::array<std::uint32_t, 3>& facet) const {
    return circumradius(state_.sample(facet[0]), state_.sample(facet[1]), state_.sample(facet[2]));
}

bool AdvancingFront::infer(DirectedEdge e) {
    if (state_.crossed(e) || !(circumradius_of(state_.facet_samples(e)) <= options_.epsilon)) return false;
    const std::optional<DirectedEdge> inwards = model_.infer(e, options_.epsilon);
    if (!inwards) return false;
    note_edges(*inwards);
    return true;
}

void AdvancingFront::note_thin(std::uint32_t sample) {
    if (thin_.size() <= sample) thin_.resize(state_.sample_count());
    thin_[sample] = true;
}

void AdvancingFront::note_insertion(const MaintainedDelaunay::Insertion& insertion) {
    // Samples that are nearer than ε are there to tell sheets apart.
    if (!thin_.empty()) {
        const Point& p = state_.sample(insertion.sample);
        state_.adjacent_samples(insertion.sample, adjacent_);
        if (std::any_of(adjacent_.begin(), adjacent_.end(),
                        [&](std::uint32_t b) { return is_thin(b) && (state_.sample(b) - p).norm() < options_.epsilon; })) {
            note_thin(insertion.sample);
        }
    }
    for (const auto& facet : insertion.lost) note_edges_of(facet, {});
    for (const DirectedEdge e : insertion.gained) note_edges(e);
    for (const DirectedEdge from_new : insertion.cropped) {
        for (int i = 0; i < 4; ++i) {
            const DirectedEdge e{from_new.cell, i};
            if (i != from_new.facet && e.cell > state_.neighbor(e)) continue;  // seen from the other new cell
            if (state_.is_finite(e)) infer(e);
        }
    }
}

void AdvancingFront::reconsider(DirectedEdge e) {
    if (!infer(e)) note_edges(e);
}

void AdvancingFront::sweep() {
    state_.for_each_edge([&](DirectedEdge e) {
        if (state_.recorded_state(e) == EdgeState::crossing) {
            note_edges(e);
        } else if (e.cell < state_.neighbor(e) && state_.is_finite(e)) {
            infer(e);
        }
    });
}

void AdvancingFront::note_audit(DirectedEdge e) {
    const auto facet = state_.facet_samples(e);
    const Point centre = (state_.sample(facet[0]) + state_.sample(facet[1]) + state_.sample(facet[2])) / 3;
    tasks_.add({in_order(facet), 0, centre, state_.ticket(e)});
}

// --- choosing --------------------------------------------------------------------------------------------------------

std::optional<AdvancingFront::OpenEdge> AdvancingFront::look_at(const Task& task) {
    OpenEdge edge;
    edge.a = task.samples[0];
    edge.b = task.samples[1];
    edge.attempts = task.attempts;
    // Where two sheets of S are that near, nothing beside the samples is likely to be free.
    if (is_thin(edge.a) || is_thin(edge.b)) return std::nullopt;
    state_.facets_around(edge.a, edge.b, task.hint, around_);
    int facets = 0;
    for (const DirectedEdge e : around_) {
        if (state_.in_surface(e)) {
            ++facets;
            edge.facet = *state_.crossed(e);
        }
    }
    if (facets != 1) return std::nullopt;
    Vector up = Vector::Zero();
    if (model_.has_clearance(edge.a)) up += model_.normal(edge.a);
    if (model_.has_clearance(edge.b)) up += model_.normal(edge.b);
    if (up.isZero()) return std::nullopt;
    for (const std::uint32_t v : state_.facet_samples(edge.facet)) {
        if (v != edge.a && v != edge.b) edge.c = v;
    }
    const Vector along = state_.sample(edge.b) - state_.sample(edge.a);
    edge.middle = (state_.sample(edge.a) + state_.sample(edge.b)) / 2;
    edge.half = along.norm() / 2;
    edge.up = (up - up.dot(along) / along.squaredNorm() * along).normalized();
    edge.ahead = edge.up.cross(along).normalized();
    if (edge.ahead.dot(state_.sample(edge.c) - edge.middle) > 0) edge.ahead = -edge.ahead;
    return edge;
}

bool AdvancingFront::infer_around() {
    return std::any_of(around_.begin(), around_.end(), [&](DirectedEdge e) { return infer(e); });
}

std::optional<FacetView> AdvancingFront::facet_ahead(const OpenEdge& edge) {
    std::optional<FacetView> best;
    double best_off = 0;
    for (const DirectedEdge e : around_) {
        if (state_.crossed(e)) continue;
        const auto corners = state_.facet_samples(e);
        const bool is_ahead = std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
            return v != edge.a && v != edge.b && (state_.sample(v) - edge.middle).dot(edge.ahead) > 0;
        });
        if (!is_ahead || !(circumradius_of(corners) < kLarge * options_.epsilon)) continue;
        if (missed_.contains(in_order(corners))) continue;
        const std::optional<FacetView> view = model_.view(e);
        if (!view || view->up.dot(edge.up) < kSteepest) continue;
        // How far S, if it were flat, would miss the dual edge.
        const double off = std::max({0.0, view->bottom, -view->top});
        if (best && best_off <= off) continue;
        best = view;
        best_off = off;
    }
    return best;
}

double AdvancingFront::Clearance::clamp(double height) const {
    const double inset = kInside * (span.high - span.low);
    return std::clamp(height, span.low + inset, span.high - inset);
}

std::optional<AdvancingFront::Clearance> AdvancingFront::clearance_at(const Point& place, const Vector& up,
                                                                      std::span<const std::uint32_t> samples) const {
    std::optional<Clearance> lowest;
    const auto chord = state_.surroundings().unknown_part(place, up);
    for (const std::uint32_t v : samples) {
        if (!model_.has_clearance(v)) continue;
        auto in = model_.clearance(v).clip(place, up);
        if (!in || !chord) continue;
        in->high = std::min(in->high, chord->high);
        if (in->low < in->high && (!lowest || in->low < lowest->span.low)) lowest = Clearance{*in, v};
    }
    return lowest;
}

std::optional<FrontTouch> AdvancingFront::touch_dual_edge(const FacetView& facet) const {
    const std::optional<Clearance> free = clearance_at(facet.line.origin, facet.up, facet.corners);
    if (!free) return std::nullopt;
    FrontTouch touch;
    // Where the edge's exterior end is in doubt itself, the probe starts above it.
    touch.start = facet.at(free->clamp(std::min(facet.top, options_.standoff)));
    touch.home = free->home;
    touch.certain = touch.expected = facet.interior && *facet.interior >= facet.bottom;
    touch.interior_of = touch.certain ? facet.interior_of : facet.corners[0];
    touch.target = facet.at(touch.certain ? *facet.interior : std::max(facet.bottom, -2 * options_.epsilon));
    touch.along = facet;
    touch.beside = facet.corners;
    return touch;
}

std::optional<AdvancingFront::Place> AdvancingFront::best_place(const OpenEdge& edge, const std::optional<Crease>& crease) {
    const double epsilon = options_.epsilon;
    const double wanted = model_.inferable_radius(std::array{edge.a, edge.b, edge.c}, epsilon);
    // A longer edge has a larger circle.
    const double largest = std::max(std::min(kLargest * wanted, kLargestOfAll * epsilon), edge.half * (1 + kInside));
    // In the tangent plane: ahead of the edge's middle, and along the edge.
    using Flat = Eigen::Vector2d;
    const Vector along = edge.up.cross(edge.ahead);
    const Flat centre(kAhead * epsilon, 0);
    flat_.clear();
    samples_.visit_near(edge.middle + centre.x() * edge.ahead, [&](std::uint32_t v) {
        Point p = state_.sample(v);
        if (crease && model_.has_clearance(v) && model_.normal(v).dot(model_.normal(crease->beyond)) > model_.normal(v).dot(edge.up)) {
            p = crease->fold.unfold(p);
        }
        const Vector d = p - edge.middle;
        const Flat at(d.dot(edge.ahead), d.dot(along));
        if (std::abs(d.dot(edge.up)) < kSheet * epsilon && (at - centre).norm() < kRange * epsilon) flat_.push_back(at);
    });
    Flat best = centre;
    double most = -std::numeric_limits<double>::infinity();
    const auto look_around = [&](double step, int steps) {
        const Flat from = best;
        for (int i = -steps; i <= steps; ++i) {
            for (int j = -steps; j <= steps; ++j) {
                const Flat at = from + step * Flat(i, j);
                const double to_centre = (at.squaredNorm() - edge.half * edge.half) / (2 * at.x());  // of the triangle's circle, ahead
                if (std::hypot(to_centre, edge.half) > largest) continue;
                double bonds = 0;
                for (const Flat& v : flat_) bonds += bond((v - at).norm() / wanted);
                if (bonds <= most) continue;
                most = bonds;
                best = at;
            }
        }
    };
    look_around(kStep * epsilon, 2);
    if (!std::isfinite(most)) return std::nullopt;
    look_around(kStep / 2 * epsilon, 1);
    look_around(kStep / 4 * epsilon, 1);
    return Place{edge.middle + best.x() * edge.ahead + best.y() * along, most};
}

std::optional<AdvancingFront::Crease> AdvancingFront::crease_ahead(const OpenEdge& edge) const {
    const Point centre = edge.middle + kAhead * options_.epsilon * edge.ahead;
    std::optional<std::uint32_t> nearest;
    double least = kCreaseRange * options_.epsilon;
    samples_.visit_near(centre, [&](std::uint32_t v) {
        const double distance = (state_.sample(v) - centre).norm();
        if (distance > least || !model_.has_clearance(v) || model_.normal(v).dot(edge.up) > kSameSide) return;
        nearest = v;
        least = distance;
    });
    if (!nearest) return std::nullopt;
    const auto fold = Fold::between(edge.middle, edge.up, state_.sample(*nearest), model_.normal(*nearest));
    if (!fold) return std::nullopt;
    return Crease{*fold, *nearest};
}

std::optional<FrontTouch> AdvancingFront::touch_along(const Point& place, const Vector& up,
                                                      const std::array<std::uint32_t, 3>& beside) const {
    FrontTouch touch;
    touch.beside = beside;
    const std::optional<Clearance> free = clearance_at(place, up, touch.beside);
    const auto chord = state_.surroundings().unknown_part(place, up);
    if (!free || !chord) return std::nullopt;
    const std::optional<SurfaceModel::Depth> inside = model_.inside_below(place, up, touch.beside);
    touch.interior_of = inside ? inside->of : beside[0];
    // S is met between these heights: everywhere there the touch must keep its distance.
    const double low = std::max(inside ? inside->height : -kLow * options_.epsilon, chord->low);
    bool spaced = true;
    samples_.visit_near(place, [&](std::uint32_t v) {
        const Vector d = state_.sample(v) - place;
        const double height = std::clamp(d.dot(up), std::min(low, free->span.low), free->span.low);
        spaced = spaced && (d - height * up).norm() > kSpacing * options_.epsilon;
    });
    if (!spaced) return std::nullopt;
    touch.start = place + free->clamp(options_.standoff) * up;
    touch.home = free->home;
    touch.target = place + low * up;
    touch.certain = inside.has_value();
    touch.expected = touch.certain || model_.expects(touch.beside);
    return touch;
}

std::optional<FrontTouch> AdvancingFront::touch_at(const OpenEdge& edge, const std::optional<Crease>& crease, const Point& place) const {
    if (crease && crease->fold.past(place) > kPast * options_.epsilon) {
        const auto touch = touch_along(crease->fold.fold(place), model_.normal(crease->beyond), {crease->beyond, edge.a, edge.b});
        if (touch) return touch;
    }
    auto touch = touch_along(place, edge.up, {edge.a, edge.b, edge.c});
    const Point under = edge.middle - kUnder * (place - edge.middle).norm() * edge.up;
    if (touch && !state_.surroundings().is_free(under)) touch->under = under;
    return touch;
}

std::optional<FrontTouch> AdvancingFront::touch_ahead(const OpenEdge& edge, const std::optional<Crease>& crease,
                                                      const std::optional<Place>& place, const std::optional<FacetView>& ahead) {
    std::optional<FrontTouch> touch;
    // By turns: what was touched and closed nothing is not touched again at once.
    if (place && edge.attempts % 2 == 0) touch = touch_at(edge, crease, place->at);
    if (!touch && ahead) touch = touch_at(edge, crease, ahead->line.origin);
    if (!touch && ahead) touch = touch_dual_edge(*ahead);
    return touch;
}

std::optional<FrontTouch> AdvancingFront::touch_audited(const Task& task) {
    const auto e = state_.find_facet(task.samples[0], task.samples[1], task.samples[2]);
    const auto inferred = e ? state_.inferred(*e) : std::nullopt;
    if (!inferred) return std::nullopt;  // gone, or touched by now
    const auto view = model_.view(*inferred);
    auto touch = view ? touch_dual_edge(*view) : std::nullopt;
    if (!touch) ++audits_barred_;
    if (touch) touch->audit = true;
    return touch;
}

std::optional<AdvancingFront::Taken> AdvancingFront::take_task(const Point& head) {
    if (const auto task = tasks_.take_nearest(head)) return Taken{*task, &tasks_};
    if (const auto task = on_known_.take_nearest(head)) return Taken{*task, &on_known_};
    if (const auto task = without_motion_.take_nearest(looked_)) return Taken{*task, &without_motion_};
    if (const auto task = with_motion_.take_nearest(head)) return Taken{*task, &with_motion_};
    return std::nullopt;
}

bool AdvancingFront::is_far_from_object(const Point& place) const {
    bool is_far = true;
    samples_.visit_near(place, [&](std::uint32_t v) {
        is_far = is_far && ((state_.sample(v) - place).norm() > kFar * options_.epsilon || state_.is_known(v));
    });
    return is_far;
}

std::optional<FrontTouch> AdvancingFront::look_across() const {
    const KnownSolids& known = state_.surroundings().known();
    for (const DirectedEdge e : around_) {
        const auto corners = state_.facet_samples(e);
        if (state_.crossed(e) || missed_.contains(in_order(corners)) || !state_.are_known(corners)) continue;
        const std::optional<FacetView> view = model_.view(e);
        if (!view) continue;
        FrontTouch touch;
        touch.start = view->at(view->top);
        touch.target = view->at(view->bottom);
        if (known.contains(touch.start) || !known.contains(touch.target)) continue;
        touch.known = known.first_entry({touch.start, touch.target});
        if (!touch.known) continue;
        const bool may_assume = state_.surroundings().assumes_clear() && is_far_from_object(*touch.known);
        if (!known.is_buried(touch.start) && !may_assume) continue;
        touch.along = view;
        touch.beside = corners;
        return touch;
    }
    return std::nullopt;
}

void AdvancingFront::look_up(FrontTouch& touch) const {
    const Surroundings& surroundings = state_.surroundings();
    const KnownSolids& known = surroundings.known();
    const auto enters = [&](const Point& from, const Point& to) { return known.first_entry({from, to}); };
    std::optional<Point> entry;
    if (known.contains(touch.start)) {
        // Another solid stands there: a tool that came from above the open edge would meet its side.
        const Point middle = (state_.sample(touch.beside[0]) + state_.sample(touch.beside[1])) / 2;
        entry = enters(middle + options_.standoff * (touch.start - touch.target).normalized(), touch.start);
    } else {
        entry = enters(touch.start, touch.target);
    }
    if (!entry && touch.under) entry = enters(touch.target, *touch.under);
    const Point& end = entry ? *entry : touch.target;
    const bool is_buried = known.is_buried(end);
    const bool may_assume = is_buried || (surroundings.assumes_clear() && entry);
    if (!may_assume || !is_far_from_object(end)) return;
    touch.known = entry;
    touch.is_buried = is_buried;
}

std::optional<FrontTouch> AdvancingFront::next(const Point& head) {
    for (; known_ < state_.sample_count(); ++known_) samples_.add(known_, state_.sample(known_));
    while (const std::optional<Taken> taken = take_task(head)) {
        const Task* const task = &taken->task;
        if (task->samples[2] != Task::kNoSample) {
            if (const auto touch = touch_audited(*task)) return touch;
            continue;
        }
        const std::optional<OpenEdge> edge = look_at(*task);
        if (!edge) continue;
        if (edge->attempts > kMaxAttempts) {
            // No touch ahead closed it. A dual edge that is known does, or leads to a sample that the edges of a plate want.
            if (auto across = taken->queue != &tasks_ && edge->attempts <= kMaxLooks ? look_across() : std::nullopt) {
                looked_ = task->at;
                on_known_.add({task->samples, edge->attempts + 1, task->at, state_.ticket(edge->facet), task->handicap});
                return across;
            }
            given_up_.insert({edge->a, edge->b});
            continue;
        }
        // Normals may be known better by now than when the facets around were new.
        if (infer_around()) continue;
        const std::optional<FacetView> ahead = facet_ahead(*edge);
        const bool in_doubt = ahead && ahead->line.circumradius <= options_.epsilon && edge->attempts < kDualAttempts;
        const std::optional<Crease> crease = crease_ahead(*edge);
        const std::optional<Place> place = best_place(*edge, crease);
        const double waits = in_doubt ? kDoubtWaits : std::max(0.0, kBonds - (place ? place->bonds : 0.0));
        // More samples around only make an edge wait longer, so that it is enough to look when its turn would come.
        if (waits * options_.epsilon > task->handicap) {
            taken->queue->add({task->samples, edge->attempts, task->at, state_.ticket(edge->facet), waits * options_.epsilon});
            continue;
        }
        std::optional<FrontTouch> touch;
        if (in_doubt) touch = touch_dual_edge(*ahead);
        if (!touch) touch = touch_ahead(*edge, crease, place, ahead);
        if (!touch && taken->queue != &tasks_) touch = look_across();
        if (!touch) {
            given_up_.insert({edge->a, edge->b});
            continue;
        }
        if (taken->queue != &tasks_ && !touch->known) look_up(*touch);
        const bool needs_motion = !touch->known && !touch->is_buried;
        if (taken->queue == &on_known_) {
            (needs_motion ? with_motion_ : without_motion_).add(*task);
            continue;
        }
        if (!needs_motion) looked_ = task->at;
        // Until it is closed.
        TaskGrid& queue = taken->queue == &tasks_ ? tasks_ : on_known_;
        queue.add({task->samples, edge->attempts + 1, task->at, state_.ticket(edge->facet), task->handicap});
        return touch;
    }
    return std::nullopt;
}

}  // namespace palpate
