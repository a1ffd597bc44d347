#include "tools/view/internal/fragments.h"

#include <algorithm>
#include <cstddef>

namespace palpate {

Fragments::Fragments(int width_px, int height_px, int supersampling) : width_px_(width_px), supersampling_(supersampling) {
    starts_.reserve(place_in_grid(0, height_px, width_px) + 1);
    starts_.push_back(0);
}

void Fragments::append_row(const ItemBuffer& items, int py) {
    const int n = supersampling_;
    for (int px = 0; px < width_px_; ++px) {
        const std::size_t first = fragments_.size();
        Fragment last;  // neighbours mostly show the same
        for (int y = py * n; y < (py + 1) * n; ++y) {
            for (const std::int32_t item : items.run(px * n, y, n)) {
                if (item != last.item) {
                    add(last, first);
                    last = {item, 0};
                }
                ++last.samples;
            }
        }
        add(last, first);
        starts_.push_back(static_cast<std::uint32_t>(fragments_.size()));
    }
}

void Fragments::add(const Fragment& more, std::size_t first) {
    if (more.item == kBackground) return;
    const auto same = std::find_if(fragments_.begin() + static_cast<std::ptrdiff_t>(first), fragments_.end(),
                                   [&more](const Fragment& f) { return f.item == more.item; });
    if (same == fragments_.end()) {
        fragments_.push_back(more);
    } else {
        same->samples += more.samples;
    }
}

}  // namespace palpate
