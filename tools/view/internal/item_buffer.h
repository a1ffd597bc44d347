// What is nearest to the viewer at each sample of a strip of the screen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planner/geometry.h"
#include "tools/view/internal/camera.h"
#include "tools/view/internal/rasterizer.h"
#include "tools/view/internal/screen.h"

namespace palpate {

inline constexpr std::int32_t kBackground = -1;

// Items are numbers ≥ 0 that the caller gives. Of equally near ones the first that was drawn stays. A strip at a time, because the samples
// of a whole picture do not fit any cache.
class ItemBuffer {
public:
    // Forgets all, and is about this strip now.
    void clear(const Strip& strip);

    void draw_triangle(const std::array<Screen, 3>& corners, std::int32_t item);
    // A ball, a little before its point so that the surface around does not swallow it. `radius` in mm.
    void draw_ball(const Camera& camera, const Point& point, double radius, std::int32_t item);

    // The items, or kBackground, at so many samples of a row.
    [[nodiscard]] std::span<const std::int32_t> run(int x, int y, int count) const {
        return {&items_[place(x, y)], static_cast<std::size_t>(count)};
    }

private:
    [[nodiscard]] std::size_t place(int x, int y) const { return place_in_grid(x, y - strip_.first_row, strip_.columns); }
    void put(std::size_t place, double nearness, std::int32_t item);

    Strip strip_;
    std::vector<float> nearest_;
    std::vector<std::int32_t> items_;
};

}  // namespace palpate
