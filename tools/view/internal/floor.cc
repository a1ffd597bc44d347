#include "tools/view/internal/floor.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "tools/view/internal/screen.h"

namespace palpate {

namespace {

const Colour kPaper{0.985F, 0.985F, 0.985F};
constexpr float kGroundShadow = 0.7F;
constexpr float kFadingBorder = 0.2F;  // of the width
constexpr int kFloorStepPx = 6;        // shadows on the floor are soft

double lowest(const TriangleMesh& mesh, const Vector& up) {
    double height = std::numeric_limits<double>::infinity();
    for (const auto& triangle : mesh.triangles) {
        for (const auto i : triangle) {
            height = std::min(height, up.dot(mesh.points[i]));
        }
    }
    return height;
}

// Three box filters in each direction come close to a Gaussian.
void blur(std::vector<float>& values, int columns, int rows, int radius) {
    std::vector<float> source;
    const auto pass = [&](int dx, int dy) {
        source = values;
        for (int i = 0; i < columns * rows; ++i) {
            float sum = 0.0F;
            for (int k = -radius; k <= radius; ++k) {
                const int x = std::clamp(i % columns + k * dx, 0, columns - 1);
                const int y = std::clamp(i / columns + k * dy, 0, rows - 1);
                sum += source[place_in_grid(x, y, columns)];
            }
            values[static_cast<std::size_t>(i)] = sum / static_cast<float>(2 * radius + 1);
        }
    };
    for (int i = 0; i < 3; ++i) {
        pass(1, 0);
        pass(0, 1);
    }
}

}  // namespace

Floor::Floor(const TriangleMesh& mesh, const Camera& camera, const Vector& up, const PictureOptions& options)
    : up_(up),
      width_px_(options.width_px),
      height_px_(options.height_px),
      columns_(options.width_px / kFloorStepPx + 2),
      rows_(options.height_px / kFloorStepPx + 2),
      light_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 1.0F) {
    if (options.ground) {
        find_spots(camera, lowest(mesh, up), kFloorStepPx * options.supersampling);
    }
}

// The places of the floor behind a coarser grid, also those that the object hides: they matter to blurring. The grid's
// step is in samples.
void Floor::find_spots(const Camera& camera, double height, double step) {
    for (int i = 0; i < columns_ * rows_; ++i) {
        const int column = i % columns_;
        const int row = i / columns_;
        const auto [origin, direction] = camera.sight(column * step, row * step);
        const double t = (height - up_.dot(origin)) / up_.dot(direction);
        if (up_.dot(direction) < -1e-6 * direction.norm() && t > 0.0) {
            spots_.push_back({origin + t * direction, static_cast<std::size_t>(i)});
        }
    }
}

void Floor::shade(const ShadowMap& shadow, float part) {
    for (const Spot& spot : spots_) {
        light_[spot.place] -= part * (1.0F - shadow.lit(spot.position, up_));
    }
}

void Floor::soften_shadow() { blur(light_, columns_, rows_, std::max(1, columns_ / 80)); }

// Between the four nearest places of the floor's grid.
Colour Floor::paper(int px, int py) const {
    const int x = px / kFloorStepPx;
    const int y = py / kFloorStepPx;
    const float fx = static_cast<float>(px % kFloorStepPx) / kFloorStepPx;
    const float fy = static_cast<float>(py % kFloorStepPx) / kFloorStepPx;
    const auto at = [&](int dx, int dy) { return light_[place_in_grid(x + dx, y + dy, columns_)]; };
    const float light = bilinear(fx, fy, at(0, 0), at(1, 0), at(0, 1), at(1, 1));
    if (light >= 1.0F) return kPaper;
    // The picture's border cuts no shadow: it fades before.
    const auto fade = [](int place, int size) {
        const float t = std::min(1.0F, static_cast<float>(std::min(place, size - 1 - place)) / (kFadingBorder * static_cast<float>(size)));
        return t * t * (3.0F - 2.0F * t);
    };
    return kPaper * (1.0F - kGroundShadow * fade(px, width_px_) * fade(py, height_px_) * (1.0F - light));
}

}  // namespace palpate
