// What of the part's mesh is left of S*'s facets around a sharp edge: slivers, which go, and facets that pass through others.
#pragma once

#include "planner/part/part_surface.h"

namespace palpate {

// Joins measured points nearer to each other than `length` (mm), as those that touched the same place of a sharp edge: the one that is
// known better stays. Leaves the topology as it is, and no facet turned over that was not. A mesh that is no manifold stays as it is.
void join_near_points(PartSurface& part, double length);

// Finds facets that pass through others and raises the uncertainty of their measured corners to how far.
void find_crossings(PartSurface& part);

}  // namespace palpate
