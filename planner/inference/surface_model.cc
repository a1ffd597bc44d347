#include "planner/inference/surface_model.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double FacetView::ball_radius() const { return std::hypot(line.circumradius, std::max(std::abs(*exterior), std::abs(*interior))); }

void SurfaceModel::distrust(DirectedEdge e) {
    distrusted_.insert(in_order(state_.facet_samples(e)));
    state_.withdraw(e);
}

double SurfaceModel::radius_within_ball(double bend) { return std::max(std::sqrt(2 / (1 + std::hypot(1, bend))), kLeastRadius); }

std::vector<std::uint32_t> SurfaceModel::samples_around(const Point& x, std::uint32_t home) const {
    const std::uint32_t nearest = state_.nearest_sample(x, state_.cell_at(home));
    std::vector<std::uint32_t> samples;
    state_.adjacent_samples(nearest, samples);
    samples.push_back(nearest);
    return samples;
}

FacetView SurfaceModel::look_along(DirectedEdge e, const EdgeSpan& along, const Vector& outwards) const {
    FacetView seen;
    seen.corners = state_.facet_samples(e);
    seen.line = along.line;
    const double sign = outwards.dot(along.line.direction) >= 0 ? 1 : -1;
    seen.up = sign * along.line.direction;
    const double start = sign * along.start;
    const double end = sign * along.end;
    seen.inwards = start >= end ? e : state_.opposite(e);
    seen.top = std::max(start, end);
    seen.bottom = std::min(start, end);
    return seen;
}

std::optional<DirectedEdge> SurfaceModel::infer(DirectedEdge e, double max_ball_radius) {
    if (state_.crossed(e)) return std::nullopt;
    const std::optional<FacetView> seen = view(e);
    if (seen && seen->is_contradictory()) {
        note_contradiction(*seen);
        return std::nullopt;
    }
    if (!seen || !seen->is_crossed() || seen->ball_radius() > max_ball_radius) return std::nullopt;
    if (state_.recorded_state(seen->inwards) != EdgeState::unknown) return std::nullopt;
    if (!distrusted_.empty() && is_distrusted(seen->corners)) return std::nullopt;
    state_.learn_inferred(seen->inwards, seen->at(*seen->exterior), seen->at(*seen->interior));
    if (watcher_) watcher_(seen->at(*seen->exterior), seen->at(*seen->interior));
    return seen->inwards;
}

}  // namespace palpate
