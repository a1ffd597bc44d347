#include "tools/view/internal/shadow_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tools/view/internal/rasterizer.h"

namespace palpate {

ShadowMap::ShadowMap(const TriangleMesh& mesh, const Camera& camera, const Vector& direction, int texels)
    : direction_(direction),
      side_(direction.unitOrthogonal()),
      other_(direction.cross(side_)),
      center_(camera.center()),
      texels_(texels),
      texels_per_mm_(texels_ / (2.05 * camera.radius())),
      nearest_(static_cast<std::size_t>(texels) * static_cast<std::size_t>(texels), kNowhere) {
    std::vector<Screen> places;
    places.reserve(mesh.points.size());
    for (const Point& p : mesh.points) places.push_back(place(p));
    for (const auto& [a, b, c] : mesh.triangles) {
        rasterize({places[a], places[b], places[c]}, {texels_, 0, texels_},
                  [this](int y, int first, int end, double nearness, double step) {
                      float* const row = &nearest_[place_in_grid(0, y, texels_)];
                      for (int x = first; x < end; ++x, nearness += step) row[x] = std::max(row[x], static_cast<float>(nearness));
                  });
    }
}

float ShadowMap::lit(const Point& p, const Vector& n) const {
    const Screen s = place(p + n * (2.0 / texels_per_mm_));
    const double x = s.x - 0.5;
    const double y = s.y - 0.5;
    if (!(x >= 0.0 && y >= 0.0 && x < texels_ - 1 && y < texels_ - 1)) {
        return 1.0F;
    }
    const auto column = static_cast<int>(x);
    const auto row = static_cast<int>(y);
    const auto fx = static_cast<float>(x - column);
    const auto fy = static_cast<float>(y - row);
    const auto threshold = static_cast<float>(s.nearness + 1.0 / texels_per_mm_);
    const float* at = &nearest_[place_in_grid(column, row, texels_)];
    const auto open = [threshold](float nearest) { return nearest <= threshold ? 1.0F : 0.0F; };
    return bilinear(fx, fy, open(at[0]), open(at[1]), open(at[texels_]), open(at[texels_ + 1]));
}

Screen ShadowMap::place(const Point& p) const {
    const Vector d = p - center_;
    return {texels_ / 2.0 + texels_per_mm_ * d.dot(side_), texels_ / 2.0 + texels_per_mm_ * d.dot(other_), d.dot(direction_)};
}

}  // namespace palpate
