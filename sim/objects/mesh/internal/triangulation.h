// Polygons to triangles.
#pragma once

#include "sim/objects/mesh/internal/polygon_soup.h"

namespace palpate {

// Every polygon of three corners or more by a constrained Delaunay triangulation of its own, seen along an axis; the points stay. One that
// crosses itself there is cut into a fan; if that is wrong, the mesh intersects itself. No triangle names
// a corner twice if no polygon does so in a row.
[[nodiscard]] TriangleMesh triangulated(PolygonSoup soup);

}  // namespace palpate
