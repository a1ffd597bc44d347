// What the colours of a picture mean, in a row along its lower edge.
#pragma once

#include <vector>

#include "tools/view/picture.h"

namespace palpate {

// Draws over what is there, in the middle of the lowest `room_px` rows. Smaller letters than usual where the picture is narrow.
void draw_legend(Picture& picture, const std::vector<LegendEntry>& entries, double room_px);

}  // namespace palpate
