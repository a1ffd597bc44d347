// From fixtures as they stand on a machine to what the planner is told: known solids, a workspace that holds them, the faces that lead out
// of it (planner/DESIGN.md, "Known solids").
#pragma once

#include <optional>

#include "planner/area.h"
#include "planner/fixtures.h"
#include "planner/surroundings.h"
#include "planner/tool_shape.h"

namespace palpate {

// `tool`: none is a point. `clearance` (mm, ≥ 0) between tool and fixtures; `epsilon` (mm): the plates that stand for half-spaces are some
// of these thick, and end so far inside ω. ω is the workspace down to the tables, and by as much below. With an area it is what the area
// has of the workspace, with walls around it that are plates, too; faces of the workspace that the area reaches stay open. Throws
// std::invalid_argument on a workspace or an area that lies below a table or within a fixture as a whole, on one that no open face leads
// out of, and on an area that has too little of the workspace.
[[nodiscard]] Surroundings surroundings_with(const Box& workspace, const Fixtures& fixtures, const ToolShape& tool, double clearance,
                                             double epsilon, const std::optional<Area>& area = {});

}  // namespace palpate
