// Places on a grid that is seen: the picture's samples, or the texels of a shadow map.
//
// Notation: a *sample* is one of the supersampling² places of a pixel. *Nearness* grows towards the viewer and is affine
// on the screen: 1/z in perspective, -z in parallel projection, so that it may be interpolated linearly.
#pragma once

#include <cstddef>
#include <limits>

namespace palpate {

struct Screen {
    double x = 0.0;  // samples, rightwards
    double y = 0.0;  // samples, downwards
    double nearness = 0.0;
};

inline constexpr float kNowhere = -std::numeric_limits<float>::infinity();  // the nearness where nothing is seen

// In a grid that is stored row by row.
[[nodiscard]] constexpr std::size_t place_in_grid(int column, int row, int columns) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
}

// Between four places of a grid, at `fx` of the way to the right and `fy` downwards.
template <class Value>
[[nodiscard]] Value bilinear(float fx, float fy, const Value& upper_left, const Value& upper_right, const Value& lower_left,
                             const Value& lower_right) {
    return (1.0F - fy) * ((1.0F - fx) * upper_left + fx * upper_right) + fy * ((1.0F - fx) * lower_left + fx * lower_right);
}

}  // namespace palpate
