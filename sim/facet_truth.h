// Which facets of a result S really has: those of Del|S(E), within balls of radius ε.
#pragma once

#include <span>
#include <vector>

#include "planner/geometry.h"
#include "sim/objects/hidden_object.h"

namespace palpate {

enum class FacetVerdict {
    right,
    flip,   // S passes the dual edge's end by kFlip at most: four samples are so nearly on one circle that either diagonal is as good
    wrong,  // neither
};

// Of ε.
inline constexpr double kFlip = 0.05;

// By triangle of the mesh. `dual_edges`: one each. REQUIRES: epsilon > 0, mm.
[[nodiscard]] std::vector<FacetVerdict> judge_facets(const HiddenObject& object, const TriangleMesh& mesh,
                                                     std::span<const Segment> dual_edges, double epsilon);

}  // namespace palpate
