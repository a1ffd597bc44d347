#include "sim/tool/tool_contact.h"

#include "sim/objects/box_mesh.h"
#include "sim/objects/capsule_contact.h"
#include "sim/tool/internal/tool_parts.h"

namespace palpate {
namespace {

TriangleMesh mesh_of(const std::vector<Box>& boxes) {
    TriangleMesh mesh;
    for (const Box& box : boxes) append_box(mesh, box);
    return mesh;
}

// Around what has grown the tool's part grows instead.
Capsule grown(const Capsule& capsule, double by) { return {capsule.core, capsule.radius + by}; }

}  // namespace

ToolWorld::ToolWorld(const std::vector<GrownTriangles>& object, const std::vector<HalfSpace>& half_spaces, const std::vector<Box>& boxes)
    : half_spaces_(half_spaces) {
    for (const GrownTriangles& part : object) object_.push_back({TriangleTree(part.triangles), part.by});
    if (!boxes.empty()) boxes_.emplace(mesh_of(boxes));
}

std::optional<ToolContact> ToolWorld::first_contact(const ToolShape& tool, const Segment& move) const {
    std::optional<ToolContact> first;
    const auto note = [&](const std::optional<double>& at, ToolContact::Part part, ToolContact::Met met) {
        if (at && (!first || *at < first->at)) first = ToolContact{*at, part, met};
    };
    for (const auto& [part, offset, capsule] : parts_of(tool)) {
        const Segment moved{move.source + offset, move.target + offset};
        for (const Grown& of_object : object_) {
            note(of_object.tree.first_contact(grown(capsule, of_object.by), moved), part, ToolContact::Met::object);
        }
        if (boxes_) note(boxes_->first_contact(capsule, moved), part, ToolContact::Met::fixture);
        for (const HalfSpace& half : half_spaces_) {
            note(first_contact_with_half_space(half.normal, half.normal.dot(half.point), capsule, moved), part, ToolContact::Met::fixture);
        }
    }
    return first;
}

std::vector<Interval> ToolWorld::contacts(const ToolShape& tool, const Segment& move) const {
    Cover cover;
    for (const auto& [part, offset, capsule] : parts_of(tool)) {
        const Segment moved{move.source + offset, move.target + offset};
        for (const Grown& of_object : object_) of_object.tree.add_contacts(grown(capsule, of_object.by), moved, cover);
        if (boxes_) boxes_->add_contacts(capsule, moved, cover);
        for (const HalfSpace& half : half_spaces_) {
            const double height = half.normal.dot(half.point);
            const auto enter = first_contact_with_half_space(half.normal, height, capsule, moved);
            const auto leave = first_contact_with_half_space(half.normal, height, capsule, {moved.target, moved.source});
            if (enter && leave && *enter < 1 - *leave) cover.add({*enter, 1 - *leave});
        }
    }
    return cover.intervals();
}

}  // namespace palpate
