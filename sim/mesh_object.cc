#include "sim/mesh_object.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <Eigen/Geometry>
#include <numeric>

#include "sim/errors.h"
#include "sim/internal/mesh_check.h"
#include "sim/internal/mesh_reader.h"
#include "sim/internal/triangle_tree.h"

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

SurfaceMesh to_surface_mesh(const TriangleMesh& mesh) {
    SurfaceMesh result;
    for (const Point& p : mesh.points) result.add_vertex({p.x(), p.y(), p.z()});
    using Index = SurfaceMesh::Vertex_index;
    for (const auto& [a, b, c] : mesh.triangles) result.add_face(Index(a), Index(b), Index(c));
    return result;
}

TriangleMesh checked_mesh(const MeshSpec& spec) {
    TriangleMesh mesh = read_mesh(spec);
    const std::vector<std::string> problems = mesh_problems(mesh);
    if (problems.empty()) return mesh;
    std::string message = spec.file.string() + ": not the surface of a solid: ";
    for (std::size_t i = 0; i < problems.size(); ++i) message.append(i > 0 ? "; " : "").append(problems[i]);
    throw ObjectError(message);
}

Bounds bounds_of(const std::vector<Point>& points) {
    Bounds box{points.front(), points.front()};
    for (const Point& p : points) box = {box.min.cwiseMin(p), box.max.cwiseMax(p)};
    return box;
}

double area_of(const TriangleMesh& mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += 0.5 * (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm();
    }
    return sum;
}

int count_components(const TriangleMesh& mesh) {
    std::vector<std::size_t> parent(mesh.points.size());  // union-find over points
    std::iota(parent.begin(), parent.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    auto count = static_cast<int>(parent.size());
    const auto join = [&](std::size_t i, std::size_t j) {
        if (root(i) == root(j)) return;
        parent[root(i)] = root(j);
        --count;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
        join(a, b);
        join(b, c);
    }
    return count;
}

}  // namespace

struct MeshObject::Impl {
    explicit Impl(const MeshSpec& spec)
        : mesh(checked_mesh(spec)),
          warnings(orient_outward(mesh)),
          surface(to_surface_mesh(mesh)),
          side(surface),
          tree(mesh),
          bounds(bounds_of(mesh.points)),
          area(area_of(mesh)),
          // V - E + F of a closed triangle mesh, where E = 3F/2.
          euler_characteristic(static_cast<int>(mesh.points.size()) - static_cast<int>(mesh.triangles.size()) / 2),
          components(count_components(mesh)) {
        for (std::string& warning : warnings) warning.insert(0, spec.file.string() + ": ");
        side(surface.point(SurfaceMesh::Vertex_index(0)));  // builds its tree now
    }

    TriangleMesh mesh;
    std::vector<std::string> warnings;
    SurfaceMesh surface;
    CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel> side;  // refers to surface
    TriangleTree tree;
    Bounds bounds;
    double area;
    int euler_characteristic;
    int components;
};

MeshObject::MeshObject(const MeshSpec& spec) : impl_(std::make_unique<const Impl>(spec)) {}
MeshObject::~MeshObject() = default;
MeshObject::MeshObject(MeshObject&&) noexcept = default;
MeshObject& MeshObject::operator=(MeshObject&&) noexcept = default;

std::optional<Point> MeshObject::first_hit(const Segment& segment) const { return impl_->tree.first_hit(segment); }
std::vector<Point> MeshObject::crossings(const Segment& segment) const { return impl_->tree.crossings(segment); }
bool MeshObject::contains(const Point& p) const { return impl_->side({p.x(), p.y(), p.z()}) == CGAL::ON_BOUNDED_SIDE; }
Point MeshObject::closest_point(const Point& p) const { return impl_->tree.closest_point(p); }
double MeshObject::distance(const Point& p) const { return (p - closest_point(p)).norm(); }
const TriangleMesh& MeshObject::mesh() const { return impl_->mesh; }
const Bounds& MeshObject::bounds() const { return impl_->bounds; }
double MeshObject::area() const { return impl_->area; }
int MeshObject::euler_characteristic() const { return impl_->euler_characteristic; }
int MeshObject::components() const { return impl_->components; }
const std::vector<std::string>& MeshObject::warnings() const { return impl_->warnings; }

}  // namespace palpate
