// A surface that triangles describe exactly, flat or round.
#pragma once

#include "planner/geometry.h"

namespace palpate {

// All points that are at most `by` away from triangles, which may be segments or points: a ball around a point, a capsule around a segment,
// what lies around the faces of a box with rounded edges. With 0 the triangles themselves.
struct GrownTriangles {
    TriangleMesh triangles;
    double by = 0.0;  // mm, >= 0
};

}  // namespace palpate
