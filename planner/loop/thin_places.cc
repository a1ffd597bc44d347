#include "planner/loop/thin_places.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "planner/union_find.h"

namespace palpate {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

std::array<Edge, 3> edges_of(const std::array<std::uint32_t, 3>& facet) {
    const auto [a, b, c] = in_order(facet);
    return {Edge{a, b}, Edge{a, c}, Edge{b, c}};
}

template <typename T>
void make_unique(std::vector<T>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

// Ŝ, by sample.
struct Used {
    std::vector<bool> samples;
    std::vector<Edge> edges;  // sorted

    explicit Used(const MaintainedDelaunay& state, const RestrictedSurface& surface) : samples(state.sample_count()) {
        for (const std::uint32_t sample : surface.sample_of) samples[sample] = true;
        for (const auto& t : surface.mesh.triangles) {
            for (const Edge& e : edges_of({surface.sample_of[t[0]], surface.sample_of[t[1]], surface.sample_of[t[2]]})) edges.push_back(e);
        }
        make_unique(edges);
    }
    [[nodiscard]] bool has(const Edge& e) const { return std::binary_search(edges.begin(), edges.end(), e); }
};

// Vertices and edges of a complex.
struct Complex {
    std::vector<std::uint32_t> samples;  // sorted
    std::vector<Edge> edges;             // sorted

    [[nodiscard]] long characteristic(std::size_t facets) const {
        return static_cast<long>(samples.size()) - static_cast<long>(edges.size()) + static_cast<long>(facets);
    }
    [[nodiscard]] std::size_t components() const {
        UnionFind sets(samples.size());
        const auto index = [&](std::uint32_t s) {
            return static_cast<std::size_t>(std::lower_bound(samples.begin(), samples.end(), s) - samples.begin());
        };
        for (const auto& [a, b] : edges) sets.join(index(a), index(b));
        std::size_t count = 0;
        for (std::size_t k = 0; k < samples.size(); ++k) count += sets.root(k) == k ? 1 : 0;
        return count;
    }
};

ThinPlace assess(const MaintainedDelaunay& state, const Used& used, const std::vector<DirectedEdge>& patch, double epsilon) {
    ThinPlace place;
    place.thickness = std::numeric_limits<double>::infinity();
    Complex whole;
    for (const DirectedEdge e : patch) {
        const auto facet = state.facet_samples(e);
        whole.samples.insert(whole.samples.end(), facet.begin(), facet.end());
        for (const Edge& edge : edges_of(facet)) whole.edges.push_back(edge);
        if (state.thickness(e) >= place.thickness) continue;
        place.thickness = state.thickness(e);
        place.position = (state.crossing(e).near + state.crossing(state.opposite(e)).near) / 2;
    }
    make_unique(whole.samples);
    make_unique(whole.edges);
    Complex shared;
    for (const std::uint32_t s : whole.samples) {
        if (used.samples[s]) shared.samples.push_back(s);
    }
    for (const Edge& edge : whole.edges) {
        if (used.has(edge)) shared.edges.push_back(edge);
    }
    place.unused = static_cast<std::uint32_t>(whole.samples.size() - shared.samples.size());
    const bool is_near = std::all_of(whole.samples.begin(), whole.samples.end(), [&](std::uint32_t s) {
        return used.samples[s] || std::any_of(shared.samples.begin(), shared.samples.end(),
                                              [&](std::uint32_t t) { return (state.sample(s) - state.sample(t)).norm() <= epsilon; });
    });
    place.is_minor = is_near && shared.components() == 1 && shared.characteristic(0) == 1 && whole.characteristic(patch.size()) == 1;
    return place;
}

}  // namespace

std::vector<DirectedEdge> doubly_crossed(const MaintainedDelaunay& state) {
    std::vector<DirectedEdge> edges;
    state.for_each_edge([&](DirectedEdge e) {
        if (state.is_double(e) && e.cell < state.neighbor(e)) edges.push_back(e);
    });
    return edges;
}

std::vector<ThinPlace> find_thin_places(const MaintainedDelaunay& state, const RestrictedSurface& surface, double epsilon) {
    const Used used(state, surface);
    const std::vector<DirectedEdge> facets = doubly_crossed(state);
    // Facets that share a vertex or an edge that Ŝ does not have.
    UnionFind patches(facets.size());
    std::vector<std::pair<Edge, std::size_t>> links;  // a vertex as an edge to itself
    std::vector<bool> explained = used.samples;
    for (std::size_t k = 0; k < facets.size(); ++k) {
        const auto facet = state.facet_samples(facets[k]);
        for (const std::uint32_t s : facet) {
            if (!used.samples[s]) links.emplace_back(Edge{s, s}, k);
            explained[s] = true;
        }
        for (const Edge& edge : edges_of(facet)) {
            if (!used.has(edge)) links.emplace_back(edge, k);
        }
    }
    std::sort(links.begin(), links.end());
    for (std::size_t k = 1; k < links.size(); ++k) {
        if (links[k].first == links[k - 1].first) patches.join(links[k].second, links[k - 1].second);
    }
    std::vector<std::vector<DirectedEdge>> members(facets.size());
    for (std::size_t k = 0; k < facets.size(); ++k) members[patches.root(k)].push_back(facets[k]);
    std::vector<ThinPlace> places;
    for (const auto& patch : members) {
        if (!patch.empty()) places.push_back(assess(state, used, patch, epsilon));
    }
    for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
        // On a known solid it may lie below the object's foot.
        if (!explained[s] && !state.is_known(s)) places.push_back({state.sample(s), 0.0, 1, false});
    }
    return places;
}

}  // namespace palpate
