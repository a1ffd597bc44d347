#include "planner/part/internal/facet_fans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate {

Vector facet_normal(const TriangleMesh& mesh, std::uint32_t facet) {
    const auto& [a, b, c] = mesh.triangles[facet];
    const Vector twice = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
    const double norm = twice.norm();
    return norm > 0 ? Vector(twice / norm) : Vector::Zero();
}

double angle_between(const Vector& u, const Vector& v) { return std::atan2(u.cross(v).norm(), u.dot(v)); }

FacetFans::FacetFans(const TriangleMesh& mesh) : mesh_(&mesh), first_(mesh.points.size() + 1, 0), facets_(3 * mesh.triangles.size()) {
    for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t v : triangle) ++first_[v + 1];
    }
    for (std::size_t v = 0; v < mesh.points.size(); ++v) first_[v + 1] += first_[v];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
        for (const std::uint32_t v : mesh.triangles[f]) facets_[next[v]++] = f;
    }
}

std::vector<std::uint32_t> FacetFans::two_rings(std::uint32_t point) const {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t f : around(point)) {
        for (const std::uint32_t v : mesh_->triangles[f]) {
            for (const std::uint32_t g : around(v)) found.insert(found.end(), mesh_->triangles[g].begin(), mesh_->triangles[g].end());
        }
    }
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    std::erase(found, point);
    return found;
}

}  // namespace palpate
