#include "planner/open_area.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace palpate {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // from, to

// The directed edges that no facet runs through the other way, in order.
std::vector<Edge> boundary_of(const TriangleMesh& mesh) {
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        for (const Edge& edge : {Edge{a, b}, Edge{b, c}, Edge{c, a}}) edges.push_back(edge);
    }
    std::ranges::sort(edges);
    std::vector<Edge> boundary;
    std::ranges::copy_if(edges, std::back_inserter(boundary), [&](const Edge& edge) {
        return !std::ranges::binary_search(edges, Edge{edge.second, edge.first});
    });
    return boundary;
}

// Of what spans a loop of points of the mesh.
double area_within(const TriangleMesh& mesh, std::span<const std::uint32_t> loop) {
    Point centre = Point::Zero();
    for (const std::uint32_t v : loop) centre += mesh.points[v];
    centre /= static_cast<double>(loop.size());
    Vector vector_area = Vector::Zero();
    double fan = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vector twice = (mesh.points[loop[k]] - centre).cross(mesh.points[loop[(k + 1) % loop.size()]] - centre);
        vector_area += twice / 2;
        fan += twice.norm() / 2;
    }
    return (vector_area.norm() + fan) / 2;
}

}  // namespace

OpenArea measure_open_area(const TriangleMesh& mesh, double epsilon) {
    OpenArea area;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vector u = mesh.points[b] - mesh.points[a];
        const Vector v = mesh.points[c] - mesh.points[a];
        const double twice = u.cross(v).norm();
        const bool stays = u.norm() * v.norm() * (u - v).norm() <= 2 * epsilon * twice;
        area.facets += stays;
        (stays ? area.covered : area.open) += twice / 2;
    }
    const std::vector<Edge> boundary = boundary_of(mesh);
    std::vector<bool> is_used(boundary.size());
    // The next edge from there that is not used yet, if there is one.
    const auto next_from = [&](std::uint32_t v) {
        auto found = static_cast<std::size_t>(std::ranges::lower_bound(boundary, Edge{v, 0}) - boundary.begin());
        while (found < boundary.size() && boundary[found].first == v && is_used[found]) ++found;
        return found < boundary.size() && boundary[found].first == v ? found : boundary.size();
    };
    constexpr auto kNowhere = static_cast<std::size_t>(-1);
    std::vector<std::size_t> place(mesh.points.size(), kNowhere);  // of a vertex on the path
    std::vector<std::uint32_t> path;
    for (const Edge& first : boundary) {
        // A path that comes to a vertex again has closed a loop, which is cut off.
        for (std::uint32_t at = first.first;;) {
            if (place[at] != kNowhere) {
                const std::span<const std::uint32_t> loop = std::span(path).subspan(place[at]);
                area.open += area_within(mesh, loop);
                for (const std::uint32_t v : loop) place[v] = kNowhere;
                path.resize(path.size() - loop.size());
            }
            const std::size_t edge = next_from(at);
            if (edge == boundary.size()) break;
            is_used[edge] = true;
            place[at] = path.size();
            path.push_back(at);
            at = boundary[edge].second;
        }
        for (const std::uint32_t v : path) place[v] = kNowhere;
        path.clear();
    }
    return area;
}

}  // namespace palpate
