// The light that falls on the surface, gathered at few places: between them it varies slowly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "planner/geometry.h"
#include "tools/view/internal/colour.h"
#include "tools/view/internal/lights.h"
#include "tools/view/internal/screen.h"
#include "tools/view/internal/seen_mesh.h"
#include "tools/view/internal/shadow_map.h"

namespace palpate {

// Records at the corners of square cells of pixels: large ones where the surface is smooth, down to single pixels where it is not.
class IrradianceCache {
public:
    // What a pixel shows of the surface, or nothing.
    using SurfaceAt = std::function<std::optional<SurfacePoint>(int px, int py)>;

    IrradianceCache(int width_px, int height_px, const SurfaceAt& surface);

    void add(const Light& light, const ShadowMap& shadow);
    void add_bounce(const Vector& up);

    // At a pixel that shows the surface.
    [[nodiscard]] Colour at(int px, int py) const;

private:
    static constexpr std::int32_t kNone = -1;

    struct Record {
        SurfacePoint surface;
        Colour light = Colour::Zero();
    };
    void divide(const SurfaceAt& surface, int px, int py, int size);
    // These two are false if there is a place without surface, or outside the picture.
    bool add_corners(const SurfaceAt& surface, int px, int py, int size);
    bool add_record(const SurfaceAt& surface, int px, int py);
    [[nodiscard]] bool is_smooth(int px, int py, int size) const;
    [[nodiscard]] const Record& record(int px, int py) const {
        return records_[static_cast<std::size_t>(record_of_[place_in_grid(px, py, width_px_)])];
    }

    int width_px_, height_px_;
    std::vector<std::int32_t> record_of_;  // per pixel: in records_, or kNone
    std::vector<std::uint8_t> cell_px_;    // per pixel: the side of the cell that it is in
    std::vector<Record> records_;
};

}  // namespace palpate
