// Which side of every triangle is outside.
#pragma once

#include <cstddef>

#include "planner/geometry.h"

namespace palpate {

// Turns triangles so that all that hang together through edges of two triangles agree, as few as it takes; returns how many. What is
// one-sided, like a Klein bottle, stays as it is.
std::size_t orient_coherently(TriangleMesh& mesh);

struct Components {
    std::size_t count = 0;
    std::size_t inside_out = 0;  // were turned
    std::size_t cavities = 0;    // lie inside another, facing inwards; no touch can find them
};

// Turns components of a closed, coherently oriented mesh without self-intersections so that they bound a solid: outermost ones outwards,
// what is nested in them alternately inwards and outwards.
Components orient_outward(TriangleMesh& mesh);

}  // namespace palpate
