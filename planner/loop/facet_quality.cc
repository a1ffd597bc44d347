#include "planner/loop/facet_quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace palpate {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

using Triangle = std::array<std::uint32_t, 3>;

// By triangle: its neighbours.
std::vector<Triangle> find_neighbors(const TriangleMesh& mesh) {
    std::vector<Triangle> neighbors(mesh.triangles.size(), Triangle{kNone, kNone, kNone});
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<std::uint32_t, std::size_t>> waiting;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto edge = std::minmax(mesh.triangles[t].at(k), mesh.triangles[t].at((k + 1) % 3));
            const auto [other, is_new] = waiting.try_emplace(edge, t, k);
            if (is_new) continue;
            const auto [u, j] = other->second;
            neighbors[t].at(k) = u;
            neighbors[u].at(j) = t;
        }
    }
    return neighbors;
}

struct Plane {
    Point centroid = Point::Zero();
    Vector normal = Vector::Zero();
};

Plane plane_of(const TriangleMesh& mesh, const Triangle& corners) {
    const Point& a = mesh.points[corners[0]];
    const Point& b = mesh.points[corners[1]];
    const Point& c = mesh.points[corners[2]];
    return {(a + b + c) / 3, (b - a).cross(c - a).normalized()};
}

// By how much the normal turns on the way.
double radius_of_curvature(const Plane& p, const Plane& q) {
    const double angle = std::atan2(p.normal.cross(q.normal).norm(), p.normal.dot(q.normal));
    return angle > 0 ? (q.centroid - p.centroid).norm() / angle : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<BadFacet> find_bad_facets(const MaintainedDelaunay& state, const RestrictedSurface& surface, const Criteria& criteria,
                                      const std::vector<bool>& is_seed) {
    const TriangleMesh& mesh = surface.mesh;
    const std::vector<Triangle> neighbors = find_neighbors(mesh);
    std::vector<BadFacet> bad;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& corners = mesh.triangles[t];
        const Point& a = mesh.points[corners[0]];
        const Point& b = mesh.points[corners[1]];
        const Point& c = mesh.points[corners[2]];
        const Point centre = state.crossing(surface.dual_edges[t]).near;
        const double radius = surface.ball_radii[t];
        const bool at_seed = std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return is_seed[surface.sample_of[v]]; });
        double bend = std::numeric_limits<double>::infinity();
        for (const std::uint32_t u : neighbors[t]) {
            if (u != kNone) bend = std::min(bend, radius_of_curvature(plane_of(mesh, corners), plane_of(mesh, mesh.triangles[u])));
        }
        if (criteria.is_bad(radius, centre)) {
            bad.push_back({t, criteria.spacing(centre)});
        } else if (!at_seed && (criteria.is_too_flat(radius, bend) || criteria.is_skinny(a, b, c))) {
            bad.push_back({t, criteria.least_spacing()});
        }
    }
    return bad;
}

}  // namespace palpate
