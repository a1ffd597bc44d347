#include "sim/objects/internal/grown_shape.h"

#include <algorithm>

#include "sim/objects/box_mesh.h"
#include "sim/objects/pose.h"

namespace palpate {
namespace {

TriangleMesh& with_growth(std::vector<GrownTriangles>& all, double by) {
    const auto same = std::ranges::find(all, by, &GrownTriangles::by);
    if (same != all.end()) return same->triangles;
    all.push_back({TriangleMesh{}, by});
    return all.back().triangles;
}

// A segment, or a point, as a triangle without area.
void append_segment(TriangleMesh& mesh, const Point& a, const Point& b) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), {a, b});
    mesh.triangles.push_back({first, first + 1, first});
}

bool append(std::vector<GrownTriangles>& all, const ShapeSpec& shape, const Pose& outer) {
    const Pose pose = outer * make_pose(shape.rotate, shape.at);
    if (const auto* parts = std::get_if<std::vector<ShapeSpec>>(&shape.kind)) {
        return std::ranges::all_of(*parts, [&](const ShapeSpec& part) { return append(all, part, pose); });
    }
    if (const auto* sphere = std::get_if<SphereSpec>(&shape.kind)) {
        append_segment(with_growth(all, sphere->radius), pose.translation, pose.translation);
        return true;
    }
    if (const auto* capsule = std::get_if<CapsuleSpec>(&shape.kind)) {
        const Vector half = 0.5 * capsule->length * Vector::UnitZ();
        append_segment(with_growth(all, capsule->radius), pose.to_world(-half), pose.to_world(half));
        return true;
    }
    const auto* box = std::get_if<RoundedBoxSpec>(&shape.kind);
    if (box == nullptr) return false;
    TriangleMesh& mesh = with_growth(all, box->fillet);
    const std::size_t first = mesh.points.size();
    const Vector core = (0.5 * box->size - Vector::Constant(box->fillet)).cwiseMax(0.0);
    append_box(mesh, {-core, core});
    for (std::size_t k = first; k < mesh.points.size(); ++k) mesh.points[k] = pose.to_world(mesh.points[k]);
    return true;
}

}  // namespace

std::vector<GrownTriangles> grown_triangles_of(const ShapeSpec& shape) {
    std::vector<GrownTriangles> all;
    if (!append(all, shape, Pose{})) return {};
    return all;
}

}  // namespace palpate
