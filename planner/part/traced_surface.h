// What a run's touches say of S*, as compensation takes it (planner/DESIGN.md, "From S* to the part").
#pragma once

#include <cstdint>
#include <vector>

#include "planner/part/part_surface.h"
#include "planner/probe_surface.h"

namespace palpate {

inline constexpr std::uint32_t kNoPoint = ~std::uint32_t{0};

// By touch of the run: the point of its mesh that it became, or kNoPoint.
[[nodiscard]] std::vector<std::uint32_t> points_of_touches(const Result& result);

// The run's mesh, with what is known of its points without a touch, and where the others were touched from. `point_of_touch`: as above.
[[nodiscard]] TracedSurface traced_surface(const Result& result, const std::vector<std::uint32_t>& point_of_touch);

// The run's mesh, open where it has points outside the area that alone was probed: what no touch stands for goes, and points that nothing
// uses then.
[[nodiscard]] TriangleMesh mesh_within_area(const Result& result);

}  // namespace palpate
