// The parts of a tool as capsules.
#pragma once

#include <vector>

#include "planner/tool_shape.h"
#include "sim/objects/capsule_contact.h"
#include "sim/tool/tool_contact.h"

namespace palpate {

struct ToolPart {
    ToolContact::Part part = ToolContact::Part::ball;
    Vector offset = Vector::Zero();  // mm: from the reference point to where its axis begins
    Capsule capsule;
};

// From the ball upwards. Throws std::invalid_argument on a tool without a ball, or with a stylus that is thicker than that.
[[nodiscard]] std::vector<ToolPart> parts_of(const ToolShape& tool);

}  // namespace palpate
