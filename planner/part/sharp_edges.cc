#include "planner/part/internal/sharp_edges.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>

#include "planner/part/internal/facet_fans.h"

namespace palpate {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using VertexIndex = Mesh::Vertex_index;

// A facet may turn so far from the normals at its corners, as a cosine, by joining others; if it did before, no farther.
constexpr double kTurnedOver = 0.0;

// Over the mesh: a flip may leave another flat facet, further along the edge.
constexpr int kSweeps = 5;

Kernel::Point_3 to_cgal(const Point& p) { return {p.x(), p.y(), p.z()}; }

using Soup = std::vector<std::vector<std::size_t>>;
Soup soup_of(const TriangleMesh& mesh) {
    Soup soup;
    soup.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) soup.push_back({a, b, c});
    return soup;
}
std::vector<Kernel::Point_3> points_of(const TriangleMesh& mesh) {
    std::vector<Kernel::Point_3> points;
    points.reserve(mesh.points.size());
    for (const Point& p : mesh.points) points.push_back(to_cgal(p));
    return points;
}

// One run over a mesh whose points and facets have the numbers that they have in `part`.
class Joiner {
public:
    Joiner(PartSurface& part, double length) : part_(part), length_(length), expected_(part.mesh.triangles.size()) {
        pmp::polygon_soup_to_polygon_mesh(points_of(part.mesh), soup_of(part.mesh), mesh_);
        for (std::size_t f = 0; f < expected_.size(); ++f) {
            for (const std::uint32_t v : part.mesh.triangles[f]) expected_[f] += part.normals[v];
        }
    }

    void run() {
        // The shortest edge first, ties by number.
        using Entry = std::tuple<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        const auto note = [&](Mesh::Edge_index edge) {
            const double length = length_of(edge);
            if (length < length_) open.emplace(length, static_cast<std::uint32_t>(edge.idx()));
        };
        for (const auto edge : mesh_.edges()) note(edge);
        while (!open.empty()) {
            const auto [length, number] = open.top();
            open.pop();
            const Mesh::Edge_index edge(number);
            if (mesh_.is_removed(edge) || length_of(edge) != length) continue;
            const auto kept = join(edge);
            if (!kept) continue;
            for (const auto h : CGAL::halfedges_around_target(*kept, mesh_)) note(mesh_.edge(h));
        }
        flatten_caps();
        write_back();
    }

private:
    // A facet whose corners lie in a row along a sharp edge: its longest edge is flipped into the facet beyond.
    void flatten_caps() {
        for (int round = 0; round < kSweeps; ++round) {
            bool changes = false;
            for (const auto f : mesh_.faces()) {
                auto longest = mesh_.halfedge(f);
                for (const auto h : CGAL::halfedges_around_face(mesh_.halfedge(f), mesh_)) {
                    if (length_of(mesh_.edge(h)) > length_of(mesh_.edge(longest))) longest = h;
                }
                const double base = length_of(mesh_.edge(longest));
                const Vector twice = twice_area(mesh_.source(longest), mesh_.target(longest), mesh_.target(mesh_.next(longest)));
                if (twice.norm() < base * length_ / 2) changes |= flip(longest);
            }
            if (!changes) break;
        }
    }
    [[nodiscard]] Vector twice_area(VertexIndex a, VertexIndex b, VertexIndex c) const { return (at(b) - at(a)).cross(at(c) - at(a)); }
    bool flip(Mesh::Halfedge_index h) {
        const auto beyond = mesh_.opposite(h);
        if (mesh_.is_border(h) || mesh_.is_border(beyond)) return false;
        const VertexIndex a = mesh_.source(h);
        const VertexIndex b = mesh_.target(h);
        const VertexIndex c = mesh_.target(mesh_.next(h));
        const VertexIndex d = mesh_.target(mesh_.next(beyond));
        for (const VertexIndex v : {a, b, c, d}) {
            if (!is_measured(part_.tags[v.idx()])) return false;
        }
        if (c == d || CGAL::halfedge(c, d, mesh_).second) return false;
        // The two that come are at least as tall as the flat one, and look the way that the other one does.
        const Vector outside = twice_area(b, a, d);
        const Vector one = twice_area(a, d, c);
        const Vector other = twice_area(d, b, c);
        const double flat = twice_area(a, b, c).norm() / length_of(mesh_.edge(h));
        const auto height = [&](const Vector& twice, std::array<VertexIndex, 3> corners) {
            double longest = 0;
            for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, (at(corners[k]) - at(corners[(k + 1) % 3])).norm());
            return longest > 0 ? twice.norm() / longest : 0;
        };
        if (std::min(height(one, {a, d, c}), height(other, {d, b, c})) <= flat) return false;
        if (one.dot(outside) <= 0 || other.dot(outside) <= 0) return false;
        const auto f = mesh_.face(h).idx();
        const auto g = mesh_.face(beyond).idx();
        expected_[f] = expected_[g];
        part_.facet_tags[f] = part_.facet_tags[g];
        CGAL::Euler::flip_edge(h, mesh_);
        return true;
    }

    [[nodiscard]] double length_of(Mesh::Edge_index edge) const {
        const auto h = mesh_.halfedge(edge);
        return (at(mesh_.source(h)) - at(mesh_.target(h))).norm();
    }
    [[nodiscard]] const Point& at(VertexIndex v) const { return part_.mesh.points[v.idx()]; }
    [[nodiscard]] double uncertainty(VertexIndex v) const { return part_.uncertainty[v.idx()]; }

    std::optional<VertexIndex> join(Mesh::Edge_index edge) {
        auto h = mesh_.halfedge(edge);
        const PartTag tag = part_.tags[mesh_.source(h).idx()];
        if (!is_measured(tag) || part_.tags[mesh_.target(h).idx()] != tag || !CGAL::Euler::does_satisfy_link_condition(edge, mesh_)) {
            return std::nullopt;
        }
        // collapse_edge() keeps the target of the edge's own halfedge.
        const VertexIndex kept = mesh_.target(h);
        const VertexIndex gone = mesh_.source(h);
        const bool swaps = uncertainty(gone) < uncertainty(kept);
        const Point place = swaps ? at(gone) : at(kept);
        if (turns_over(kept, gone, place) || turns_over(gone, kept, place)) return std::nullopt;
        if (swaps) {
            part_.mesh.points[kept.idx()] = place;
            part_.normals[kept.idx()] = part_.normals[gone.idx()];
            part_.uncertainty[kept.idx()] = uncertainty(gone);
            mesh_.point(kept) = to_cgal(place);
        }
        return CGAL::Euler::collapse_edge(edge, mesh_);
    }
    // Would a facet of `v` without `other` turn over if `v` came to lie at `place`?
    [[nodiscard]] bool turns_over(VertexIndex v, VertexIndex other, const Point& place) const {
        for (const auto h : CGAL::halfedges_around_target(v, mesh_)) {
            if (mesh_.is_border(h)) continue;
            const VertexIndex a = mesh_.source(h);
            const VertexIndex b = mesh_.target(mesh_.next(h));
            if (a == other || b == other) continue;
            const Vector& expected = expected_[mesh_.face(h).idx()];
            const auto cosine = [&](const Point& p) {
                const Vector normal = (p - at(a)).cross(at(b) - p);
                return normal.dot(expected) / std::max(normal.norm() * expected.norm(), std::numeric_limits<double>::min());
            };
            if (cosine(place) <= std::min(kTurnedOver, cosine(at(v)) - 1e-12)) return true;
        }
        return false;
    }
    void write_back() {
        PartSurface kept;
        std::vector<std::uint32_t> number(part_.mesh.points.size());
        for (const VertexIndex v : mesh_.vertices()) {
            number[v.idx()] = static_cast<std::uint32_t>(kept.mesh.points.size());
            kept.mesh.points.push_back(at(v));
            kept.normals.push_back(part_.normals[v.idx()]);
            kept.uncertainty.push_back(uncertainty(v));
            kept.tags.push_back(part_.tags[v.idx()]);
        }
        for (const auto f : mesh_.faces()) {
            std::array<std::uint32_t, 3> corners{};
            // From the same corner on as before, as far as it is still there.
            auto h = mesh_.halfedge(f);
            for (std::uint32_t& corner : corners) {
                corner = number[mesh_.target(h).idx()];
                h = mesh_.next(h);
            }
            std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
            kept.mesh.triangles.push_back(corners);
            kept.facet_tags.push_back(part_.facet_tags[f.idx()]);
        }
        part_ = std::move(kept);
    }

    PartSurface& part_;
    double length_;
    Mesh mesh_;
    std::vector<Vector> expected_;  // per facet: the sum of the normals at its corners
};

// mm: how far the triangle reaches through the other one's plane; at most what it reaches on either side.
double reach_through(const TriangleMesh& mesh, std::uint32_t facet, std::uint32_t plane) {
    const Vector normal = facet_normal(mesh, plane);
    double above = 0;
    double below = 0;
    for (const std::uint32_t v : mesh.triangles[facet]) {
        const double height = normal.dot(mesh.points[v] - mesh.points[mesh.triangles[plane][0]]);
        above = std::max(above, height);
        below = std::max(below, -height);
    }
    return std::min(above, below);
}

}  // namespace

void join_near_points(PartSurface& part, double length) {
    if (!pmp::is_polygon_soup_a_polygon_mesh(soup_of(part.mesh))) return;
    Joiner(part, length).run();
}

void find_crossings(PartSurface& part) {
    Soup soup = soup_of(part.mesh);
    std::vector<Kernel::Point_3> points = points_of(part.mesh);
    // Where several sheets meet at a point or an edge, each gets its own copy.
    if (!pmp::is_polygon_soup_a_polygon_mesh(soup)) pmp::orient_polygon_soup(points, soup);
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, soup, mesh);
    std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
    pmp::self_intersections(mesh, std::back_inserter(pairs));
    for (const auto& [f, g] : pairs) {
        // What fixtures and shadows do to each other says nothing of the part.
        if (!is_measured(part.facet_tags[f.idx()]) && !is_measured(part.facet_tags[g.idx()])) continue;
        const double depth = std::min(reach_through(part.mesh, f.idx(), g.idx()), reach_through(part.mesh, g.idx(), f.idx()));
        for (const auto facet : {f, g}) {
            part.crossings.push_back(static_cast<std::uint32_t>(facet.idx()));
            for (const std::uint32_t v : part.mesh.triangles[facet.idx()]) {
                if (is_measured(part.tags[v])) part.uncertainty[v] = std::max(part.uncertainty[v], depth);
            }
        }
    }
    std::ranges::sort(part.crossings);
    part.crossings.erase(std::unique(part.crossings.begin(), part.crossings.end()), part.crossings.end());
}

}  // namespace palpate
