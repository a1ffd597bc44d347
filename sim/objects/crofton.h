// Points on a hidden surface, uniformly by area (Cauchy-Crofton; sim/truth.h).
#pragma once

#include <cstddef>
#include <random>
#include <vector>

#include "sim/objects/hidden_object.h"

namespace palpate {

struct SurfaceSample {
    std::vector<Point> points;
    double area = 0.0;  // mm², estimated
};

// Draws lines until at least `count` points are found; the last line's points are kept too. Throws ObjectError if next to no line
// meets the object: it would take for ever.
[[nodiscard]] SurfaceSample sample_surface(const HiddenObject& object, std::size_t count, std::mt19937_64& random);

}  // namespace palpate
