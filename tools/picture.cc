// Geometry decides what each sample shows, then one light after the other falls on it, then samples become pixels.
#include "tools/picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/internal/camera.h"
#include "tools/internal/colour.h"
#include "tools/internal/floor.h"
#include "tools/internal/item_buffer.h"
#include "tools/internal/lights.h"
#include "tools/internal/png_file.h"
#include "tools/internal/screen.h"
#include "tools/internal/seen_mesh.h"
#include "tools/internal/shadow_map.h"

namespace palpate {

namespace {

constexpr double kMaxSamples = 4e8;  // 8 bytes each
constexpr int kMinShadowTexels = 64;
constexpr int kMaxShadowTexels = 1024;

// Colours were chosen by eye.
const Colour kSurface{0.30F, 0.41F, 0.60F};
const Colour kEdge{0.035F, 0.05F, 0.085F};
const Colour kTouch{0.90F, 0.075F, 0.012F};
constexpr float kEdgeOpacity = 0.55F;
constexpr double kEdgeHalfWidthPx = 0.45;
constexpr double kEdgeFadePx = 14.0;       // the lines of shorter median edges fade
constexpr double kMaxTouchRadius = 0.025;  // of the mesh's

class Painter {
public:
    Painter(const TriangleMesh& mesh, std::span<const Point> touches, const PictureOptions& options)
        : mesh_(mesh),
          touches_(touches),
          options_(options),
          up_(options.up.normalized()),
          camera_(mesh, options),
          seen_(mesh, camera_),
          floor_(mesh, camera_, up_, options),
          edge_length_(median_edge(mesh)),
          touch_radius_(std::min(options.touch_radius * edge_length_, kMaxTouchRadius * camera_.radius())),
          items_(options.width_px * options.supersampling, options.height_px * options.supersampling) {}
    Painter(const Painter&) = delete;  // seen_ refers to camera_
    Painter& operator=(const Painter&) = delete;

    [[nodiscard]] Picture paint() {
        draw_items();
        gather_light();
        return resolve();
    }

private:
    struct Spot {
        SurfacePoint surface;
        std::size_t pixel = 0;
    };

    void draw_items();
    [[nodiscard]] std::vector<Spot> surface_spots() const;
    void gather_light();
    [[nodiscard]] Colour colour(int x, int y) const;
    [[nodiscard]] float edge_cover(std::size_t t, double x, double y) const;
    [[nodiscard]] Picture resolve() const;
    [[nodiscard]] bool is_triangle(std::int32_t item) const { return item >= 0 && static_cast<std::size_t>(item) < mesh_.triangles.size(); }

    const TriangleMesh& mesh_;
    std::span<const Point> touches_;
    const PictureOptions& options_;
    Vector up_;
    Camera camera_;
    SeenMesh seen_;
    Floor floor_;
    double edge_length_;         // mm, the median
    double touch_radius_;        // mm
    ItemBuffer items_;           // triangles, then touches
    std::vector<Colour> light_;  // per pixel: what falls on the surface there
};

void Painter::draw_items() {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        items_.draw_triangle(seen_.corners(t), static_cast<std::int32_t>(t));
    }
    for (std::size_t i = 0; i < touches_.size(); ++i) {
        items_.draw_ball(camera_, touches_[i], touch_radius_, static_cast<std::int32_t>(mesh_.triangles.size() + i));
    }
}

// The places of the surface that pixels show, one per pixel: light varies slowly.
std::vector<Painter::Spot> Painter::surface_spots() const {
    const int n = options_.supersampling;
    std::vector<Spot> spots;
    for (int i = 0; i < options_.width_px * options_.height_px; ++i) {
        // The sample in the middle speaks for its pixel, or any other on the surface.
        for (int k = 0; k < n * n; ++k) {
            const int m = (k + n * n / 2) % (n * n);
            const int x = i % options_.width_px * n + m % n;
            const int y = i / options_.width_px * n + m / n;
            if (const std::int32_t item = items_.item(x, y); is_triangle(item)) {
                spots.push_back({seen_.surface(static_cast<std::size_t>(item), x + 0.5, y + 0.5), static_cast<std::size_t>(i)});
                break;
            }
        }
    }
    return spots;
}

// One shadow map at a time over all places.
void Painter::gather_light() {
    light_.assign(static_cast<std::size_t>(options_.width_px) * static_cast<std::size_t>(options_.height_px), Colour::Zero());
    const std::vector<Spot> spots = surface_spots();
    const std::vector<Light> lights = studio(camera_, up_);
    const int texels = std::clamp(std::max(options_.width_px, options_.height_px) / 2, kMinShadowTexels, kMaxShadowTexels);
    const auto on_floor = [this](const Light& light) {
        return std::max(0.0F, static_cast<float>(up_.dot(light.direction))) * light.intensity.mean();
    };
    float all_on_floor = 0.0F;
    for (const Light& light : lights) {
        all_on_floor += on_floor(light);
    }
    for (const Light& light : lights) {
        const ShadowMap shadow(mesh_, camera_, light.direction, texels);
        for (const auto& [surface, pixel] : spots) {
            if (const auto cosine = static_cast<float>(surface.normal.dot(light.direction)); cosine > 0.0F) {
                light_[pixel] += cosine * shadow.lit(surface.position, surface.normal) * light.intensity;
            }
        }
        floor_.shade(shadow, on_floor(light) / all_on_floor);
    }
    for (const auto& [surface, pixel] : spots) {
        light_[pixel] += bounce(surface.normal, up_);
    }
    floor_.soften_shadow();
}

// How much of a sample an edge's line covers, 0 to 1, softened over a pixel.
float Painter::edge_cover(std::size_t t, double x, double y) const {
    return static_cast<float>(std::clamp(kEdgeHalfWidthPx + 0.5 - seen_.edge_distance(t, x, y) / options_.supersampling, 0.0, 1.0));
}

Colour Painter::colour(int x, int y) const {
    const int n = options_.supersampling;
    const std::int32_t id = items_.item(x, y);
    if (id == kBackground) {
        return floor_.paper(x / n, y / n);
    }
    const Colour& light = light_[place_in_grid(x / n, y / n, options_.width_px)];
    if (!is_triangle(id)) {
        const Screen c = camera_.project(touches_[static_cast<std::size_t>(id) - mesh_.triangles.size()]);
        const double r = touch_radius_ * camera_.magnification(c.nearness);
        const double lean = (-(x + 0.5 - c.x) - (y + 0.5 - c.y)) / r;  // towards the key light at the upper left
        return kTouch * static_cast<float>(0.95 + 0.25 * lean);
    }
    const double edge_px = edge_length_ * camera_.magnification(items_.nearness(x, y)) / n;
    const float opacity = options_.edges ? kEdgeOpacity * static_cast<float>(std::min(1.0, edge_px / kEdgeFadePx)) : 0.0F;
    const float line = opacity > 0.0F ? opacity * edge_cover(static_cast<std::size_t>(id), x + 0.5, y + 0.5) : 0.0F;
    return soften(((1.0F - line) * kSurface + line * kEdge) * light);
}

Picture Painter::resolve() const {
    const int n = options_.supersampling;
    Picture picture{options_.width_px, options_.height_px, {}};
    picture.rgb.reserve(light_.size() * 3);
    for (int py = 0; py < options_.height_px; ++py) {
        for (int px = 0; px < options_.width_px; ++px) {
            Colour sum = Colour::Zero();
            for (int k = 0; k < n * n; ++k) {
                sum += colour(px * n + k % n, py * n + k / n).min(1.0F);
            }
            for (const float channel : Colour(sum / static_cast<float>(n * n))) {
                picture.rgb.push_back(to_srgb(channel));
            }
        }
    }
    return picture;
}

void require(bool condition, const std::string& message) {
    if (!condition) {
        throw std::invalid_argument("picture: " + message);
    }
}

void check(const TriangleMesh& mesh, std::span<const Point> touches, const PictureOptions& options) {
    require(!mesh.triangles.empty(), "the mesh has no triangles");
    Eigen::AlignedBox3d box;
    for (const auto& triangle : mesh.triangles) {
        for (const auto i : triangle) {
            require(i < mesh.points.size(), "a triangle has vertex " + std::to_string(i) + " of " + std::to_string(mesh.points.size()));
            require(mesh.points[i].allFinite(), "vertex " + std::to_string(i) + " is not finite");
            box.extend(mesh.points[i]);
        }
    }
    require(box.diagonal().norm() > 0.0, "all vertices of the mesh are one point");
    require(std::all_of(touches.begin(), touches.end(), [](const Point& p) { return p.allFinite(); }), "a touch is not finite");
    require(options.width_px > 0 && options.height_px > 0, "width and height have to be at least 1 pixel");
    require(options.supersampling >= 1 && options.supersampling <= 8, "supersampling has to be 1 to 8");
    require(1.0 * options.width_px * options.height_px * options.supersampling * options.supersampling <= kMaxSamples,
            "width times height is too large");
    require(options.margin >= 0.0 && options.margin < 0.5, "the margin has to be at least 0 and less than 0.5");
    require(options.touch_radius >= 0.0 && std::isfinite(options.touch_radius), "the radius of touches has to be at least 0");
    const double sine = options.up.normalized().cross(options.view_direction.normalized()).norm();
    require(sine > 1e-6, "the view has to have a direction that is not parallel to up");
}

}  // namespace

Picture draw_picture(const TriangleMesh& mesh, std::span<const Point> touches, const PictureOptions& options) {
    check(mesh, touches, options);
    return Painter(mesh, touches, options).paint();
}

void write_picture(const std::filesystem::path& png, const TriangleMesh& mesh, std::span<const Point> touches,
                   const PictureOptions& options) {
    write_png(png, draw_picture(mesh, touches, options));
}

}  // namespace palpate
