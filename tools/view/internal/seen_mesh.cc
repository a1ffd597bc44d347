#include "tools/view/internal/seen_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "tools/view/internal/rasterizer.h"

namespace palpate {

namespace {

constexpr double kCreaseCosine = 0.6;  // sharper dihedral angles than 53° are drawn as edges of the solid

Vector triangle_cross(const TriangleMesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
}

// One unit normal per corner: the mean, weighted by area, over the triangles around the vertex that continue smoothly.
std::vector<std::array<Vector, 3>> corner_normals(const TriangleMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> around(mesh.points.size());
    std::vector<Vector> crosses;
    crosses.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        crosses.push_back(triangle_cross(mesh, t));
        for (const auto v : mesh.triangles[t]) {
            around[v].push_back(static_cast<std::uint32_t>(t));
        }
    }
    std::vector<std::array<Vector, 3>> normals(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vector own = crosses[t].normalized();
        for (std::size_t k = 0; k < 3; ++k) {
            Vector sum = Vector::Zero();
            for (const auto neighbour : around[mesh.triangles[t][k]]) {
                const Vector& other = crosses[neighbour];
                if (own.dot(other) >= kCreaseCosine * other.norm()) sum += other;
            }
            normals[t][k] = sum.squaredNorm() > 0.0 ? sum.normalized() : own;
        }
    }
    return normals;
}

// Its rows give the distances of a place (x, y, 1) from the lines through the edges; NaN for edges without length.
Eigen::Matrix3d edge_lines(const std::array<Screen, 3>& corners) {
    Eigen::Matrix3d lines;
    for (std::size_t k = 0; k < 3; ++k) {
        const Screen& from = corners[k];
        const Screen& to = corners[(k + 1) % 3];
        const Eigen::Vector2d across = Eigen::Vector2d(from.y - to.y, to.x - from.x).normalized();
        lines.row(static_cast<Eigen::Index>(k)) << across.x(), across.y(), -across.x() * from.x - across.y() * from.y;
    }
    return lines;
}

}  // namespace

SeenMesh::SeenMesh(const TriangleMesh& mesh, const Camera& camera) : mesh_(mesh), camera_(camera), normals_(corner_normals(mesh)) {
    std::transform(mesh.points.begin(), mesh.points.end(), std::back_inserter(places_),
                   [&camera](const Point& p) { return camera.project(p); });
    edge_lines_.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) edge_lines_.push_back(edge_lines(corners(t)));
}

std::array<Screen, 3> SeenMesh::corners(std::size_t t) const {
    const auto& [a, b, c] = mesh_.triangles[t];
    return {places_[a], places_[b], places_[c]};
}

SurfacePoint SeenMesh::surface(std::size_t t, double x, double y) const {
    const std::array<Screen, 3> seen = corners(t);
    Vector b = barycentric(seen, x, y).cwiseMax(0.0);
    b = b.cwiseProduct(Vector(camera_.weight(seen[0]), camera_.weight(seen[1]), camera_.weight(seen[2])));
    b /= b.sum();
    SurfacePoint point;
    for (std::size_t k = 0; k < 3; ++k) {
        point.position += b[static_cast<Eigen::Index>(k)] * mesh_.points[mesh_.triangles[t][k]];
        point.normal += b[static_cast<Eigen::Index>(k)] * normals_[t][k];
    }
    point.normal.normalize();
    if (triangle_cross(mesh_, t).dot(camera_.sight(x, y).second) > 0.0) {
        point.normal = -point.normal;
    }
    return point;
}

double SeenMesh::edge_distance(std::size_t t, double x, double y) const {
    return (edge_lines_[t] * Vector(x, y, 1.0)).cwiseAbs().minCoeff();
}

double SeenMesh::nearness(std::size_t t) const {
    const std::array<Screen, 3> seen = corners(t);
    return (seen[0].nearness + seen[1].nearness + seen[2].nearness) / 3.0;
}

double median_edge(const TriangleMesh& mesh) {
    std::vector<double> lengths;
    for (const auto& [a, b, c] : mesh.triangles) {
        for (const double length : {(mesh.points[a] - mesh.points[b]).norm(), (mesh.points[b] - mesh.points[c]).norm(),
                                    (mesh.points[c] - mesh.points[a]).norm()}) {
            lengths.push_back(length);
        }
    }
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
}

}  // namespace palpate
