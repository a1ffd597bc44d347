#include "sim/tool/tool_contact.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "sim/objects/capsule_contact.h"

namespace palpate {
namespace {

TriangleMesh mesh_of(const std::vector<Box>& boxes) {
    TriangleMesh mesh;
    for (const Box& box : boxes) {
        const auto first = static_cast<std::uint32_t>(mesh.points.size());
        for (unsigned k = 0; k < 8; ++k) {
            mesh.points.emplace_back((k & 1U ? box.max : box.min).x(), (k & 2U ? box.max : box.min).y(), (k & 4U ? box.max : box.min).z());
        }
        // By face: its corners in turn.
        constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
            {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
        for (const auto& [a, b, c, d] : kFaces) {
            mesh.triangles.push_back({first + a, first + b, first + c});
            mesh.triangles.push_back({first + a, first + c, first + d});
        }
    }
    return mesh;
}

struct PlacedCapsule {
    ToolContact::Part part;
    Vector offset;  // from the reference point to where it begins
    Capsule capsule;
};

std::vector<PlacedCapsule> parts_of(const ToolShape& tool) {
    if (!(tool.ball_diameter > 0)) throw std::invalid_argument("the tool's ball needs a diameter");
    if (tool.stylus && tool.stylus->diameter > tool.ball_diameter) throw std::invalid_argument("the stylus is thicker than its ball");
    std::vector<PlacedCapsule> parts{{ToolContact::Part::ball, Vector::Zero(), {Vector::Zero(), tool.ball_diameter / 2}}};
    double end = 0;
    if (tool.stylus) {
        // From the ball's centre: its lower end is within the ball.
        const double radius = tool.stylus->diameter / 2;
        end = tool.stylus->length;
        parts.push_back({ToolContact::Part::stylus, Vector::Zero(), {std::max(0.0, end - radius) * tool.axis, radius}});
    }
    if (tool.holder) {
        const double radius = tool.holder->diameter / 2;
        parts.push_back(
            {ToolContact::Part::holder, (end + radius) * tool.axis, {std::max(0.0, tool.holder->length - 2 * radius) * tool.axis, radius}});
    }
    return parts;
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

}  // namespace palpate
