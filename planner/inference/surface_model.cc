#include "planner/inference/surface_model.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double FacetView::ball_radius() const { return std::hypot(line.circumradius, std::max(std::abs(*exterior), std::abs(*interior))); }

void SurfaceModel::distrust(DirectedEdge e) {
    distrusted_.insert(in_order(state_.facet_samples(e)));
    state_.withdraw(e);
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
    if (!distrusted_.empty() && distrusted_.contains(in_order(seen->corners))) return std::nullopt;
    state_.learn_inferred(seen->inwards, seen->at(*seen->exterior), seen->at(*seen->interior));
    if (watcher_) watcher_(seen->at(*seen->exterior), seen->at(*seen->interior));
    return seen->inwards;
}

}  // namespace palpate
