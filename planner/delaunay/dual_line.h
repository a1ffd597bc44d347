// Dual edges of Delaunay facets, without building them from circumcentres (planner/DESIGN.md, "Numerics").
//
// Notation, after planner/DESIGN.md, "Numerics":
//   a, b, c  the vertices of a facet f; d the fourth vertex of a cell that has f
//   m, n     the circumcentre and unit normal of f: the dual edge of f lies on x(t) = m + t·n
//   t(d)     the parameter of the circumcentre of abcd on that line
// Four nearly coplanar points have a circumcentre anywhere, but n stays good and |t| merely grows: clipped to the
// workspace, nothing is lost. Values that double arithmetic cannot give to about 1e-10 of the workspace are computed in
// rational arithmetic and rounded once.
#pragma once

#include "planner/geometry.h"

namespace palpate {

struct DualLine {
    Point origin = Point::Zero();       // m
    Vector direction = Vector::Zero();  // n, in the direction of (b - a) × (c - a)
    double circumradius = 0.0;          // mm

    [[nodiscard]] Point at(double t) const { return origin + t * direction; }
};

// The same three points in the same order give the same bytes. a, b, c must not be collinear.
[[nodiscard]] DualLine dual_line(const Point& a, const Point& b, const Point& c);

// t(d) for the line of a, b, c. `side` is +1 or -1: the side of the facet on which d lies, in the direction of n, exactly.
// `limit` (mm) is an absolute parameter beyond which the caller only wants the sign: then any value as far out may come
// back.
[[nodiscard]] double circumcentre_parameter(const DualLine& line, const Point& a, const Point& b, const Point& c, const Point& d, int side,
                                            double limit);

// The circumcentre of a, b, c, d; `limit` (mm) is a distance from a beyond which the caller only wants to know that the
// circumcentre is farther: then any point farther than that may come back.
[[nodiscard]] Point circumcentre(const Point& a, const Point& b, const Point& c, const Point& d, double limit);

}  // namespace palpate
