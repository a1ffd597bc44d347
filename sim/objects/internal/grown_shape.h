// Shapes that grown triangles bound exactly: spheres, capsules, boxes with edges sharp or rounded, and unions of those.
#pragma once

#include <vector>

#include "sim/objects/grown_triangles.h"
#include "sim/objects/object_spec.h"

namespace palpate {

// One of each growth. Empty where the shape is of another kind.
[[nodiscard]] std::vector<GrownTriangles> grown_triangles_of(const ShapeSpec& shape);

}  // namespace palpate
