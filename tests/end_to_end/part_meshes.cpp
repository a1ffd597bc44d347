#include "tests/end_to_end/part_meshes.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <map>
#include <utility>

namespace palpate {

Polygon regular(int corners, double radius, double turned, double x, double y) {
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
        const double angle = turned + kTwoPi * k / corners;
        polygon.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
    }
    return polygon;
}

TriangleMesh extruded(const std::vector<Polygon>& polygons, double height) {
    using K = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Vb = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, K>;
    using Cdt = CGAL::Constrained_Delaunay_triangulation_2<
        K, CGAL::Triangulation_data_structure_2<Vb, CGAL::Constrained_triangulation_face_base_2<K>>>;
    Cdt cdt;
    TriangleMesh mesh;
    std::uint32_t below = 0;
    for (const Polygon& polygon : polygons) below += static_cast<std::uint32_t>(polygon.size());
    std::vector<Cdt::Vertex_handle> vertices;
    for (const Polygon& polygon : polygons) {
        for (const auto& [x, y] : polygon) {
            vertices.push_back(cdt.insert({x, y}));
            vertices.back()->info() = static_cast<std::uint32_t>(vertices.size() - 1);
        }
    }
    for (const double z : {-height / 2, height / 2}) {
        for (const Polygon& polygon : polygons) {
            for (const auto& [x, y] : polygon) mesh.points.emplace_back(x, y, z);
        }
    }
    std::uint32_t first = 0;
    for (const Polygon& polygon : polygons) {
        const auto n = static_cast<std::uint32_t>(polygon.size());
        double doubled_area = 0;
        for (std::uint32_t k = 0; k < n; ++k) {
            const auto& p = polygon[k];
            const auto& q = polygon[(k + 1) % n];
            doubled_area += p[0] * q[1] - p[1] * q[0];
        }
        const bool flip = (doubled_area > 0) != (first == 0);  // holes run clockwise
        for (std::uint32_t k = 0; k < n; ++k) {
            std::uint32_t a = first + k;
            std::uint32_t b = first + (k + 1) % n;
            cdt.insert_constraint(vertices[a], vertices[b]);
            if (flip) std::swap(a, b);
            mesh.triangles.push_back({a, b, b + below});
            mesh.triangles.push_back({a, b + below, a + below});
        }
        first += n;
    }
    // Faces are inside by the parity of constraints between them and the infinite face.
    std::map<Cdt::Face_handle, bool> inside;
    std::vector<std::pair<Cdt::Face_handle, bool>> open{{cdt.infinite_face(), false}};
    while (!open.empty()) {
        const auto [face, is_inside] = open.back();
        open.pop_back();
        if (!inside.emplace(face, is_inside).second) continue;
        for (int k = 0; k < 3; ++k) open.emplace_back(face->neighbor(k), is_inside != face->is_constrained(k));
    }
    for (const auto face : cdt.finite_face_handles()) {
        if (!inside.at(face)) continue;
        const std::uint32_t a = face->vertex(0)->info();
        const std::uint32_t b = face->vertex(1)->info();
        const std::uint32_t c = face->vertex(2)->info();
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({a + below, b + below, c + below});
    }
    return mesh;
}

TriangleMesh cone(int corners, double radius, double height) {
    TriangleMesh mesh;
    const Polygon base = regular(corners, radius);
    for (const auto& [x, y] : base) mesh.points.emplace_back(x, y, -height / 2);
    mesh.points.emplace_back(0, 0, height / 2);
    mesh.points.emplace_back(0, 0, -height / 2);
    const auto n = static_cast<std::uint32_t>(corners);
    for (std::uint32_t k = 0; k < n; ++k) {
        mesh.triangles.push_back({k, (k + 1) % n, n});
        mesh.triangles.push_back({(k + 1) % n, k, n + 1});
    }
    return mesh;
}

TriangleMesh box(const Vector& size) {
    const double x = size.x() / 2;
    const double y = size.y() / 2;
    return extruded({{{-x, -y}, {x, -y}, {x, y}, {-x, y}}}, size.z());
}

void append(TriangleMesh& mesh, const TriangleMesh& other, const Vector& by) {
    const auto offset = static_cast<std::uint32_t>(mesh.points.size());
    for (const Point& p : other.points) mesh.points.emplace_back(p + by);
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + offset, b + offset, c + offset});
}

TriangleMesh of_cells(const std::array<std::vector<double>, 3>& planes, const std::set<std::array<int, 3>>& cells) {
    TriangleMesh mesh;
    std::map<std::array<int, 3>, std::uint32_t> points;
    const auto point = [&](const std::array<int, 3>& at) {
        const auto [found, is_new] = points.try_emplace(at, static_cast<std::uint32_t>(mesh.points.size()));
        if (is_new) {
            Point p;
            for (int k = 0; k < 3; ++k)
                p[k] = planes.at(static_cast<std::size_t>(k)).at(static_cast<std::size_t>(at.at(static_cast<std::size_t>(k))));
            mesh.points.push_back(p);
        }
        return found->second;
    };
    for (const auto& cell : cells) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const int side : {0, 1}) {
                std::array<int, 3> beyond = cell;
                beyond.at(axis) += 2 * side - 1;
                if (cells.contains(beyond)) continue;
                const std::size_t u = (axis + 1) % 3;
                const std::size_t v = (axis + 2) % 3;
                const auto corner = [&](int du, int dv) {
                    std::array<int, 3> at = cell;
                    at.at(axis) += side;
                    at.at(u) += du;
                    at.at(v) += dv;
                    return point(at);
                };
                const std::array<std::uint32_t, 4> q{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
                if (side == 1) {
                    mesh.triangles.push_back({q[0], q[1], q[2]});
                    mesh.triangles.push_back({q[0], q[2], q[3]});
                } else {
                    mesh.triangles.push_back({q[0], q[2], q[1]});
                    mesh.triangles.push_back({q[0], q[3], q[2]});
                }
            }
        }
    }
    return mesh;
}

TriangleMesh cut_cube(double side) {
    std::set<std::array<int, 3>> cells;
    for (int k = 0; k < 7; ++k) cells.insert({k % 2, k / 2 % 2, k / 4});
    const std::vector<double> planes{0, side / 2, side};
    return of_cells({planes, planes, planes}, cells);
}

TriangleMesh tube_along(const std::vector<Point>& centres, double radius, int corners, bool is_closed) {
    TriangleMesh mesh;
    const std::size_t n = centres.size();
    const auto m = static_cast<std::uint32_t>(corners);
    // The frame goes along without turning about the tube.
    Vector side = Vector::Zero();
    for (std::size_t i = 0; i < n; ++i) {
        const Point& before = is_closed ? centres[(i + n - 1) % n] : centres[i == 0 ? 0 : i - 1];
        const Point& after = is_closed ? centres[(i + 1) % n] : centres[i + 1 == n ? i : i + 1];
        const Vector along = (after - before).normalized();
        if (i == 0) side = along.unitOrthogonal();
        side = (side - side.dot(along) * along).normalized();
        const Vector other = along.cross(side);
        for (std::uint32_t k = 0; k < m; ++k) {
            const double angle = kTwoPi * k / m;
            mesh.points.emplace_back(centres[i] + radius * (std::cos(angle) * side + std::sin(angle) * other));
        }
    }
    // Where it meets its own beginning, the ring that fits best.
    std::uint32_t turn = 0;
    const auto last = static_cast<std::uint32_t>(n - 1) * m;
    for (std::uint32_t k = 1; k < m; ++k) {
        if ((mesh.points[k] - mesh.points[last]).norm() < (mesh.points[turn] - mesh.points[last]).norm()) turn = k;
    }
    for (std::size_t i = 0; i + (is_closed ? 0 : 1) < n; ++i) {
        const auto ring = static_cast<std::uint32_t>(i) * m;
        const std::uint32_t next = i + 1 < n ? ring + m : 0;
        const std::uint32_t by = i + 1 < n ? 0 : turn;
        for (std::uint32_t k = 0; k < m; ++k) {
            const std::uint32_t a = ring + k;
            const std::uint32_t b = ring + (k + 1) % m;
            const std::uint32_t c = next + (k + by) % m;
            const std::uint32_t d = next + (k + 1 + by) % m;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    }
    if (is_closed) return mesh;
    const auto first_centre = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(centres.front());
    mesh.points.push_back(centres.back());
    for (std::uint32_t k = 0; k < m; ++k) {
        mesh.triangles.push_back({first_centre, (k + 1) % m, k});
        mesh.triangles.push_back({first_centre + 1, last + k, last + (k + 1) % m});
    }
    return mesh;
}

}  // namespace palpate
