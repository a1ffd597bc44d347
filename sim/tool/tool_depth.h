// How deep a tool is in the hidden object and in fixtures, by distances of its parts' axes: independent of the closed form of
// tool_contact.h, and with a tree of its own.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "planner/fixtures.h"
#include "planner/tool_shape.h"
#include "sim/objects/hidden_object.h"
#include "sim/tool/tool_contact.h"

namespace palpate {

// mm, 0 outside: so far the reference point has to move, at least, for the tool to get out.
struct ToolDepth {
    double object = 0.0;
    double fixture = 0.0;

    [[nodiscard]] double deepest() const { return std::max(object, fixture); }
};

// Const queries may run at the same time on several threads.
class ToolDepths {
public:
    // `object` must outlive this. No tool: a point. Throws std::invalid_argument on a tool with a body if grown triangles do not bound the
    // object (HiddenObject::grown_triangles), and on what is no tool.
    ToolDepths(const HiddenObject& object, const std::optional<ToolShape>& tool, const std::vector<Fixture>& fixtures);
    ~ToolDepths();
    ToolDepths(ToolDepths&&) noexcept;
    ToolDepths& operator=(ToolDepths&&) noexcept;

    // A part whose axis is outside is as deep as its radius lacks of the axis' distance. Of one whose axis enters the solid, places
    // kSpacing of its length apart are looked at, for the deepest.
    [[nodiscard]] ToolDepth at(const Point& p) const;
    // The most of it along a straight move: the distance of all that the axes sweep. Exact unless an axis enters, and then at least the
    // part's radius; and that of places kSpacing of the move apart.
    [[nodiscard]] ToolDepth along(const Segment& move) const;
    static constexpr double kSpacing = 1.0 / 32;

    // mm: between a tool that is outside and what is nearest, `within` at the most; a little below 0 where it is in. Nothing without a
    // tool.
    [[nodiscard]] std::optional<double> gap(const Point& p, double within) const;

    // Which part is the deepest, or the nearest if it is at most `within` (mm) away; of several the first named. Nothing without a tool.
    [[nodiscard]] std::optional<ToolContact> touching(const Point& p, double within) const;

private:
    struct Impl;
    std::unique_ptr<const Impl> impl_;
};

}  // namespace palpate
