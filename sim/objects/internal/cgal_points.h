// Points as CGAL takes them.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "planner/geometry.h"

namespace palpate {

using ExactPredicates = CGAL::Exact_predicates_inexact_constructions_kernel;

[[nodiscard]] inline ExactPredicates::Point_3 to_cgal(const Point& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace palpate
