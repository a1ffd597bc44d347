// Notation: a *sample* is one of the supersampling² places of a pixel. *Nearness* grows towards the viewer and is affine
// on the screen: 1/z in perspective, -z in parallel projection, so that it may be interpolated linearly.
#include "tools/picture.h"

#include <png.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate {

namespace {

using Colour = Eigen::Array3f;  // linear light

// In a grid that is stored row by row.
std::size_t place_in_grid(int column, int row, int columns) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
}

constexpr double kFieldOfView = 24.0 * std::numbers::pi / 180.0;  // a portrait lens
constexpr double kCreaseCosine = 0.6;                             // sharper dihedral angles than 53° are drawn as edges of the solid
constexpr double kMaxSamples = 4e8;                               // 8 bytes each
constexpr int kSky = 72;                                          // lights
constexpr int kMinShadowTexels = 64;
constexpr int kMaxShadowTexels = 1024;
constexpr float kNowhere = -std::numeric_limits<float>::infinity();
constexpr std::int32_t kBackground = -1;

// Colours and light were chosen by eye.
const Colour kSurface{0.30F, 0.41F, 0.60F};
const Colour kEdge{0.035F, 0.05F, 0.085F};
const Colour kTouch{0.90F, 0.075F, 0.012F};
const Colour kPaper{0.985F, 0.985F, 0.985F};
constexpr float kEdgeOpacity = 0.55F;
constexpr double kEdgeHalfWidthPx = 0.45;
constexpr double kEdgeFadePx = 14.0;        // the lines of shorter median edges fade
const Colour kBounce{0.26F, 0.25F, 0.25F};  // what a bright floor sends back up
constexpr float kGroundShadow = 0.7F;
constexpr double kMaxTouchRadius = 0.025;  // of the mesh's
constexpr float kFadingBorder = 0.2F;      // of the width
constexpr int kFloorStepPx = 4;            // shadows on the floor are soft

struct Screen {
    double x = 0.0;  // samples, rightwards
    double y = 0.0;  // samples, downwards
    double nearness = 0.0;
};

class Camera {
public:
    Camera(const TriangleMesh& mesh, const PictureOptions& options) : perspective_(options.perspective) {
        toward_viewer_ = options.view_direction.normalized();
        right_ = options.up.cross(toward_viewer_).normalized();
        up_ = toward_viewer_.cross(right_);
        Eigen::AlignedBox3d box;
        for (const auto& triangle : mesh.triangles) {
            for (const auto i : triangle) {
                box.extend(mesh.points[i]);
            }
        }
        center_ = box.center();
        radius_ = box.diagonal().norm() / 2.0;
        eye_ = center_ + toward_viewer_ * radius_ / std::sin(kFieldOfView / 2.0);
        fit(mesh, options);
    }

    [[nodiscard]] Screen project(const Point& p) const {
        const Vector d = p - eye_;
        const double depth = -d.dot(toward_viewer_);
        const double w = perspective_ ? 1.0 / depth : 1.0;
        return {shift_x_ + scale_ * w * d.dot(right_), shift_y_ - scale_ * w * d.dot(up_), perspective_ ? w : -depth};
    }
    // Samples per millimetre at a point seen with this nearness.
    [[nodiscard]] double magnification(double nearness) const { return perspective_ ? scale_ * nearness : scale_; }
    [[nodiscard]] double nearness_at(double depth) const { return perspective_ ? 1.0 / depth : -depth; }
    [[nodiscard]] double depth_at(double nearness) const { return perspective_ ? 1.0 / nearness : -nearness; }
    // The weight that makes linear interpolation on the screen linear on the triangle.
    [[nodiscard]] double weight(const Screen& s) const { return perspective_ ? s.nearness : 1.0; }

    // Direction of the line of sight through a place on the screen, and a point of it.
    [[nodiscard]] std::pair<Point, Vector> sight(double x, double y) const {
        const Vector across = ((x - shift_x_) * right_ - (y - shift_y_) * up_) / scale_;
        return perspective_ ? std::pair<Point, Vector>{eye_, across - toward_viewer_}
                            : std::pair<Point, Vector>{eye_ + across, -toward_viewer_};
    }

    [[nodiscard]] const Vector& right() const { return right_; }
    [[nodiscard]] const Vector& up() const { return up_; }
    [[nodiscard]] const Vector& toward_viewer() const { return toward_viewer_; }
    [[nodiscard]] const Point& center() const { return center_; }
    [[nodiscard]] double radius() const { return radius_; }

private:
    // Moving and scaling the image plane is exact in both projections.
    void fit(const TriangleMesh& mesh, const PictureOptions& options) {
        Eigen::AlignedBox2d seen;
        for (const auto& triangle : mesh.triangles) {
            for (const auto i : triangle) {
                const Screen s = project(mesh.points[i]);
                seen.extend(Eigen::Vector2d(s.x, s.y));
            }
        }
        const double width = options.width_px * options.supersampling;
        const double height = options.height_px * options.supersampling;
        const Eigen::Vector2d extent = seen.sizes().cwiseMax(1e-12 * radius_);
        scale_ = (1.0 - 2.0 * options.margin) * std::min(width / extent.x(), height / extent.y());
        shift_x_ = width / 2.0 - scale_ * seen.center().x();
        shift_y_ = height / 2.0 - scale_ * seen.center().y();
    }

    bool perspective_;
    Vector toward_viewer_, right_, up_;
    Point center_, eye_;
    double radius_ = 0.0;
    double scale_ = 1.0, shift_x_ = 0.0, shift_y_ = 0.0;
};

double cross(const Screen& a, const Screen& b, const Screen& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Barycentric coordinates of a place on the screen.
Vector barycentric(const std::array<Screen, 3>& t, double x, double y) {
    const Screen p{x, y, 0.0};
    return Vector(cross(p, t[1], t[2]), cross(p, t[2], t[0]), cross(p, t[0], t[1])) / cross(t[0], t[1], t[2]);
}

// Calls visit(x, y, nearness) for each cell of a width × height grid whose centre the triangle covers.
template <class Visit>
void rasterize(const std::array<Screen, 3>& t, int width, int height, const Visit& visit) {
    if (std::abs(cross(t[0], t[1], t[2])) < 1e-12) {
        return;
    }
    const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
    const int last_x = static_cast<int>(std::min(width - 1.0, std::ceil(x1)));
    const int last_y = static_cast<int>(std::min(height - 1.0, std::ceil(y1)));
    const Vector nearness(t[0].nearness, t[1].nearness, t[2].nearness);
    for (int y = static_cast<int>(std::max(0.0, std::floor(y0))); y <= last_y; ++y) {
        const int first_x = static_cast<int>(std::max(0.0, std::floor(x0)));
        Vector b = barycentric(t, first_x + 0.5, y + 0.5);
        const Vector step = barycentric(t, first_x + 1.5, y + 0.5) - b;
        for (int x = first_x; x <= last_x; ++x, b += step) {
            if (b.minCoeff() >= -1e-9) {
                visit(x, y, b.dot(nearness));
            }
        }
    }
}

struct Light {
    Vector direction;  // towards the light
    Colour intensity;
};

// Sends light from a disc of directions around one, by the golden angle.
void add_lamp(std::vector<Light>& lights, const Vector& direction, double spread, int count, const Colour& intensity) {
    const Vector side = direction.unitOrthogonal();
    const Vector other = direction.normalized().cross(side);
    for (int i = 0; i < count; ++i) {
        const double r = spread * std::sqrt((i + 0.5) / count);
        const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
        lights.push_back({(direction.normalized() + r * std::cos(angle) * side + r * std::sin(angle) * other).normalized(),
                          intensity / static_cast<float>(count)});
    }
}

std::vector<Light> studio(const Camera& camera, const Vector& up) {
    std::vector<Light> lights;
    const auto from = [&](double right, double above, double front) {
        return Vector(right * camera.right() + above * camera.up() + front * camera.toward_viewer());
    };
    add_lamp(lights, from(-0.75, 1.0, 0.75), 0.22, 28, Colour(2.30F, 2.16F, 1.98F));  // key
    add_lamp(lights, from(1.2, 0.25, 0.6), 0.35, 12, Colour(0.34F, 0.39F, 0.46F));    // fill
    // The sky: directions evenly spread over the upper half.
    const Vector side = up.unitOrthogonal();
    const Vector other = up.cross(side);
    for (int i = 0; i < kSky; ++i) {
        const double height = (i + 0.5) / kSky;
        const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
        const double r = std::sqrt(1.0 - height * height);
        lights.push_back({height * up + r * std::cos(angle) * side + r * std::sin(angle) * other, Colour(0.98F, 1.04F, 1.14F) / kSky});
    }
    return lights;
}

// How near the light the mesh comes, on a grid across the light's direction.
class ShadowMap {
public:
    ShadowMap(const TriangleMesh& mesh, const Camera& camera, const Vector& direction, int texels)
        : direction_(direction),
          side_(direction.unitOrthogonal()),
          other_(direction.cross(side_)),
          center_(camera.center()),
          texels_(texels),
          texels_per_mm_(texels_ / (2.05 * camera.radius())),
          nearest_(static_cast<std::size_t>(texels) * static_cast<std::size_t>(texels), kNowhere) {
        for (const auto& triangle : mesh.triangles) {
            const std::array<Screen, 3> t{place(mesh.points[triangle[0]]), place(mesh.points[triangle[1]]),
                                          place(mesh.points[triangle[2]])};
            rasterize(t, texels_, texels_, [&](int x, int y, double nearness) {
                float& nearest = nearest_[place_in_grid(x, y, texels_)];
                nearest = std::max(nearest, static_cast<float>(nearness));
            });
        }
    }

    // Part of the light that arrives at `p`, whose surface has normal `n`: 0 to 1, interpolated between grid points. A
    // texel's width of slack on either axis, or else the surface's slope would shade itself.
    [[nodiscard]] float lit(const Point& p, const Vector& n) const {
        const Screen s = place(p + n * (2.0 / texels_per_mm_));
        const double x = s.x - 0.5;
        const double y = s.y - 0.5;
        if (!(x >= 0.0 && y >= 0.0 && x < texels_ - 1 && y < texels_ - 1)) {
            return 1.0F;
        }
        const auto column = static_cast<int>(x);
        const auto row = static_cast<int>(y);
        const auto fx = static_cast<float>(x - std::floor(x));
        const auto fy = static_cast<float>(y - std::floor(y));
        const auto threshold = static_cast<float>(s.nearness + 1.0 / texels_per_mm_);
        const float* at = &nearest_[place_in_grid(column, row, texels_)];
        const auto open = [threshold](float nearest) { return nearest <= threshold ? 1.0F : 0.0F; };
        return (1.0F - fy) * ((1.0F - fx) * open(at[0]) + fx * open(at[1])) +
               fy * ((1.0F - fx) * open(at[texels_]) + fx * open(at[texels_ + 1]));
    }

private:
    [[nodiscard]] Screen place(const Point& p) const {
        const Vector d = p - center_;
        return {texels_ / 2.0 + texels_per_mm_ * d.dot(side_), texels_ / 2.0 + texels_per_mm_ * d.dot(other_), d.dot(direction_)};
    }

    Vector direction_, side_, other_;
    Point center_;
    int texels_;
    double texels_per_mm_;
    std::vector<float> nearest_;
};

Vector triangle_cross(const TriangleMesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
}

// One unit normal per corner: the mean, weighted by area, over the triangles around the vertex that continue smoothly.
std::vector<std::array<Vector, 3>> corner_normals(const TriangleMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> around(mesh.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const auto v : mesh.triangles[t]) {
            around[v].push_back(static_cast<std::uint32_t>(t));
        }
    }
    std::vector<std::array<Vector, 3>> normals(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vector own = triangle_cross(mesh, t).normalized();
        for (std::size_t k = 0; k < 3; ++k) {
            Vector sum = Vector::Zero();
            for (const auto neighbour : around[mesh.triangles[t][k]]) {
                const Vector other = triangle_cross(mesh, neighbour);
                sum += own.dot(other) >= kCreaseCosine * other.norm() ? other : Vector(Vector::Zero());
            }
            normals[t][k] = sum.squaredNorm() > 0.0 ? sum.normalized() : own;
        }
    }
    return normals;
}

double median_edge(const TriangleMesh& mesh) {
    std::vector<double> lengths;
    for (const auto& [a, b, c] : mesh.triangles) {
        for (const double length : {(mesh.points[a] - mesh.points[b]).norm(), (mesh.points[b] - mesh.points[c]).norm(),
                                    (mesh.points[c] - mesh.points[a]).norm()}) {
            lengths.push_back(length);
        }
    }
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
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

class Painter {
public:
    Painter(const TriangleMesh& mesh, std::span<const Point> touches, const PictureOptions& options)
        : mesh_(mesh),
          touches_(touches),
          options_(options),
          camera_(mesh, options),
          normals_(corner_normals(mesh)),
          columns_(options.width_px * options.supersampling),
          rows_(options.height_px * options.supersampling),
          floor_columns_(options.width_px / kFloorStepPx + 2),
          floor_rows_(options.height_px / kFloorStepPx + 2),
          edge_length_(median_edge(mesh)),
          touch_radius_(std::min(options.touch_radius * edge_length_, kMaxTouchRadius * camera_.radius())),
          nearest_(std::size_t(columns_) * std::size_t(rows_), kNowhere),
          seen_(nearest_.size(), kBackground) {
        const Vector up = options.up.normalized();
        double lowest = std::numeric_limits<double>::infinity();
        for (const auto& triangle : mesh.triangles) {
            for (const auto i : triangle) {
                lowest = std::min(lowest, up.dot(mesh.points[i]));
            }
        }
        floor_ = lowest;
        up_ = up;
        std::transform(mesh.points.begin(), mesh.points.end(), std::back_inserter(places_),
                       [this](const Point& p) { return camera_.project(p); });
    }

    [[nodiscard]] Picture paint() {
        draw_triangles();
        draw_touches();
        gather_light();
        return resolve();
    }

private:
    struct Spot {
        Point position = Point::Zero();
        Vector normal = Vector::Zero();
        std::size_t place = 0;  // in light_ or floor_light_
    };

    [[nodiscard]] std::array<Screen, 3> projected(std::size_t t) const {
        const auto& [a, b, c] = mesh_.triangles[t];
        return {places_[a], places_[b], places_[c]};
    }
    [[nodiscard]] std::size_t sample(int x, int y) const { return place_in_grid(x, y, columns_); }

    void put(int x, int y, double nearness, std::size_t id) {
        const std::size_t i = sample(x, y);
        if (static_cast<float>(nearness) > nearest_[i]) {
            nearest_[i] = static_cast<float>(nearness);
            seen_[i] = static_cast<std::int32_t>(id);
        }
    }

    void draw_triangles() {
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
            rasterize(projected(t), columns_, rows_, [&](int x, int y, double nearness) { put(x, y, nearness, t); });
        }
    }

    // Balls, a little before their points so that the surface around does not swallow them.
    void draw_touches() {
        const double radius = touch_radius_;
        for (std::size_t i = 0; i < touches_.size(); ++i) {
            const Screen c = camera_.project(touches_[i]);
            const double r = radius * camera_.magnification(c.nearness);
            const double depth = camera_.depth_at(c.nearness);
            for (int y = std::max(0, static_cast<int>(c.y - r)); y <= std::min(rows_ - 1, static_cast<int>(c.y + r)); ++y) {
                for (int x = std::max(0, static_cast<int>(c.x - r)); x <= std::min(columns_ - 1, static_cast<int>(c.x + r)); ++x) {
                    const double dx = (x + 0.5 - c.x) / r;
                    const double dy = (y + 0.5 - c.y) / r;
                    const double square = dx * dx + dy * dy;
                    if (square < 1.0) {
                        put(x, y, camera_.nearness_at(depth - radius * (std::sqrt(1.0 - square) + 0.35)), mesh_.triangles.size() + i);
                    }
                }
            }
        }
    }

    [[nodiscard]] bool is_triangle(std::int32_t id) const { return id >= 0 && static_cast<std::size_t>(id) < mesh_.triangles.size(); }

    // Where the surface is under a sample, and its normal on the viewer's side.
    [[nodiscard]] Spot spot(std::size_t t, double x, double y) const {
        const std::array<Screen, 3> corners = projected(t);
        Vector b = barycentric(corners, x, y);
        b = b.cwiseProduct(Vector(camera_.weight(corners[0]), camera_.weight(corners[1]), camera_.weight(corners[2])));
        b /= b.sum();
        Spot spot;
        for (std::size_t k = 0; k < 3; ++k) {
            spot.position += b[static_cast<Eigen::Index>(k)] * mesh_.points[mesh_.triangles[t][k]];
            spot.normal += b[static_cast<Eigen::Index>(k)] * normals_[t][k];
        }
        spot.normal.normalize();
        if (triangle_cross(mesh_, t).dot(camera_.sight(x, y).second) > 0.0) {
            spot.normal = -spot.normal;
        }
        return spot;
    }

    [[nodiscard]] std::vector<Spot> surface_spots() const;
    [[nodiscard]] std::vector<Spot> floor_spots() const;
    void gather_light();
    [[nodiscard]] Colour paper(int px, int py) const;
    [[nodiscard]] Colour colour(int x, int y) const;
    [[nodiscard]] float edge_cover(std::size_t t, double x, double y) const;
    [[nodiscard]] Picture resolve() const;
    [[nodiscard]] std::size_t pixel(int px, int py) const { return place_in_grid(px, py, options_.width_px); }

    const TriangleMesh& mesh_;
    std::span<const Point> touches_;
    const PictureOptions& options_;
    Camera camera_;
    std::vector<std::array<Vector, 3>> normals_;
    std::vector<Screen> places_;      // of the mesh's points
    int columns_, rows_;              // of samples
    int floor_columns_, floor_rows_;  // of a grid with a place at every kFloorStepPx-th pixel, and one more
    double edge_length_;              // mm, the median
    double touch_radius_;             // mm
    double floor_ = 0.0;
    Vector up_;
    std::vector<float> nearest_;      // per sample
    std::vector<std::int32_t> seen_;  // per sample: a triangle, then touches, or kBackground
    std::vector<Colour> light_;       // per pixel: what falls on the surface there
    std::vector<float> floor_light_;  // per place: the part of all light that falls on the floor there
};

// The places of the surface that pixels show, one per pixel: light varies slowly.
std::vector<Painter::Spot> Painter::surface_spots() const {
    const int n = options_.supersampling;
    std::vector<Spot> spots;
    for (int i = 0; i < columns_ * rows_ / (n * n); ++i) {
        // The sample in the middle speaks for its pixel, or any other on the surface.
        for (int k = 0; k < n * n; ++k) {
            const int m = (k + n * n / 2) % (n * n);
            const int x = i % options_.width_px * n + m % n;
            const int y = i / options_.width_px * n + m / n;
            if (const std::int32_t id = seen_[sample(x, y)]; is_triangle(id)) {
                spots.push_back(spot(static_cast<std::size_t>(id), x + 0.5, y + 0.5));
                spots.back().place = static_cast<std::size_t>(i);
                break;
            }
        }
    }
    return spots;
}

// The places of the floor behind a coarser grid, also those that the object hides: they matter to blurring.
std::vector<Painter::Spot> Painter::floor_spots() const {
    std::vector<Spot> spots;
    for (int i = 0; options_.ground && i < floor_columns_ * floor_rows_; ++i) {
        const double step = kFloorStepPx * options_.supersampling;
        const int column = i % floor_columns_;
        const int row = i / floor_columns_;
        const auto [origin, direction] = camera_.sight(column * step, row * step);
        const double t = (floor_ - up_.dot(origin)) / up_.dot(direction);
        if (up_.dot(direction) < -1e-6 * direction.norm() && t > 0.0) {
            spots.push_back({origin + t * direction, up_, static_cast<std::size_t>(i)});
        }
    }
    return spots;
}

// One shadow map at a time over all places.
void Painter::gather_light() {
    light_.assign(static_cast<std::size_t>(options_.width_px) * static_cast<std::size_t>(options_.height_px), Colour::Zero());
    floor_light_.assign(static_cast<std::size_t>(floor_columns_) * static_cast<std::size_t>(floor_rows_), 1.0F);
    const std::vector<Spot> surface = surface_spots();
    const std::vector<Spot> floor = floor_spots();
    const std::vector<Light> lights = studio(camera_, up_);
    const int texels = std::clamp(std::max(options_.width_px, options_.height_px) / 2, kMinShadowTexels, kMaxShadowTexels);
    float all_on_floor = 0.0F;
    for (const Light& light : lights) {
        all_on_floor += std::max(0.0F, static_cast<float>(up_.dot(light.direction))) * light.intensity.mean();
    }
    for (const Light& light : lights) {
        const ShadowMap shadow(mesh_, camera_, light.direction, texels);
        for (const Spot& spot : surface) {
            if (const auto cosine = static_cast<float>(spot.normal.dot(light.direction)); cosine > 0.0F) {
                light_[spot.place] += cosine * shadow.lit(spot.position, spot.normal) * light.intensity;
            }
        }
        const float on_floor = std::max(0.0F, static_cast<float>(up_.dot(light.direction))) * light.intensity.mean() / all_on_floor;
        for (const Spot& spot : floor) {
            floor_light_[spot.place] -= on_floor * (1.0F - shadow.lit(spot.position, up_));
        }
    }
    for (const Spot& spot : surface) {
        light_[spot.place] += kBounce * static_cast<float>(0.5 - 0.5 * spot.normal.dot(up_));
    }
    blur(floor_light_, floor_columns_, floor_rows_, std::max(1, floor_columns_ / 80));
}

// Between the four nearest places of the floor's grid.
Colour Painter::paper(int px, int py) const {
    const int x = px / kFloorStepPx;
    const int y = py / kFloorStepPx;
    const float fx = static_cast<float>(px % kFloorStepPx) / kFloorStepPx;
    const float fy = static_cast<float>(py % kFloorStepPx) / kFloorStepPx;
    const auto at = [&](int dx, int dy) { return floor_light_[place_in_grid(x + dx, y + dy, floor_columns_)]; };
    const float light = (1.0F - fy) * ((1.0F - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1.0F - fx) * at(0, 1) + fx * at(1, 1));
    // The picture's border cuts no shadow: it fades before.
    const auto fade = [](int place, int size) {
        const float t = std::min(1.0F, static_cast<float>(std::min(place, size - 1 - place)) / (kFadingBorder * static_cast<float>(size)));
        return t * t * (3.0F - 2.0F * t);
    };
    return kPaper * (1.0F - kGroundShadow * fade(px, options_.width_px) * fade(py, options_.height_px) * (1.0F - light));
}

// How much of a sample an edge's line covers, 0 to 1, softened over a pixel.
float Painter::edge_cover(std::size_t t, double x, double y) const {
    const std::array<Screen, 3> corners = projected(t);
    const Vector b = barycentric(corners, x, y);
    const double area = std::abs(cross(corners[0], corners[1], corners[2]));
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Screen& from = corners[(k + 1) % 3];
        const Screen& to = corners[(k + 2) % 3];
        distance = std::min(distance, b[static_cast<Eigen::Index>(k)] * area / std::hypot(to.x - from.x, to.y - from.y));
    }
    return static_cast<float>(std::clamp(kEdgeHalfWidthPx + 0.5 - distance / options_.supersampling, 0.0, 1.0));
}

// Keeps bright places from burning out.
Colour soften(const Colour& light) { return 1.0F - (-light).exp(); }

Colour Painter::colour(int x, int y) const {
    const int n = options_.supersampling;
    const std::int32_t id = seen_[sample(x, y)];
    if (id == kBackground) {
        return paper(x / n, y / n);
    }
    const Colour& light = light_[pixel(x / n, y / n)];
    if (!is_triangle(id)) {
        const Screen c = camera_.project(touches_[static_cast<std::size_t>(id) - mesh_.triangles.size()]);
        const double r = touch_radius_ * camera_.magnification(c.nearness);
        const double lean = (-(x + 0.5 - c.x) - (y + 0.5 - c.y)) / r;  // towards the key light at the upper left
        return kTouch * static_cast<float>(0.95 + 0.25 * lean);
    }
    const double edge_px = edge_length_ * camera_.magnification(nearest_[sample(x, y)]) / n;
    const float opacity = options_.edges ? kEdgeOpacity * static_cast<float>(std::min(1.0, edge_px / kEdgeFadePx)) : 0.0F;
    const float line = opacity > 0.0F ? opacity * edge_cover(static_cast<std::size_t>(id), x + 0.5, y + 0.5) : 0.0F;
    return soften(((1.0F - line) * kSurface + line * kEdge) * light);
}

std::uint8_t to_srgb(float linear) {
    const float c = std::clamp(linear, 0.0F, 1.0F);
    const float encoded = c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1.0F / 2.4F) - 0.055F;
    return static_cast<std::uint8_t>(std::lround(255.0F * encoded));
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
    const Picture picture = draw_picture(mesh, touches, options);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.format = PNG_FORMAT_RGB;
    image.width = static_cast<png_uint_32>(picture.width_px);
    image.height = static_cast<png_uint_32>(picture.height_px);
    if (png_image_write_to_file(&image, png.c_str(), 0, picture.rgb.data(), 0, nullptr) == 0) {
        throw std::runtime_error("cannot write the picture " + png.string() + ": " + image.message);
    }
}

}  // namespace palpate
