#include "sim/objects/internal/flat_shape.h"

#include "sim/objects/box_mesh.h"
#include "sim/objects/pose.h"

namespace palpate {
namespace {

bool append(TriangleMesh& mesh, const ShapeSpec& shape, const Pose& outer) {
    const Pose pose = outer * make_pose(shape.rotate, shape.at);
    if (const auto* parts = std::get_if<std::vector<ShapeSpec>>(&shape.kind)) {
        return std::ranges::all_of(*parts, [&](const ShapeSpec& part) { return append(mesh, part, pose); });
    }
    const auto* box = std::get_if<RoundedBoxSpec>(&shape.kind);
    if (box == nullptr || box->fillet != 0.0) return false;
    const std::size_t first = mesh.points.size();
    append_box(mesh, {-0.5 * box->size, 0.5 * box->size});
    for (std::size_t k = first; k < mesh.points.size(); ++k) mesh.points[k] = pose.to_world(mesh.points[k]);
    return true;
}

}  // namespace

std::optional<TriangleMesh> triangles_of(const ShapeSpec& shape) {
    TriangleMesh mesh;
    if (!append(mesh, shape, Pose{})) return std::nullopt;
    return mesh;
}

}  // namespace palpate
