// Which touches the shank or the holder explains.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/geometry.h"
#include "planner/part/internal/contact.h"
#include "planner/part/internal/facet_fans.h"
#include "planner/part/part_surface.h"
#include "planner/tool_shape.h"

namespace palpate {

// REQUIRES: `contacts` are the ball's, one per point. Gives each of them its tag, and those that the shank or the holder explains the
// place on its surface, below what it touches, instead.
[[nodiscard]] std::vector<TouchedPoint> tell_shadows(const TracedSurface& traced, const FacetFans& fans,
                                                     const std::vector<Contact>& contacts, const ToolShape& tool,
                                                     const CompensationOptions& options, bool is_last);

}  // namespace palpate
