// From fixtures as they stand on a machine to what the planner is told: known solids, a workspace that holds them, the faces that lead out
// of it (planner/DESIGN.md, "Known solids").
#pragma once

#include "planner/fixtures.h"
#include "planner/surroundings.h"
#include "planner/tool_shape.h"

namespace palpate {

// `tool`: none is a point. `clearance` (mm, ≥ 0) between tool and fixtures; `epsilon` (mm): the plates that stand for half-spaces are some
// of these thick, and end so far inside ω. ω is the workspace down to the tables, and by as much below. Throws std::invalid_argument on a
// workspace that lies below a table or within a fixture as a whole, and one that no open face leads out of.
[[nodiscard]] Surroundings surroundings_with(const Box& workspace, const Fixtures& fixtures, const ToolShape& tool, double clearance,
                                             double epsilon);

}  // namespace palpate
