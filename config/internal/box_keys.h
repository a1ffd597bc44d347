// The corners of boxes along the axes.
#pragma once

#include <string_view>

#include "config/internal/kinds.h"
#include "planner/geometry.h"

namespace palpate::yaml {

template <class Archive>
void describe_corners(Archive& keys, std::string_view meaning_of_min, std::string_view meaning_of_max, Box& box) {
    keys.value({"min", meaning_of_min, Need::required, kMillimetres}, box.min, Triple{Number{kCoordinate}});
    keys.value({"max", meaning_of_max, Need::required, kMillimetres}, box.max, Triple{Number{kCoordinate}});
}

// Of a box with an inside.
template <class Archive>
void describe_box(Archive& keys, std::string_view meaning_of_min, std::string_view meaning_of_max, Box& box) {
    describe_corners(keys, meaning_of_min, meaning_of_max, box);
    keys.require(box.is_valid(), "max", "is not greater than min in each coordinate; allowed: greater than min in x, y and z (mm)");
}

}  // namespace palpate::yaml
