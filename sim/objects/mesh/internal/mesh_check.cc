#include "sim/objects/mesh/internal/mesh_check.h"

#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "planner/number_text.h"
#include "planner/union_find.h"
#include "sim/objects/mesh/internal/face_edges.h"
#include "sim/objects/mesh/internal/flat_triangles.h"
#include "sim/objects/mesh/internal/message_text.h"
#include "sim/objects/mesh/internal/surface_mesh.h"

namespace palpate {
namespace {

using Edges = std::vector<FaceEdge>;

// Open edges that hang together through their ends.
struct Hole {
    double length = 0.0;
    std::size_t edges = 0;
    Point place = Point::Zero();  // on its boundary
};

std::vector<Hole> holes_of(const TriangleMesh& mesh, const Edges& open) {
    UnionFind hangs_together(mesh.points.size());
    for (const FaceEdge& edge : open) hangs_together.join(edge.low, edge.high);
    std::map<std::size_t, Hole> holes;
    for (const FaceEdge& edge : open) {
        Hole& hole = holes[hangs_together.root(edge.low)];
        hole.length += (mesh.points[edge.high] - mesh.points[edge.low]).norm();
        if (hole.edges++ == 0) hole.place = mesh.points[edge.low];
    }
    std::vector<Hole> result;
    for (const auto& [root, hole] : holes) result.push_back(hole);
    return result;
}

void append_holes(const TriangleMesh& mesh, const Edges& edges, double scale, const Pose& pose, std::vector<std::string>& problems) {
    const Edges open = open_edges(edges);
    if (open.empty()) return;
    const std::vector<Hole> holes = holes_of(mesh, open);
    const Hole& largest = *std::ranges::max_element(holes, {}, &Hole::length);
    const std::string boundary = holes.size() == 1 ? "its boundary" : "the boundary of the largest";
    problems.push_back(fmt::format("not closed: {} around {}; {} is {} mm long and passes through {} (fill the holes)",
                                   counted(open.size(), "boundary edge", "boundary edges"), counted(holes.size(), "hole", "holes"),
                                   boundary, rounded_text(scale * largest.length), point_text(pose.to_world(scale * largest.place))));
}

// A vertex is manifold if its triangles hang together through edges at it: one fan, not two that share only the point.
std::size_t count_nonmanifold_vertices(const TriangleMesh& mesh, const Edges& edges) {
    UnionFind corners(3 * mesh.triangles.size());
    const auto corner = [&](std::uint32_t f, std::uint32_t v) {
        return 3 * f + static_cast<std::size_t>(std::ranges::find(mesh.triangles[f], v) - mesh.triangles[f].begin());
    };
    for_each_edge(edges, [&](std::span<const FaceEdge> sides) {
        for (const FaceEdge& side : sides) {
            for (const std::uint32_t end : {side.low, side.high}) corners.join(corner(side.face, end), corner(sides[0].face, end));
        }
    });
    std::vector<int> fans(mesh.points.size(), 0);
    for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i) {
        if (corners.root(i) == i) ++fans[mesh.triangles[i / 3].at(i % 3)];
    }
    return static_cast<std::size_t>(std::ranges::count_if(fans, [](int n) { return n > 1; }));
}

}  // namespace

std::vector<std::string> topology_problems(const TriangleMesh& mesh, double scale, const Pose& pose) {
    std::vector<std::string> problems;
    const Edges edges = face_edges(mesh.triangles);
    append_holes(mesh, edges, scale, pose, problems);
    std::size_t crowded = 0;
    std::size_t turned = 0;
    for_each_edge(edges, [&](std::span<const FaceEdge> sides) {
        if (sides.size() > 2) ++crowded;
        if (sides.size() == 2 && sides[0].upward == sides[1].upward) ++turned;
    });
    if (crowded > 0) {
        problems.push_back(fmt::format("{} with more than two triangles (remove inner faces, or move the parts that meet there apart)",
                                       counted(crowded, "non-manifold edge", "non-manifold edges")));
    }
    if (const std::size_t pinched = count_nonmanifold_vertices(mesh, edges); pinched > 0) {
        problems.push_back(fmt::format("{} where parts meet in a point only (move them apart or join them)",
                                       counted(pinched, "non-manifold vertex", "non-manifold vertices")));
    }
    if (turned > 0) {
        problems.push_back(
            fmt::format("one-sided: no orientation agrees across {} (it bounds no solid)", counted(turned, "edge", "edges")));
    }
    return problems;
}

std::vector<std::string> geometry_problems(const TriangleMesh& mesh) {
    constexpr unsigned kMostPairs = 1000;
    if (const std::size_t flat = count_flat_triangles(mesh); flat > 0) {
        return {fmt::format(
            "{}, whose corners rounding has put on one line (the mesh is too small for its distance from the origin, or for a number)",
            counted(flat, "degenerate triangle", "degenerate triangles"))};
    }
    const SurfaceMesh surface = to_surface_mesh(mesh);
    std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
    CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(pairs), CGAL::parameters::maximum_number(kMostPairs + 1));
    if (pairs.empty()) return {};
    const std::string count =
        pairs.size() > kMostPairs ? fmt::format("more than {} pairs", kMostPairs) : counted(pairs.size(), "pair", "pairs");
    return {fmt::format("self-intersecting: {} of triangles (unite overlapping parts into one solid)", count)};
}

}  // namespace palpate
