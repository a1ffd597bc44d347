#include "sim/objects/mesh/mesh_object.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <new>
#include <utility>

#include "planner/union_find.h"
#include "sim/objects/errors.h"
#include "sim/objects/mesh/internal/mesh_check.h"
#include "sim/objects/mesh/internal/mesh_reader.h"
#include "sim/objects/mesh/internal/mesh_repair.h"
#include "sim/objects/mesh/internal/message_text.h"
#include "sim/objects/mesh/internal/orientation.h"
#include "sim/objects/mesh/internal/surface_mesh.h"
#include "sim/objects/pose.h"
#include "sim/objects/triangle_tree.h"

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

struct CheckedMesh {
    TriangleMesh mesh;
    std::vector<std::string> warnings;
};

void append(std::string& text, const std::string& separator, const std::string& more) { text += (text.empty() ? "" : separator) + more; }

void refuse_problems(const std::vector<std::string>& problems) {
    std::string text;
    for (const std::string& problem : problems) append(text, "; ", problem);
    if (!text.empty()) throw ObjectError(fmt::format("not the surface of a solid: {}", text));
}

Box bounds_of(const std::vector<Point>& points) {
    Box box{points.front(), points.front()};
    for (const Point& p : points) box = {box.min.cwiseMin(p), box.max.cwiseMax(p)};
    return box;
}

void place(TriangleMesh& mesh, const MeshSpec& spec) {
    const Pose pose = make_pose(spec.rotate, spec.at);
    for (Point& p : mesh.points) p = pose.to_world(spec.scale * p);
    const Box box = bounds_of(mesh.points);
    if (!(box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).maxCoeff() <= kLargestCoordinate)) {
        throw ObjectError("is too large or too far away, in mm, to be reckoned with");
    }
    if (!((box.max - box.min).maxCoeff() >= 1.0 / kLargestCoordinate)) throw ObjectError("is too small, in mm, to be reckoned with");
}

void refuse_repairs(const std::vector<Repair>& repairs) {
    std::string text;
    for (const Repair& repair : repairs) append(text, ", ", repair.defect);
    throw ObjectError(
        fmt::format("needs repair, which object.repair forbids: {}; set object.repair: true, or export the mesh again", text));
}

// Mended and checked in the file's own coordinates as far as possible: what is exact there, such as three points on a line, need not be
// so any more once it is placed.
CheckedMesh checked_mesh(PolygonSoup soup, const MeshSpec& spec) {
    if (!std::isfinite(spec.scale) || spec.scale <= 0.0) {
        throw ObjectError(fmt::format("scale must be a positive number, but it is {:f}", spec.scale));
    }
    if (!spec.at.allFinite() || !spec.rotate.allFinite()) throw ObjectError("at and rotate must be finite numbers");
    auto [mesh, repairs] = repaired(std::move(soup), spec.scale);
    if (mesh.triangles.empty()) throw ObjectError("not the surface of a solid: all its faces are without area");
    refuse_problems(topology_problems(mesh, spec.scale, make_pose(spec.rotate, spec.at)));
    place(mesh, spec);
    refuse_problems(geometry_problems(mesh));
    const Components components = orient_outward(mesh);
    if (components.inside_out > 0) {
        const bool one = components.inside_out == 1;
        const std::string which = components.count == 1 ? "component" : fmt::format("of {} components", components.count);
        repairs.push_back({fmt::format("{} {} {} inside out", components.inside_out, which, one ? "was" : "were"),
                           one ? "and has been turned" : "and have been turned"});
    }
    if (!spec.repair && !repairs.empty()) refuse_repairs(repairs);
    CheckedMesh result{std::move(mesh), {}};
    for (const Repair& repair : repairs) result.warnings.push_back(fmt::format("{} {}", repair.defect, repair.remedy));
    if (components.cavities > 0) {
        result.warnings.push_back(fmt::format("{} inside another; no probe can reach it",
                                              counted(components.cavities, "component is a cavity", "components are cavities")));
    }
    return result;
}

CheckedMesh checked_mesh(const MeshSpec& spec) {
    PolygonSoup soup = read_mesh(spec.file);
    const std::string file = spec.file.string();
    try {
        CheckedMesh checked = checked_mesh(std::move(soup), spec);
        for (std::string& warning : checked.warnings) warning = fmt::format("{}: {}", file, warning);
        return checked;
    } catch (const ObjectError& error) {
        throw ObjectError(fmt::format("{}: {}", file, error.what()));
    } catch (const std::bad_alloc&) {
        throw ObjectError(fmt::format("{}: is too large for the memory of this computer; simplify the mesh", file));
    }
}

double area_of(const TriangleMesh& mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += 0.5 * (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm();
    }
    return sum;
}

int count_components(const TriangleMesh& mesh) {
    UnionFind joined(mesh.points.size());
    auto count = static_cast<int>(mesh.points.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        count -= joined.join(a, b) ? 1 : 0;
        count -= joined.join(b, c) ? 1 : 0;
    }
    return count;
}

}  // namespace

struct MeshObject::Impl {
    explicit Impl(CheckedMesh checked)
        : mesh(std::move(checked.mesh)),
          warnings(std::move(checked.warnings)),
          surface(to_surface_mesh(mesh)),
          side(surface),
          tree(mesh),
          bounds(bounds_of(mesh.points)),
          area(area_of(mesh)),
          // V - E + F of a closed triangle mesh, where E = 3F/2.
          euler_characteristic(static_cast<int>(mesh.points.size()) - static_cast<int>(mesh.triangles.size()) / 2),
          components(count_components(mesh)) {
        side(surface.point(SurfaceMesh::Vertex_index(0)));  // builds its tree now
    }

    TriangleMesh mesh;
    std::vector<std::string> warnings;
    SurfaceMesh surface;
    CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel> side;  // refers to surface
    TriangleTree tree;
    Box bounds;
    double area;
    int euler_characteristic;
    int components;
};

MeshObject::MeshObject(const MeshSpec& spec) : impl_(std::make_unique<const Impl>(checked_mesh(spec))) {}
MeshObject::~MeshObject() = default;
MeshObject::MeshObject(MeshObject&&) noexcept = default;
MeshObject& MeshObject::operator=(MeshObject&&) noexcept = default;

std::optional<Point> MeshObject::first_hit(const Segment& segment) const { return impl_->tree.first_hit(segment); }
std::vector<Point> MeshObject::crossings(const Segment& segment) const { return impl_->tree.crossings(segment); }
bool MeshObject::contains(const Point& p) const { return impl_->side({p.x(), p.y(), p.z()}) == CGAL::ON_BOUNDED_SIDE; }
Point MeshObject::closest_point(const Point& p) const { return impl_->tree.closest_point(p); }
double MeshObject::distance(const Point& p) const { return (p - closest_point(p)).norm(); }
const TriangleMesh& MeshObject::mesh() const { return impl_->mesh; }
const Box& MeshObject::bounds() const { return impl_->bounds; }
double MeshObject::area() const { return impl_->area; }
int MeshObject::euler_characteristic() const { return impl_->euler_characteristic; }
int MeshObject::components() const { return impl_->components; }
const std::vector<std::string>& MeshObject::warnings() const { return impl_->warnings; }

}  // namespace palpate
