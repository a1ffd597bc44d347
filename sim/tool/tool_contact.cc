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

}  // namespace

ToolWorld::ToolWorld(const TriangleMesh& object, const std::vector<HalfSpace>& half_spaces, const std::vector<Box>& boxes)
    : object_(object), half_spaces_(half_spaces) {
    if (!boxes.empty()) boxes_.emplace(mesh_of(boxes));
}

std::optional<ToolContact> ToolWorld::first_contact(const ToolShape& tool, const Segment& move) const {
    std::optional<ToolContact> first;
    const auto note = [&](const std::optional<double>& at, ToolContact::Part part, ToolContact::Met met) {
        if (at && (!first || *at < first->at)) first = ToolContact{*at, part, met};
    };
    for (const auto& [part, offset, capsule] : parts_of(tool)) {
        const Segment moved{move.source + offset, move.target + offset};
        note(object_.first_contact(capsule, moved), part, ToolContact::Met::object);
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
        object_.add_contacts(capsule, moved, cover);
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
