#include "sim/internal/mesh_check.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>

namespace palpate {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Triangle = std::array<std::uint32_t, 3>;

std::string counted(std::size_t n, const std::string& one, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

Kernel::Point_3 to_cgal(const Point& p) { return {p.x(), p.y(), p.z()}; }

bool degenerate(const TriangleMesh& mesh, const Triangle& t) {
    return CGAL::collinear(to_cgal(mesh.points[t[0]]), to_cgal(mesh.points[t[1]]), to_cgal(mesh.points[t[2]]));
}

// What meets at an undirected edge (low, high).
struct EdgeUse {
    std::vector<std::size_t> triangles;
    int upward = 0;  // of them, how many run from low to high
};
using Edges = std::map<std::pair<std::uint32_t, std::uint32_t>, EdgeUse>;

Edges edges_of(const std::vector<Triangle>& triangles) {
    Edges edges;
    for (std::size_t f = 0; f < triangles.size(); ++f) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto a = triangles[f][i];
            const auto b = triangles[f][(i + 1) % 3];
            EdgeUse& use = edges[std::minmax(a, b)];
            use.triangles.push_back(f);
            if (a < b) ++use.upward;
        }
    }
    return edges;
}

// A vertex is manifold if its triangles hang together through edges at it: one fan, not two that share only the point.
std::size_t count_nonmanifold_vertices(const TriangleMesh& mesh, const std::vector<Triangle>& triangles, const Edges& edges) {
    std::vector<std::size_t> parent(3 * triangles.size());  // union-find over corners
    for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = i;
    const auto root = [&](std::size_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    const auto corner = [&](std::size_t f, std::uint32_t v) {
        return 3 * f + static_cast<std::size_t>(std::ranges::find(triangles[f], v) - triangles[f].begin());
    };
    for (const auto& [ends, use] : edges) {
        for (std::size_t f : use.triangles) {
            parent[root(corner(f, ends.first))] = root(corner(use.triangles.front(), ends.first));
            parent[root(corner(f, ends.second))] = root(corner(use.triangles.front(), ends.second));
        }
    }
    std::vector<int> fans(mesh.points.size(), 0);
    for (std::size_t i = 0; i < parent.size(); ++i) {
        if (parent[i] == i) ++fans[triangles[i / 3][i % 3]];
    }
    return static_cast<std::size_t>(std::ranges::count_if(fans, [](int n) { return n > 1; }));
}

void append_topology_problems(const TriangleMesh& mesh, const std::vector<Triangle>& triangles, std::vector<std::string>& problems) {
    const Edges edges = edges_of(triangles);
    std::size_t boundary = 0;
    std::size_t crowded = 0;
    std::size_t turned = 0;
    for (const auto& [ends, use] : edges) {
        if (use.triangles.size() == 1) ++boundary;
        if (use.triangles.size() > 2) ++crowded;
        if (use.triangles.size() == 2 && use.upward != 1) ++turned;
    }
    if (boundary > 0) problems.push_back("not closed: " + counted(boundary, "boundary edge", "boundary edges") + " (fill the holes)");
    if (crowded > 0) {
        problems.push_back(counted(crowded, "non-manifold edge", "non-manifold edges") +
                           " with more than two triangles (remove duplicate or inner faces)");
    }
    const std::size_t pinched = count_nonmanifold_vertices(mesh, triangles, edges);
    if (pinched > 0) {
        problems.push_back(counted(pinched, "non-manifold vertex", "non-manifold vertices") +
                           " where parts meet in a point only (move them apart or join them)");
    }
    if (turned > 0) {
        problems.push_back("inconsistent orientation across " + counted(turned, "edge", "edges") +
                           " (make the faces' orientation coherent)");
    }
}

SurfaceMesh to_surface_mesh(const TriangleMesh& mesh) {
    std::vector<Kernel::Point_3> points;
    points.reserve(mesh.points.size());
    for (const Point& p : mesh.points) points.push_back(to_cgal(p));
    std::vector<std::vector<std::size_t>> faces;
    faces.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles) faces.push_back({t[0], t[1], t[2]});
    SurfaceMesh result;
    PMP::polygon_soup_to_polygon_mesh(points, faces, result);
    return result;
}

std::vector<double> component_volumes(const SurfaceMesh& mesh,
                                      const SurfaceMesh::Property_map<SurfaceMesh::Face_index, std::size_t>& component, std::size_t count) {
    std::vector<double> volumes(count, 0.0);
    const auto origin = mesh.point(*mesh.vertices().begin());
    for (const auto f : mesh.faces()) {
        std::array<Vector, 3> corner;
        std::size_t i = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
            const auto p = mesh.point(v) - origin;
            corner.at(i++) = Vector(p.x(), p.y(), p.z());
        }
        volumes[component[f]] += corner[0].cross(corner[1]).dot(corner[2]) / 6.0;
    }
    return volumes;
}

}  // namespace

std::vector<std::string> mesh_problems(const TriangleMesh& mesh) {
    std::vector<std::string> problems;
    std::vector<Triangle> triangles;  // those with three different corners
    std::size_t flat = 0;
    for (const auto& t : mesh.triangles) {
        if (degenerate(mesh, t)) ++flat;
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    if (flat > 0) {
        problems.push_back(counted(flat, "degenerate triangle", "degenerate triangles") + " with corners on one line (remove or collapse)");
    }
    append_topology_problems(mesh, triangles, problems);
    const bool buildable = flat == 0 && PMP::is_polygon_soup_a_polygon_mesh(mesh.triangles);
    if (buildable) {
        const SurfaceMesh surface = to_surface_mesh(mesh);
        std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
        PMP::self_intersections(surface, std::back_inserter(pairs));
        if (!pairs.empty()) {
            problems.push_back("self-intersecting: " + counted(pairs.size(), "pair", "pairs") +
                               " of triangles (unite overlapping parts into one solid)");
        }
    }
    return problems;
}

std::vector<std::string> orient_outward(TriangleMesh& mesh) {
    SurfaceMesh surface = to_surface_mesh(mesh);
    auto component = surface.add_property_map<SurfaceMesh::Face_index, std::size_t>("f:component", 0).first;
    const std::size_t count = PMP::connected_components(surface, component);
    const std::vector<double> before = component_volumes(surface, component, count);
    PMP::orient_to_bound_a_volume(surface);
    const std::vector<double> after = component_volumes(surface, component, count);
    std::size_t turned = 0;
    std::size_t cavities = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if ((before[i] < 0.0) != (after[i] < 0.0)) ++turned;
        if (after[i] < 0.0) ++cavities;
    }
    std::vector<std::string> warnings;
    if (turned > 0) {
        for (auto& t : mesh.triangles) t = {};
        std::size_t f = 0;
        for (const auto face : surface.faces()) {
            std::size_t i = 0;
            for (const auto v : surface.vertices_around_face(surface.halfedge(face))) mesh.triangles[f].at(i++) = v.idx();
            ++f;
        }
        warnings.push_back(count == 1 ? "was inside out; its triangles have been turned"
                                      : std::to_string(turned) + " of " + std::to_string(count) +
                                            " components were inside out; their triangles have been turned");
    }
    if (cavities > 0) {
        warnings.push_back(counted(cavities, "component is a cavity", "components are cavities") +
                           " inside another; no probe can reach it");
    }
    return warnings;
}

}  // namespace palpate
