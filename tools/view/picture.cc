// Geometry decides what each sample shows, then one light after the other falls on it, then samples become pixels.
#include "tools/view/picture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/view/internal/camera.h"
#include "tools/view/internal/colour.h"
#include "tools/view/internal/floor.h"
#include "tools/view/internal/fragments.h"
#include "tools/view/internal/irradiance_cache.h"
#include "tools/view/internal/item_buffer.h"
#include "tools/view/internal/legend.h"
#include "tools/view/internal/lights.h"
#include "tools/view/internal/screen.h"
#include "tools/view/internal/seen_mesh.h"
#include "tools/view/internal/shadow_map.h"

namespace palpate {

namespace {

constexpr double kMaxSamples = 4e8;
constexpr int kStripPx = 32;  // rows that are drawn at a time
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
          fragments_(options.width_px, options.height_px, options.supersampling) {
        middles_.reserve(place_in_grid(0, options.height_px, options.width_px));
    }
    Painter(const Painter&) = delete;  // seen_ refers to camera_
    Painter& operator=(const Painter&) = delete;

    [[nodiscard]] Picture paint() {
        draw_items();
        gather_light();
        return resolve();
    }

private:
    void draw_items();
    [[nodiscard]] std::optional<SurfacePoint> surface(int px, int py) const;
    void gather_light();
    [[nodiscard]] Colour colour(int px, int py) const;
    [[nodiscard]] Colour surface_colour(std::size_t t, double x, double y) const;
    [[nodiscard]] Colour touch_colour(const Point& touch, double x, double y) const;
    [[nodiscard]] Picture resolve() const;
    [[nodiscard]] bool is_triangle(std::int32_t item) const { return item >= 0 && static_cast<std::size_t>(item) < mesh_.triangles.size(); }
    // Of a pixel, in samples.
    [[nodiscard]] double middle(int px) const { return (px + 0.5) * options_.supersampling; }

    const TriangleMesh& mesh_;
    std::span<const Point> touches_;
    const PictureOptions& options_;
    Vector up_;
    Camera camera_;
    SeenMesh seen_;
    Floor floor_;
    double edge_length_;                 // mm, the median
    double touch_radius_;                // mm
    Fragments fragments_;                // items are triangles, then touches
    std::vector<std::int32_t> middles_;  // per pixel: the item in its middle, without touches
    std::optional<IrradianceCache> irradiance_;
};

void Painter::draw_items() {
    const int n = options_.supersampling;
    ItemBuffer items;
    for (int row = 0; row < options_.height_px; row += kStripPx) {
        const int end = std::min(row + kStripPx, options_.height_px);
        items.clear({options_.width_px * n, row * n, end * n});
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
            items.draw_triangle(seen_.corners(t), static_cast<std::int32_t>(t));
        }
        for (int py = row; py < end; ++py) {
            for (int px = 0; px < options_.width_px; ++px) middles_.push_back(items.run(px * n + n / 2, py * n + n / 2, 1).front());
        }
        for (std::size_t i = 0; i < touches_.size(); ++i) {
            items.draw_ball(camera_, touches_[i], touch_radius_, static_cast<std::int32_t>(mesh_.triangles.size() + i));
        }
        for (int py = row; py < end; ++py) fragments_.append_row(items, py);
    }
}

// In its middle, or else of the triangle that most of its samples show.
std::optional<SurfacePoint> Painter::surface(int px, int py) const {
    Fragment most{middles_[place_in_grid(px, py, options_.width_px)], 0};
    if (most.item == kBackground) {
        for (const Fragment& fragment : fragments_.at(px, py)) {
            if (is_triangle(fragment.item) && fragment.samples > most.samples) most = fragment;
        }
    }
    if (most.item == kBackground) return std::nullopt;
    return seen_.surface(static_cast<std::size_t>(most.item), middle(px), middle(py));
}

// One shadow map at a time over all places.
void Painter::gather_light() {
    irradiance_.emplace(options_.width_px, options_.height_px, [this](int px, int py) { return surface(px, py); });
    const std::vector<Light> lights = studio(camera_, up_);
    const int texels = std::clamp(std::max(options_.width_px, options_.height_px) / 4, kMinShadowTexels, kMaxShadowTexels);
    const auto on_floor = [this](const Light& light) {
        return std::max(0.0F, static_cast<float>(up_.dot(light.direction))) * light.intensity.mean();
    };
    float all_on_floor = 0.0F;
    for (const Light& light : lights) {
        all_on_floor += on_floor(light);
    }
    for (const Light& light : lights) {
        const ShadowMap shadow(mesh_, camera_, light.direction, texels);
        irradiance_->add(light, shadow);
        floor_.shade(shadow, on_floor(light) / all_on_floor);
    }
    irradiance_->add_bounce(up_);
    floor_.soften_shadow();
}

// Before light: the surface's colour, and that of an edge's line where it covers a part of the pixel around this place.
Colour Painter::surface_colour(std::size_t t, double x, double y) const {
    const int n = options_.supersampling;
    const Colour surface = t < options_.triangle_colours.size() ? from_srgb(options_.triangle_colours[t]) : kSurface;
    if (!options_.edges) return surface;
    const double edge_px = edge_length_ * camera_.magnification(seen_.nearness(t)) / n;
    const auto cover = static_cast<float>(std::clamp(kEdgeHalfWidthPx + 0.5 - seen_.edge_distance(t, x, y) / n, 0.0, 1.0));
    const float line = cover * kEdgeOpacity * static_cast<float>(std::min(1.0, edge_px / kEdgeFadePx));
    return (1.0F - line) * surface + line * kEdge;
}

Colour Painter::touch_colour(const Point& touch, double x, double y) const {
    const Screen c = camera_.project(touch);
    const double r = touch_radius_ * camera_.magnification(c.nearness);
    const double lean = (-(x - c.x) - (y - c.y)) / r;  // towards the key light at the upper left
    return (kTouch * static_cast<float>(0.95 + 0.25 * lean)).min(1.0F);
}

// The mean over the pixel's samples.
Colour Painter::colour(int px, int py) const {
    int paper = options_.supersampling * options_.supersampling;
    const auto all = static_cast<float>(paper);
    float surface = 0.0F;
    Colour of_surface = Colour::Zero();
    Colour sum = Colour::Zero();
    for (const auto& [item, samples] : fragments_.at(px, py)) {
        const auto part = static_cast<float>(samples);
        if (is_triangle(item)) {
            of_surface += part * surface_colour(static_cast<std::size_t>(item), middle(px), middle(py));
            surface += part;
        } else {
            sum += part * touch_colour(touches_[static_cast<std::size_t>(item) - mesh_.triangles.size()], middle(px), middle(py));
        }
        paper -= samples;
    }
    if (surface > 0.0F) sum += surface * soften(of_surface / surface * irradiance_->at(px, py));
    if (paper > 0) sum += static_cast<float>(paper) * floor_.paper(px, py);
    return sum / all;
}

Picture Painter::resolve() const {
    Picture picture{options_.width_px, options_.height_px, {}};
    picture.rgb.reserve(3 * middles_.size());
    for (int py = 0; py < options_.height_px; ++py) {
        for (int px = 0; px < options_.width_px; ++px) {
            for (const float channel : colour(px, py)) {
                picture.rgb.push_back(to_srgb(channel));
            }
        }
    }
    return picture;
}

void require(bool condition, const std::string& message) {
    if (!condition) {
        throw std::invalid_argument(fmt::format("picture: {}", message));
    }
}

void check(const TriangleMesh& mesh, std::span<const Point> touches, const PictureOptions& options) {
    require(!mesh.triangles.empty(), "the mesh has no triangles");
    Eigen::AlignedBox3d box;
    for (const auto& triangle : mesh.triangles) {
        for (const auto i : triangle) {
            require(i < mesh.points.size(), fmt::format("a triangle has vertex {} of {}", i, mesh.points.size()));
            require(mesh.points[i].allFinite(), fmt::format("vertex {} is not finite", i));
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
    Picture picture = Painter(mesh, touches, options).paint();
    draw_legend(picture, options.legend, options.margin * options.height_px);
    return picture;
}

}  // namespace palpate
