#include "planner/topology.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

#include "planner/union_find.h"

namespace palpate {
namespace {

struct HalfEdge {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    std::uint32_t facet = 0;
    bool ascending = false;

    [[nodiscard]] bool same_edge(const HalfEdge& other) const { return low == other.low && high == other.high; }
};

std::vector<HalfEdge> sorted_half_edges(const TriangleMesh& mesh) {
    std::vector<HalfEdge> half_edges;
    half_edges.reserve(3 * mesh.triangles.size());
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[f][k];
            const std::uint32_t b = mesh.triangles[f][(k + 1) % 3];
            half_edges.push_back({std::min(a, b), std::max(a, b), f, a < b});
        }
    }
    std::sort(half_edges.begin(), half_edges.end(),
              [](const HalfEdge& x, const HalfEdge& y) { return std::tie(x.low, x.high, x.facet) < std::tie(y.low, y.high, y.facet); });
    return half_edges;
}

void classify_edge(std::span<const HalfEdge> fan, Topology& topology) {
    Defect defect{Defect::Kind::boundary_edge, {fan[0].low, fan[0].high}, {}};
    if (fan.size() == 1) {
        ++topology.boundary_edges;
    } else if (fan.size() > 2) {
        defect.kind = Defect::Kind::nonmanifold_edge;
        ++topology.nonmanifold_edges;
    } else if (fan[0].ascending == fan[1].ascending) {
        defect.kind = Defect::Kind::inconsistent_edge;
        ++topology.inconsistent_edges;
    } else {
        return;
    }
    for (const HalfEdge& h : fan) defect.facets.push_back(h.facet);
    topology.defects.push_back(std::move(defect));
}

// Corners of facets are joined where facets share an edge: a vertex whose corners stay apart has several umbrellas.
void find_split_vertices(const TriangleMesh& mesh, const std::vector<HalfEdge>& half_edges, Topology& topology) {
    const auto corner = [&](std::uint32_t facet, std::uint32_t vertex) {
        const auto& t = mesh.triangles[facet];
        return 3 * facet + static_cast<std::uint32_t>(std::find(t.begin(), t.end(), vertex) - t.begin());
    };
    UnionFind corners(3 * mesh.triangles.size());
    for (std::size_t k = 1; k < half_edges.size(); ++k) {
        const HalfEdge& a = half_edges[k - 1];
        const HalfEdge& b = half_edges[k];
        if (!a.same_edge(b)) continue;
        corners.join(corner(a.facet, a.low), corner(b.facet, a.low));
        corners.join(corner(a.facet, a.high), corner(b.facet, a.high));
    }
    std::vector<std::uint32_t> umbrellas(mesh.points.size());
    for (std::uint32_t c = 0; c < 3 * mesh.triangles.size(); ++c) {
        if (corners.root(c) == c) ++umbrellas[mesh.triangles[c / 3][c % 3]];
    }
    std::vector<std::uint32_t> defect_of(mesh.points.size());
    for (std::uint32_t v = 0; v < umbrellas.size(); ++v) {
        if (umbrellas[v] <= 1) continue;
        ++topology.split_vertices;
        topology.defects.push_back({Defect::Kind::split_vertex, {v, v}, {}});
        defect_of[v] = static_cast<std::uint32_t>(topology.defects.size());
    }
    if (topology.split_vertices == 0) return;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
        for (const std::uint32_t v : mesh.triangles[f]) {
            if (defect_of[v] != 0) topology.defects[defect_of[v] - 1].facets.push_back(f);
        }
    }
}

void count_components(const TriangleMesh& mesh, Topology& topology) {
    UnionFind vertices(mesh.points.size());
    std::vector<bool> used(mesh.points.size());
    for (const auto& t : mesh.triangles) {
        vertices.join(t[0], t[1]);
        vertices.join(t[1], t[2]);
        for (const std::uint32_t v : t) used[v] = true;
    }
    std::vector<double> volume(mesh.points.size());
    for (const auto& t : mesh.triangles) {
        // Relative to a point of the component, so that a component far from the origin loses no digits.
        const std::size_t root = vertices.root(t[0]);
        const Point& o = mesh.points[root];
        volume[root] += (mesh.points[t[0]] - o).dot((mesh.points[t[1]] - o).cross(mesh.points[t[2]] - o)) / 6;
    }
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        if (!used[v]) continue;
        ++topology.vertices;
        if (vertices.root(v) != v) continue;
        ++topology.components;
        if (volume[v] <= 0) ++topology.inward_components;
    }
}

}  // namespace

Topology analyse_topology(const TriangleMesh& mesh) {
    Topology topology;
    topology.facets = mesh.triangles.size();
    const std::vector<HalfEdge> half_edges = sorted_half_edges(mesh);
    for (std::size_t begin = 0; begin < half_edges.size();) {
        std::size_t end = begin + 1;
        while (end < half_edges.size() && half_edges[end].same_edge(half_edges[begin])) ++end;
        ++topology.edges;
        classify_edge({&half_edges[begin], end - begin}, topology);
        begin = end;
    }
    find_split_vertices(mesh, half_edges, topology);
    count_components(mesh, topology);
    topology.euler_characteristic = static_cast<std::int64_t>(topology.vertices) - static_cast<std::int64_t>(topology.edges) +
                                    static_cast<std::int64_t>(topology.facets);
    return topology;
}

double surface_area(const TriangleMesh& mesh) {
    double doubled = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        doubled += (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm();
    }
    return doubled / 2;
}

}  // namespace palpate
