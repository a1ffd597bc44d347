// What a moving tool meets first: which of its parts, and whether the hidden part or a fixture. A simulator's secret: a machine only sees
// that something was touched, and where the ball's centre was.
#pragma once

#include <optional>
#include <vector>

#include "planner/fixtures.h"
#include "planner/geometry.h"
#include "planner/tool_shape.h"
#include "sim/objects/grown_triangles.h"
#include "sim/objects/triangle_tree.h"

namespace palpate {

struct ToolContact {
    enum class Part { ball, stylus, holder };
    enum class Met { object, fixture };

    double at = 0.0;  // parameter in [0, 1] along the move
    Part part = Part::ball;
    Met met = Met::object;
};

// Const queries may run at the same time on several threads.
class ToolWorld {
public:
    // Solids by their boundaries: grown triangles of the object, half-spaces and boxes of the fixtures.
    ToolWorld(const std::vector<GrownTriangles>& object, const std::vector<HalfSpace>& half_spaces, const std::vector<Box>& boxes);

    // Throws std::invalid_argument on a tool without a ball, or with a stylus that is thicker than that.
    // Nothing if the tool, whose reference point makes that move, meets nothing; at 0 if something is in the tool where it begins. What
    // only touches it there, and is left, does not count. Of parts and bodies that are met at once the first named.
    [[nodiscard]] std::optional<ToolContact> first_contact(const ToolShape& tool, const Segment& move) const;
    // Where along the move, in [0, 1], some part of the tool touches a boundary, or is in a half-space; in order. Not all that is
    // forbidden: between two of them a part may be inside a solid as a whole.
    [[nodiscard]] std::vector<Interval> contacts(const ToolShape& tool, const Segment& move) const;

private:
    struct Grown {
        TriangleTree tree;
        double by;  // mm
    };

    std::vector<Grown> object_;
    std::vector<HalfSpace> half_spaces_;
    std::optional<TriangleTree> boxes_;
};

}  // namespace palpate
