#include "planner/delaunay/restricted_surface.h"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

double approach_length(const Crossing& crossing) { return (crossing.near - crossing.from).norm(); }

}  // namespace

std::optional<std::uint32_t> RestrictedSurface::point_of(std::uint32_t sample) const {
    const auto found = std::ranges::lower_bound(sample_of, sample);
    if (found == sample_of.end() || *found != sample) return std::nullopt;
    return static_cast<std::uint32_t>(found - sample_of.begin());
}

std::vector<std::uint32_t> RestrictedSurface::unused_samples(std::size_t sample_count) const {
    std::vector<std::uint32_t> unused;
    auto next = sample_of.begin();
    for (std::uint32_t sample = 0; sample < sample_count; ++sample) {
        if (next != sample_of.end() && *next == sample) {
            ++next;
        } else {
            unused.push_back(sample);
        }
    }
    return unused;
}

RestrictedSurface extract_surface(const MaintainedDelaunay& state) {
    RestrictedSurface surface;
    std::vector<bool> used(state.sample_count());
    state.for_each_edge([&](DirectedEdge e) {
        if (state.recorded_state(e) != EdgeState::crossing) return;
        if (state.is_double(e)) return;
        const DirectedEdge back = state.opposite(e);
        const double radius = state.crossing(e).ball_radius;
        if (state.recorded_state(back) == EdgeState::crossing) {
            const double other = state.crossing(back).ball_radius;
            // The same touch for both directions: S passes through one end, and the other end is the free side.
            const auto rank = [&](DirectedEdge edge) { return std::pair(-approach_length(state.crossing(edge)), edge.cell); };
            if (other < radius || (other == radius && rank(back) < rank(e))) return;
        }
        surface.mesh.triangles.push_back(state.facet_samples(e));
        for (const std::uint32_t sample : surface.mesh.triangles.back()) used[sample] = true;
        surface.dual_edges.push_back(e);
        surface.ball_radii.push_back(radius);
    });
    std::vector<std::uint32_t> point_of(used.size());
    for (std::uint32_t sample = 0; sample < used.size(); ++sample) {
        if (!used[sample]) continue;
        point_of[sample] = static_cast<std::uint32_t>(surface.mesh.points.size());
        surface.mesh.points.push_back(state.sample(sample));
        surface.sample_of.push_back(sample);
    }
    for (auto& triangle : surface.mesh.triangles) {
        for (std::uint32_t& vertex : triangle) vertex = point_of[vertex];
    }
    return surface;
}

}  // namespace palpate
