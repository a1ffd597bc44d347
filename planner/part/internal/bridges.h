// Inner edges narrower than the ball reaches: which facets span them, and where their middle is.
#pragma once

#include "planner/part/part_surface.h"

namespace palpate {

// mm: from an inner edge, whose faces' normals enclose `turn` (rad, below π), to the ball that lies in it.
[[nodiscard]] double bridge_gap(double radius, double turn);

// The part with the connectivity of S*: points as touched, facets tagged.
[[nodiscard]] PartSurface assemble(const TracedSurface& traced, const std::vector<TouchedPoint>& touched, double epsilon);

// Splits edges that cross an inner edge at the ball's deepest place in it: there S* has its crease.
void split_bridges(PartSurface& part, const TracedSurface& traced, double radius);

}  // namespace palpate
