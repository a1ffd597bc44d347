// How much surface a mesh with holes has, and about how much it lacks.
#pragma once

#include <cstddef>

#include "planner/geometry.h"

namespace palpate {

struct OpenArea {
    std::size_t facets = 0;  // that are small enough to stay
    double covered = 0.0;    // mm²: by these
    double open = 0.0;       // mm²: by larger facets, and, a guess, by what spans the loops of boundary edges
};

// `epsilon`: mm, the largest circumradius of a facet that is small enough. The guess is good once the holes are smaller than the surface
// bends, and too small before. It lies halfway between the least area that can span a loop (that of the loop's vector area) and that of the
// fan around the loop's centre. Measured on growing samples of a torus and the Stanford bunny, from half of the samples on: 0.65 to 1.25 of
// what is lacking.
[[nodiscard]] OpenArea measure_open_area(const TriangleMesh& mesh, double epsilon);

}  // namespace palpate
