// Does a workspace suit a hidden object? Only a simulation can ask.
#pragma once

#include <optional>

#include "planner/region.h"
#include "sim/objects/hidden_object.h"

namespace palpate {

// A ball around the object's bounds, or a box, with a twentieth of its radius to spare.
[[nodiscard]] Region fitting_workspace(const HiddenObject& object);
[[nodiscard]] Region fitting_workspace(const Box& bounds);

// A point of S outside ω, or nearer to its boundary than kClearance of its radius (the tool passes there), if one is found:
// none where the bounds are well inside; otherwise 50,000 points of S, uniform by area, and the points of S nearest to far
// places beyond the outermost ones are looked at, so a tip smaller than their spacing may be missed. Same object, same
// answer.
[[nodiscard]] std::optional<Point> point_outside(const HiddenObject& object, const Region& workspace);
inline constexpr double kClearance = 1e-4;

}  // namespace palpate
