// The floor below the mesh, which is the picture's paper: bright but for the mesh's soft shadow.
#pragma once

#include <cstddef>
#include <vector>

#include "planner/geometry.h"
#include "tools/view/internal/camera.h"
#include "tools/view/internal/colour.h"
#include "tools/view/internal/shadow_map.h"
#include "tools/view/picture.h"

namespace palpate {

// First every light is shaded, then the shadow is softened, then there is paper.
class Floor {
public:
    // At the mesh's lowest point. `up` is a unit vector.
    Floor(const TriangleMesh& mesh, const Camera& camera, const Vector& up, const PictureOptions& options);

    // Takes away what does not arrive of one light, which is this part of all the light on the floor.
    void shade(const ShadowMap& shadow, float part);
    void soften_shadow();

    [[nodiscard]] Colour paper(int px, int py) const;

private:
    struct Spot {
        Point position = Point::Zero();
        std::size_t place = 0;  // in light_
    };
    void find_spots(const Camera& camera, double height, double step);

    Vector up_;
    int width_px_, height_px_;
    int columns_, rows_;        // of a grid with a place at every kFloorStepPx-th pixel, and one more
    std::vector<Spot> spots_;   // empty without a floor
    std::vector<float> light_;  // per place: the part of all light that falls on the floor there
};

}  // namespace palpate
