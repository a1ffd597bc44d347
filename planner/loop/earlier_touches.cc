#include "planner/loop/earlier_touches.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "planner/errors.h"
#include "planner/loop/sample_grid.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// A place that has not moved is met again within so many touch errors. A shift of this part of ε, and of the tolerance, does no harm.
constexpr double kTouchErrors = 5.0;
constexpr double kOfEpsilon = 0.01;
constexpr double kOfTolerance = 0.5;
// Places touched again. More would tell a turn from a shift.
constexpr std::size_t kChecked = 3;
// Places in a row that no way led to, after which it is enough.
constexpr std::size_t kMostBarred = 12;
// The sine of the angle between a place's normal and those before: with less it would not show a shift of its own.
constexpr double kIndependent = 0.3;
// Of ε: what is met farther from all earlier touches is new.
constexpr double kStrange = 1.5;

bool span_space(std::span<const Point> points) {
    if (points.size() < 4) return false;
    const Point& a = points.front();
    const auto far = [&](const auto& measure) {
        return *std::ranges::max_element(points, {}, [&](const Point& p) -> double { return measure(Vector(p - a)); });
    };
    const Vector u = (far([](const Vector& v) { return v.squaredNorm(); }) - a).normalized();
    const Vector v = far([&](const Vector& w) { return u.cross(w).squaredNorm(); }) - a;
    const Vector normal = u.cross(v).normalized();
    if (!normal.allFinite()) return false;
    const Vector w = far([&](const Vector& x) { return std::abs(normal.dot(x)); }) - a;
    // Far above rounding: the exact predicates of the triangulation decide what is less.
    constexpr double kThinnest = 1e-9;
    return std::abs(normal.dot(w)) > kThinnest * (w.norm() + v.norm());
}

}  // namespace

EarlierTouches::EarlierTouches(const Options& options, double touch_error, const Criteria& criteria, ProbedSpace& space, ProbeHead& head)
    : state_(space.delaunay()),
      epsilon_(options.epsilon),
      same_place_(std::max(touch_error, MaintainedDelaunay::kSamePlace * state_.surroundings().region().radius())) {
    const double harmless = std::min(kOfEpsilon * options.epsilon, kOfTolerance * options.tolerance.value_or(options.epsilon));
    evidence_.limit = options.earlier_limit.value_or(std::max(kTouchErrors * touch_error, harmless));
    std::vector<Point> samples;
    std::vector<std::uint32_t> touches;
    SampleGrid grid(options.epsilon);
    const auto nearest = [&](const Point& p) {
        double least = options.epsilon;
        grid.visit_near(p, [&](std::uint32_t s) { least = std::min(least, (samples[s] - p).norm()); });
        return least;
    };
    // Samples first: what else was touched then finds them.
    for (const bool takes_samples : {true, false}) {
        for (const EarlierTouch& touch : options.earlier) {
            const Vector outwards = touch.from - touch.position;
            if (touch.is_sample != takes_samples || state_.surroundings().known_normal(touch.position)) continue;
            ++evidence_.touches;
            const double least = takes_samples ? kSeedSpacing * options.epsilon
                                               : std::min(criteria.size_at(touch.position), options.epsilon * (1 - kSeedSpacing));
            // What was touched without a move says nothing of the side that S was touched from.
            if (outwards.isZero(0) || nearest(touch.position) <= least) {
                others_.push_back({touch.position, touch.from});
                continue;
            }
            const auto sample = static_cast<std::uint32_t>(samples.size());
            grid.add(sample, touch.position);
            samples.push_back(touch.position);
            touches.push_back(head.note_earlier(touch.position, touch.from));
            places_.push_back({touch.position, outwards.normalized(), outwards.normalized(), sample});
        }
    }
    evidence_.samples = samples.size();
    if (!span_space(samples)) {
        throw SeedError(fmt::format(
            "the earlier touches, {} of {}, do not span a volume: begin a new session, or give those of one that had found more",
            evidence_.touches, options.earlier.size()));
    }
    space.delaunay().initialise(samples);
    for (std::uint32_t k = 0; k < touches.size(); ++k) head.assign(touches[k], Touch::Role::earlier, k);
    for (const Other& other : others_) learn_crossings(other, head.note_earlier(other.position, other.from), space.delaunay());
}

void EarlierTouches::learn_crossings(const Other& touch, std::uint32_t number, MaintainedDelaunay& state) const {
    const Point& at = touch.position;
    for (const CellId cell : state.cells_around(state.nearest_sample(at, state.cell_at(0)))) {
        for (int i = 0; i < 4; ++i) {
            const DirectedEdge e{cell, i};
            if (!state.is_finite(e) || state.crossed(e)) continue;
            const auto span = state.span(e);
            if (!span) continue;
            const Point start = span->start_point();
            const Vector inwards = (span->end_point() - start).normalized();
            if (!(inwards.dot(touch.from - at) < 0)) continue;
            const double along = inwards.dot(at - start);
            const double off = (at - start - along * inwards).norm();
            if (!(off <= same_place_) || along < 0 || along > (span->end_point() - start).norm()) continue;
            Crossing seen;  // no tool of this run was there
            seen.near = seen.far = seen.from = at;
            seen.from_vertex = false;
            seen.touch = number;
            state.learn_contact(e, seen);
        }
    }
}

// Nothing that is known stands in the tube around the way there.
bool EarlierTouches::is_seen(const Place& place) const {
    return std::ranges::none_of(state_.samples(), [&](const Point& p) {
        const Vector d = p - place.at;
        const double height = place.outwards.dot(d);
        return height > epsilon_ && (d - height * place.outwards).norm() < epsilon_;
    });
}

std::optional<EarlierTouches::Place> EarlierTouches::next(const NormalOf& normal) {
    if (normals_.size() == kChecked) return std::nullopt;
    const Point centre = state_.surroundings().region().center();
    // In how far a place shows a shift that those before do not.
    const auto shows = [&](const Place& place) {
        const Vector n = normal(place.sample);
        if (normals_.empty()) return 1.0;
        return normals_.size() == 1 ? normals_[0].cross(n).norm() : std::abs(normals_[0].cross(normals_[1]).normalized().dot(n));
    };
    // ... and how far out it lies.
    const auto worth = [&](const Place& place) {
        const double height = place.outwards.dot(place.at - centre) + state_.surroundings().region().radius();
        return height * shows(place);
    };
    while (barred_ < kMostBarred && !places_.empty()) {
        const auto best = std::ranges::max_element(places_, {}, worth);
        Place place = *best;
        if (shows(place) < kIndependent) break;
        places_.erase(best);
        place.normal = normal(place.sample);
        if (is_seen(place)) return place;
    }
    if (strange_) {
        throw ContradictionError(fmt::format(
            "the object has moved since the earlier run, or something else is there now: at {} something was met where nothing was; put it "
            "back, or begin a new session",
            point_text(*strange_)));
    }
    if (!normals_.empty()) return std::nullopt;
    throw SeedError(
        fmt::format("none of the {} earlier touches could be touched again, to see that the object has not moved: begin a new session",
                    evidence_.touches));
}

void EarlierTouches::note(const Place& place, const Found& found) {
    const auto refuse = [&](const std::string& how) {
        throw ContradictionError(
            fmt::format("the object has moved since the earlier run: at {} {}. Put it back and give another folder, or begin a new session",
                        point_text(place.at), how));
    };
    if (!found.met) {
        if (!found.on_the_way && !found.is_failed) refuse(fmt::format("nothing was met, {:.3g} mm deep", epsilon_));
        ++barred_;
        if (!found.on_the_way) return;
        const Point& nearest = state_.sample(state_.nearest_sample(*found.on_the_way, state_.cell_at(place.sample)));
        if ((nearest - *found.on_the_way).norm() > kStrange * epsilon_) strange_ = found.on_the_way;
        return;
    }
    const double off = (*found.met - place.at).norm();
    ++evidence_.checked;
    ++evidence_.directions;
    evidence_.worst = std::max(evidence_.worst, off);
    normals_.push_back(place.normal);
    barred_ = 0;
    if (off > evidence_.limit) refuse(fmt::format("it was met {:.3g} mm off, more than {:.3g} mm", off, evidence_.limit));
}

}  // namespace palpate
