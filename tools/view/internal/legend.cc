#include "tools/view/internal/legend.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "tools/view/internal/colour.h"
#include "tools/view/internal/lettering.h"
#include "tools/view/internal/screen.h"

namespace palpate {

namespace {

constexpr double kSize = 0.019;     // of the picture's height: letters
constexpr double kLeastPx = 5.0;    // nobody reads smaller ones
constexpr double kSwatch = 0.8;     // of the letters' size: a side
constexpr double kSwatchGap = 0.4;  // between swatch and text
constexpr double kEntryGap = 1.4;   // between entries
constexpr double kFilled = 0.96;    // of the picture's width, at most
const Colour kInk{0.03F, 0.035F, 0.045F};

struct Row {
    double size_px = 0.0;
    std::vector<Lettering> texts{};
    double width_px = 0.0;
};

Row row_of(const std::vector<LegendEntry>& entries, double size_px) {
    Row row{size_px};
    for (const LegendEntry& entry : entries) {
        row.texts.push_back(letter(entry.text, size_px));
        row.width_px += row.texts.back().width_px + (kSwatch + kSwatchGap) * size_px;
    }
    row.width_px += kEntryGap * size_px * static_cast<double>(entries.size() - 1);
    return row;
}

// Puts so much of a colour over a pixel, if there is one.
void blend(Picture& picture, int x, int y, const Colour& colour, float cover) {
    if (x < 0 || y < 0 || x >= picture.width_px || y >= picture.height_px) return;
    std::uint8_t* const rgb = &picture.rgb[3 * place_in_grid(x, y, picture.width_px)];
    const Colour mixed = (1.0F - cover) * from_srgb({rgb[0], rgb[1], rgb[2]}) + cover * colour;
    for (int k = 0; k < 3; ++k) rgb[k] = to_srgb(mixed[k]);
}

}  // namespace

void draw_legend(Picture& picture, const std::vector<LegendEntry>& entries, double room_px) {
    if (entries.empty()) return;
    Row row = row_of(entries, std::max(kLeastPx, kSize * picture.height_px));
    const double room = kFilled * picture.width_px;
    if (row.width_px > room) row = row_of(entries, std::max(kLeastPx, std::floor(row.size_px * room / row.width_px)));

    const double middle = picture.height_px - 0.5 * room_px;
    const int side = static_cast<int>(std::lround(kSwatch * row.size_px));
    double x = 0.5 * (picture.width_px - row.width_px);
    for (std::size_t k = 0; k < entries.size(); ++k) {
        const Colour colour = from_srgb(entries[k].colour);
        const int left = static_cast<int>(std::lround(x));
        const int top = static_cast<int>(std::lround(middle - 0.5 * side));
        for (int i = 0; i < side; ++i) {
            for (int j = 0; j < side; ++j) blend(picture, left + i, top + j, colour, 1.0F);
        }
        x += (kSwatch + kSwatchGap) * row.size_px;
        const Lettering& text = row.texts[k];
        const int text_left = static_cast<int>(std::lround(x));
        // The swatch stands on the baseline.
        const int text_top = top + side - text.ascent_px;
        for (int i = 0; i < text.width_px; ++i) {
            for (int j = 0; j < text.height_px; ++j) {
                blend(picture, text_left + i, text_top + j, kInk, text.cover[place_in_grid(i, j, text.width_px)]);
            }
        }
        x += text.width_px + kEntryGap * row.size_px;
    }
}

}  // namespace palpate
