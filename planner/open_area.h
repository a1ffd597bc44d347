// How much surface a mesh with holes has, and about how much it lacks.
#pragma once

#include "planner/geometry.h"

namespace palpate {

struct OpenArea {
    double covered = 0.0;  // mm²: of the facets
    double open = 0.0;     // mm², a guess: of what spans the loops of boundary edges
};

// The guess is good once the holes are smaller than the surface bends, and too small before. It lies halfway between the least area that
// can span a loop (that of the loop's vector area) and that of the fan around the loop's centre. Measured on growing samples of a torus and
// the Stanford bunny, from half of the samples on: 0.65 to 1.25 of what is lacking.
[[nodiscard]] OpenArea measure_open_area(const TriangleMesh& mesh);

}  // namespace palpate
