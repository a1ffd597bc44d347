// The light of the studio: a key, a fill and the sky, each as many lights from one direction.
#pragma once

#include <vector>

#include "planner/geometry.h"
#include "tools/view/internal/camera.h"
#include "tools/view/internal/colour.h"

namespace palpate {

struct Light {
    Vector direction;  // towards the light
    Colour intensity;
};

// `up` is a unit vector. The lamps move with the camera, the sky stays above.
[[nodiscard]] std::vector<Light> studio(const Camera& camera, const Vector& up);

// What the floor sends back to a surface with this unit normal.
[[nodiscard]] Colour bounce(const Vector& normal, const Vector& up);

}  // namespace palpate
