#include "sim/objects/mesh/internal/triangulation.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <utility>
#include <vector>

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<bool, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;  // is it outside?
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                                                 CGAL::No_constraint_intersection_tag>;
using Polygon = std::vector<std::uint32_t>;

// Twice the area along each axis (Newell).
Vector area_vector(const std::vector<Point>& points, const Polygon& polygon) {
    Vector sum = Vector::Zero();
    const Point& first = points[polygon.front()];
    for (std::size_t i = 2; i < polygon.size(); ++i) sum += (points[polygon[i - 1]] - first).cross(points[polygon[i]] - first);
    return sum;
}

// Along the axis in which the polygon is largest, so that it is counter-clockwise. Coordinates are left out, not computed, so that what is
// simple here is so exactly.
std::vector<Kernel::Point_2> projected(const std::vector<Point>& points, const Polygon& polygon) {
    const Vector area = area_vector(points, polygon);
    Eigen::Index axis = 0;
    area.cwiseAbs().maxCoeff(&axis);
    const Eigen::Index x = (axis + (area[axis] < 0.0 ? 2 : 1)) % 3;
    const Eigen::Index y = 3 - axis - x;
    std::vector<Kernel::Point_2> result;
    for (const std::uint32_t i : polygon) result.emplace_back(points[i][x], points[i][y]);
    return result;
}

void mark_outside(Triangulation& triangulation) {
    for (const auto f : triangulation.all_face_handles()) f->info() = false;
    std::vector<Triangulation::Face_handle> reached{triangulation.infinite_face()};
    reached.front()->info() = true;
    while (!reached.empty()) {
        const auto f = reached.back();
        reached.pop_back();
        for (int i = 0; i < 3; ++i) {
            const auto next = f->neighbor(i);
            if (next->info() || f->is_constrained(i)) continue;
            next->info() = true;
            reached.push_back(next);
        }
    }
}

void append_triangles(const std::vector<Point>& points, const Polygon& polygon, TriangleMesh& out) {
    const std::vector<Kernel::Point_2> flat = projected(points, polygon);
    if (!CGAL::is_simple_2(flat.begin(), flat.end(), Kernel())) {
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            const bool returns = polygon[i] == polygon[0] || polygon[i - 1] == polygon[0];  // along the side that it came
            if (!returns) out.triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
        }
        return;
    }
    Triangulation triangulation;
    std::vector<Triangulation::Vertex_handle> corners;
    for (std::size_t i = 0; i < flat.size(); ++i) {
        corners.push_back(triangulation.insert(flat[i]));
        corners.back()->info() = polygon[i];
    }
    for (std::size_t i = 0; i < corners.size(); ++i) triangulation.insert_constraint(corners[i], corners[(i + 1) % corners.size()]);
    mark_outside(triangulation);
    for (const auto f : triangulation.finite_face_handles()) {
        if (!f->info()) out.triangles.push_back({f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()});
    }
}

}  // namespace

TriangleMesh triangulated(PolygonSoup soup) {
    TriangleMesh mesh;
    for (const Polygon& polygon : soup.polygons) {
        if (polygon.size() == 3) {
            mesh.triangles.push_back({polygon[0], polygon[1], polygon[2]});
        } else if (polygon.size() > 3) {
            append_triangles(soup.points, polygon, mesh);
        }
    }
    mesh.points = std::move(soup.points);
    return mesh;
}

}  // namespace palpate
