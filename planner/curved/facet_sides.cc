#include "planner/curved/internal/facet_sides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "planner/union_find.h"

namespace palpate {
namespace {

Vector unit_normal(const TriangleMesh& mesh, std::uint32_t facet) {
    const auto& [a, b, c] = mesh.triangles[facet];
    const Vector twice = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
    const double norm = twice.norm();
    return norm > 0 ? Vector(twice / norm) : Vector::Zero();
}

double angle_at(const Point& p, const Point& a, const Point& b) { return std::atan2((a - p).cross(b - p).norm(), (a - p).dot(b - p)); }

}  // namespace

FacetSides::FacetSides(const TriangleMesh& mesh, const std::vector<std::uint8_t>& flat, double crease)
    : mesh_(&mesh), flat_(flat), edge_of_(3 * mesh.triangles.size()), side_of_(3 * mesh.triangles.size()) {
    flat_.resize(mesh.triangles.size(), 0);
    normals_.reserve(mesh.triangles.size());
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) normals_.push_back(unit_normal(mesh, f));
    find_edges(crease);
    find_sides();
}

void FacetSides::find_edges(double crease) {
    struct HalfEdge {
        std::uint32_t low, high, facet;
        std::uint8_t corner;
    };
    std::vector<HalfEdge> all;
    all.reserve(edge_of_.size());
    for (std::uint32_t f = 0; f < mesh_->triangles.size(); ++f) {
        for (std::uint8_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh_->triangles[f][k];
            const std::uint32_t b = mesh_->triangles[f][(k + 1) % 3];
            all.push_back({std::min(a, b), std::max(a, b), f, k});
        }
    }
    std::ranges::sort(all, {}, [](const HalfEdge& e) { return std::tuple(e.low, e.high, e.facet, e.corner); });
    for (const HalfEdge& e : all) {
        if (edges_.empty() || edges_.back().points != std::array{e.low, e.high}) edges_.push_back({.points = {e.low, e.high}});
        MeshEdge& edge = edges_.back();
        if (edge.count < 2) {
            const auto next = static_cast<std::uint8_t>((e.corner + 1) % 3);
            const bool is_forward = mesh_->triangles[e.facet][e.corner] == e.low;
            edge.facets[edge.count] = e.facet;
            edge.corners[edge.count] = is_forward ? std::array{e.corner, next} : std::array{next, e.corner};
        }
        ++edge.count;
        edge_of_[3 * e.facet + e.corner] = static_cast<std::uint32_t>(edges_.size() - 1);
    }
    const double cosine = std::cos(crease);
    for (MeshEdge& edge : edges_) {
        if (edge.count != 2) continue;
        const auto [f, g] = edge.facets;
        // A facet without area has no normal that could say otherwise.
        const bool turns = normals_[f].dot(normals_[g]) <= cosine && !normals_[f].isZero() && !normals_[g].isZero();
        edge.is_smooth = f != g && !turns && flat_[f] == flat_[g];
    }
}

void FacetSides::find_sides() {
    UnionFind corners(side_of_.size());
    for (const MeshEdge& edge : edges_) {
        if (!edge.is_smooth) continue;
        for (std::size_t end = 0; end < 2; ++end) {
            corners.join(3 * edge.facets[0] + edge.corners[0].at(end), 3 * edge.facets[1] + edge.corners[1].at(end));
        }
    }
    // Numbered by their first facets.
    constexpr std::uint32_t kNone = kNoFacet;
    std::vector<std::uint32_t> number(side_of_.size(), kNone);
    for (std::uint32_t c = 0; c < side_of_.size(); ++c) {
        std::uint32_t& side = number[corners.root(c)];
        if (side == kNone) {
            side = static_cast<std::uint32_t>(sides_.size());
            sides_.push_back({.point = mesh_->triangles[c / 3][c % 3]});
        }
        side_of_[c] = side;
        ++sides_[side].count;
    }
    std::uint32_t first = 0;
    for (Side& side : sides_) {
        side.first = first;
        first += std::exchange(side.count, 0U);
    }
    facets_.resize(first);
    sides_at_.assign(mesh_->points.size(), 0);
    for (const Side& side : sides_) ++sides_at_[side.point];
    for (std::uint32_t c = 0; c < side_of_.size(); ++c) {
        Side& side = sides_[side_of_[c]];
        const std::uint32_t f = c / 3;
        facets_[side.first + side.count++] = f;
        const Point& p = mesh_->points[side.point];
        const Point& a = mesh_->points[mesh_->triangles[f][(c + 1) % 3]];
        const Point& b = mesh_->points[mesh_->triangles[f][(c + 2) % 3]];
        side.normal += angle_at(p, a, b) * normals_[f];
        side.spacing += (a - p).norm() + (b - p).norm();
    }
    for (Side& side : sides_) {
        side.spacing /= 2 * side.count;
        const double norm = side.normal.norm();
        side.normal = norm > 1e-9 ? Vector(side.normal / norm) : Vector::Zero();
    }
    // A crease that is one edge long, around whose ends the facets go on into each other, is none.
    for (MeshEdge& edge : edges_) {
        if (edge.count != 2 || edge.is_smooth || edge.facets[0] == edge.facets[1]) continue;
        edge.is_smooth = true;
        for (std::size_t end = 0; end < 2; ++end) {
            edge.is_smooth &= side(edge.facets[0], edge.corners[0].at(end)) == side(edge.facets[1], edge.corners[1].at(end));
        }
    }
}

std::vector<std::uint32_t> FacetSides::rings(std::uint32_t side, int depth, std::size_t most) const {
    std::vector<std::uint32_t> found{side};
    std::vector<std::uint32_t> points{sides_[side].point};
    std::size_t begin = 0;
    for (int ring = 0; ring < depth && found.size() < most; ++ring) {
        const std::size_t end = found.size();
        for (; begin < end; ++begin) {
            for (const std::uint32_t f : facets(sides_[found[begin]])) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t other = side_of_[3 * std::size_t{f} + k];
                    if (std::ranges::find(points, sides_[other].point) != points.end()) continue;
                    points.push_back(sides_[other].point);
                    found.push_back(other);
                }
            }
        }
        if (found.size() <= most) continue;
        // Of the last ring those that are nearest.
        const Point& centre = mesh_->points[sides_[side].point];
        const auto nearer = [&](std::uint32_t s, std::uint32_t t) {
            const auto key = [&](std::uint32_t i) { return std::pair((mesh_->points[sides_[i].point] - centre).squaredNorm(), i); };
            return key(s) < key(t);
        };
        std::sort(found.begin() + static_cast<std::ptrdiff_t>(std::min(end, most)), found.end(), nearer);
        found.resize(most);
    }
    return found;
}

}  // namespace palpate
