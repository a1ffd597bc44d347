// A triangle mesh as CGAL's, with the same numbers of points and faces.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "planner/geometry.h"

namespace palpate {

using SurfaceMesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;

// Of a mesh that is manifold and coherently oriented.
[[nodiscard]] inline SurfaceMesh to_surface_mesh(const TriangleMesh& mesh) {
    SurfaceMesh result;
    for (const Point& p : mesh.points) result.add_vertex({p.x(), p.y(), p.z()});
    using Index = SurfaceMesh::Vertex_index;
    for (const auto& [a, b, c] : mesh.triangles) result.add_face(Index(a), Index(b), Index(c));
    return result;
}

}  // namespace palpate
