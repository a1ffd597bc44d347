// A tool and fixtures in words.
#pragma once

#include <string>

#include "planner/fixtures.h"
#include "planner/surroundings.h"
#include "planner/tool_shape.h"

namespace palpate {

// "ball of 2 mm, stylus of 1.4 x 30 mm towards (0, 0, 1), holder of 20 x 60 mm"
[[nodiscard]] std::string describe(const ToolShape& tool);
// "table at z = 0 mm, box (40, -10, 0) mm to (60, 10, 25) mm; nothing but the part stands on them"; "none".
[[nodiscard]] std::string describe(const Fixtures& fixtures);
// Of surroundings that have an area: its size, and the faces that lead into it.
[[nodiscard]] std::string describe_area(const Surroundings& surroundings);

}  // namespace palpate
