// Shapes that triangles bound exactly: sharp boxes, and unions of those.
#pragma once

#include <optional>

#include "sim/objects/object_spec.h"

namespace palpate {

// Nothing if some part of it is curved.
[[nodiscard]] std::optional<TriangleMesh> triangles_of(const ShapeSpec& shape);

}  // namespace palpate
