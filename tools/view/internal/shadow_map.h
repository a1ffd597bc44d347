// How near the light the mesh comes, on a grid across the light's direction.
#pragma once

#include <vector>

#include "planner/geometry.h"
#include "tools/view/internal/camera.h"
#include "tools/view/internal/screen.h"

namespace palpate {

class ShadowMap {
public:
    // `direction` is a unit vector towards the light. The map covers the ball that the camera looks at; it has texels × texels places.
    ShadowMap(const TriangleMesh& mesh, const Camera& camera, const Vector& direction, int texels);

    // Part of the light that arrives at `p`, whose surface has normal `n`: 0 to 1, interpolated between grid points. A
    // texel's width of slack on either axis, or else the surface's slope would shade itself.
    [[nodiscard]] float lit(const Point& p, const Vector& n) const;

private:
    [[nodiscard]] Screen place(const Point& p) const;

    Vector direction_, side_, other_;
    Point center_;
    int texels_;
    double texels_per_mm_;
    std::vector<float> nearest_;
};

}  // namespace palpate
