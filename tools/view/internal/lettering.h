// A line of text as what it covers of pixels.
#pragma once

#include <string>
#include <vector>

namespace palpate {

// Row by row from the top left, 0 to 1. The baseline is the lower edge of row `ascent_px` - 1; what is below is for letters that reach
// there.
struct Lettering {
    int width_px = 0;
    int height_px = 0;
    int ascent_px = 0;
    std::vector<float> cover;
};

// `size_px`: of the font, from line to line; > 0. `text`: UTF-8; what is none is left out.
[[nodiscard]] Lettering letter(const std::string& text, double size_px);

}  // namespace palpate
