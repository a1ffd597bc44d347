#include "sim/objects/mesh/internal/orientation.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/objects/mesh/internal/face_edges.h"
#include "sim/objects/mesh/internal/surface_mesh.h"

namespace palpate {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

struct Neighbour {
    std::uint32_t face = 0;
    bool agrees = false;  // do both run along their edge in opposite directions?
};
using Neighbours = std::vector<std::vector<Neighbour>>;  // of each triangle

Neighbours neighbours_of(const TriangleMesh& mesh) {
    Neighbours neighbours(mesh.triangles.size());
    for_each_edge(face_edges(mesh.triangles), [&](std::span<const FaceEdge> sides) {
        if (sides.size() != 2) return;
        const bool agree = sides[0].upward != sides[1].upward;
        neighbours[sides[0].face].push_back({sides[1].face, agree});
        neighbours[sides[1].face].push_back({sides[0].face, agree});
    });
    return neighbours;
}

enum class Side : std::uint8_t { unknown, kept, turned };

// All that hang together with `first`, each after one that it touches. Says in `sides` which of them to turn for all to agree with
// it; or nothing is returned, and none is turned, if that is impossible.
std::vector<std::uint32_t> spread(const Neighbours& neighbours, std::uint32_t first, std::vector<Side>& sides) {
    std::vector<std::uint32_t> reached{first};
    sides[first] = Side::kept;
    bool one_sided = false;
    for (std::size_t i = 0; i < reached.size(); ++i) {
        const std::uint32_t f = reached[i];
        for (const Neighbour& next : neighbours[f]) {
            const Side side = (sides[f] == Side::kept) == next.agrees ? Side::kept : Side::turned;
            if (sides[next.face] == Side::unknown) {
                sides[next.face] = side;
                reached.push_back(next.face);
            } else if (sides[next.face] != side) {
                one_sided = true;
            }
        }
    }
    if (!one_sided) return reached;
    for (const std::uint32_t f : reached) sides[f] = Side::kept;
    return {};
}

using FaceComponents = SurfaceMesh::Property_map<SurfaceMesh::Face_index, std::size_t>;

// Each about a corner of its own: about a common point, rounding would drown what is small.
std::vector<double> component_volumes(const SurfaceMesh& mesh, const FaceComponents& component, std::size_t count) {
    std::vector<double> volumes(count, 0.0);
    std::vector<std::optional<SurfaceMesh::Point>> origins(count);
    for (const auto f : mesh.faces()) {
        auto& origin = origins[component[f]];
        std::array<Vector, 3> corner;
        std::size_t i = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
            if (!origin) origin = mesh.point(v);
            const auto p = mesh.point(v) - *origin;
            corner.at(i++) = Vector(p.x(), p.y(), p.z());
        }
        volumes[component[f]] += corner[0].cross(corner[1]).dot(corner[2]) / 6.0;
    }
    return volumes;
}

}  // namespace

std::size_t orient_coherently(TriangleMesh& mesh) {
    const Neighbours neighbours = neighbours_of(mesh);
    std::vector<Side> sides(mesh.triangles.size(), Side::unknown);
    std::size_t count = 0;
    for (std::uint32_t first = 0; first < sides.size(); ++first) {
        if (sides[first] != Side::unknown) continue;
        const std::vector<std::uint32_t> component = spread(neighbours, first, sides);
        const auto turned =
            static_cast<std::size_t>(std::ranges::count_if(component, [&](std::uint32_t f) { return sides[f] == Side::turned; }));
        const Side fewer = 2 * turned <= component.size() ? Side::turned : Side::kept;
        for (const std::uint32_t f : component) {
            if (sides[f] != fewer) continue;
            std::swap(mesh.triangles[f][1], mesh.triangles[f][2]);
            ++count;
        }
    }
    return count;
}

Components orient_outward(TriangleMesh& mesh) {
    SurfaceMesh surface = to_surface_mesh(mesh);
    auto component = surface.add_property_map<SurfaceMesh::Face_index, std::size_t>("f:component", 0).first;
    Components result;
    result.count = PMP::connected_components(surface, component);
    const std::vector<double> before = component_volumes(surface, component, result.count);
    PMP::orient_to_bound_a_volume(surface);
    const std::vector<double> after = component_volumes(surface, component, result.count);
    std::vector<bool> turned(result.count, false);
    for (std::size_t i = 0; i < result.count; ++i) {
        turned[i] = (before[i] < 0.0) != (after[i] < 0.0);
        if (turned[i]) ++result.inside_out;
        if (after[i] < 0.0) ++result.cavities;
    }
    for (const auto f : surface.faces()) {
        if (turned[component[f]]) std::swap(mesh.triangles[f.idx()][1], mesh.triangles[f.idx()][2]);
    }
    return result;
}

}  // namespace palpate
