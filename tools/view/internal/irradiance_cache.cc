#include "tools/view/internal/irradiance_cache.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate {

namespace {

constexpr int kLargestCellPx = 8;       // a power of two
constexpr double kSmoothCosine = 0.95;  // of 18°
constexpr double kSmoothSine = 0.31;

// The normals differ little, and the way to the other point leaves the surface no more steeply: otherwise there is a gap between them.
bool continues(const SurfacePoint& a, const SurfacePoint& b) {
    const Vector between = b.position - a.position;
    return a.normal.dot(b.normal) >= kSmoothCosine && std::abs(between.dot(a.normal)) <= kSmoothSine * between.norm();
}

}  // namespace

IrradianceCache::IrradianceCache(int width_px, int height_px, const SurfaceAt& surface)
    : width_px_(width_px), height_px_(height_px), record_of_(place_in_grid(0, height_px, width_px), kNone), cell_px_(record_of_.size(), 1) {
    for (int py = 0; py < height_px; py += kLargestCellPx) {
        for (int px = 0; px < width_px; px += kLargestCellPx) divide(surface, px, py, kLargestCellPx);
    }
}

void IrradianceCache::divide(const SurfaceAt& surface, int px, int py, int size) {
    if (px >= width_px_ || py >= height_px_) return;
    if (size == 1) {
        add_record(surface, px, py);
        return;
    }
    if (add_corners(surface, px, py, size) && is_smooth(px, py, size)) {
        for (int y = py; y < py + size; ++y) std::fill_n(&cell_px_[place_in_grid(px, y, width_px_)], size, static_cast<std::uint8_t>(size));
        return;
    }
    const int half = size / 2;
    for (const int y : {py, py + half}) {
        for (const int x : {px, px + half}) divide(surface, x, y, half);
    }
}

bool IrradianceCache::add_corners(const SurfaceAt& surface, int px, int py, int size) {
    return px + size < width_px_ && py + size < height_px_ && add_record(surface, px, py) && add_record(surface, px + size, py) &&
           add_record(surface, px, py + size) && add_record(surface, px + size, py + size);
}

bool IrradianceCache::is_smooth(int px, int py, int size) const {
    const SurfacePoint& upper_left = record(px, py).surface;
    const SurfacePoint& upper_right = record(px + size, py).surface;
    const SurfacePoint& lower_left = record(px, py + size).surface;
    const SurfacePoint& lower_right = record(px + size, py + size).surface;
    return continues(upper_left, upper_right) && continues(upper_left, lower_left) && continues(lower_right, upper_right) &&
           continues(lower_right, lower_left);
}

bool IrradianceCache::add_record(const SurfaceAt& surface, int px, int py) {
    std::int32_t& record = record_of_[place_in_grid(px, py, width_px_)];
    if (record != kNone) return true;
    const std::optional<SurfacePoint> point = surface(px, py);
    if (!point) return false;
    record = static_cast<std::int32_t>(records_.size());
    records_.push_back({*point});
    return true;
}

void IrradianceCache::add(const Light& light, const ShadowMap& shadow) {
    for (Record& record : records_) {
        if (const auto cosine = static_cast<float>(record.surface.normal.dot(light.direction)); cosine > 0.0F) {
            record.light += cosine * shadow.lit(record.surface.position, record.surface.normal) * light.intensity;
        }
    }
}

void IrradianceCache::add_bounce(const Vector& up) {
    for (Record& record : records_) record.light += bounce(record.surface.normal, up);
}

Colour IrradianceCache::at(int px, int py) const {
    const int size = cell_px_[place_in_grid(px, py, width_px_)];
    const int x = px & ~(size - 1);
    const int y = py & ~(size - 1);
    if (px == x && py == y) return record(x, y).light;
    const float fx = static_cast<float>(px - x) / static_cast<float>(size);
    const float fy = static_cast<float>(py - y) / static_cast<float>(size);
    return bilinear(fx, fy, record(x, y).light, record(x + size, y).light, record(x, y + size).light, record(x + size, y + size).light);
}

}  // namespace palpate
