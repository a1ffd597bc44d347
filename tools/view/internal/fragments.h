// What each pixel shows: which items, and how many of its samples each of them has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/view/internal/item_buffer.h"

namespace palpate {

struct Fragment {
    std::int32_t item = kBackground;
    int samples = 0;
};

// An A-buffer of what is opaque: of nine samples, most pixels need one fragment.
class Fragments {
public:
    // `supersampling`² samples per pixel.
    Fragments(int width_px, int height_px, int supersampling);

    // Appends the next row of pixels, whose samples are in `items`.
    void append_row(const ItemBuffer& items, int py);

    // Never the background.
    [[nodiscard]] std::span<const Fragment> at(int px, int py) const {
        const std::uint32_t* start = &starts_[place_in_grid(px, py, width_px_)];
        return {&fragments_[start[0]], start[1] - start[0]};
    }

private:
    // To those of the last pixel, which begin at `first`.
    void add(const Fragment& more, std::size_t first);

    int width_px_;
    int supersampling_;
    std::vector<Fragment> fragments_;
    std::vector<std::uint32_t> starts_;  // per pixel, and one more
};

}  // namespace palpate
