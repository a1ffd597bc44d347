// Fixtures by kind, exactly as they are given: nothing is grown.
#pragma once

#include <vector>

#include "planner/fixtures.h"

namespace palpate {

[[nodiscard]] inline std::vector<HalfSpace> half_spaces_of(const std::vector<Fixture>& fixtures) {
    std::vector<HalfSpace> half_spaces;
    for (const Fixture& fixture : fixtures) {
        if (const auto* table = std::get_if<Table>(&fixture)) half_spaces.push_back({Point(0, 0, table->z), Vector::UnitZ()});
        if (const auto* half = std::get_if<HalfSpace>(&fixture)) half_spaces.push_back(*half);
    }
    return half_spaces;
}

[[nodiscard]] inline std::vector<Box> boxes_of(const std::vector<Fixture>& fixtures) {
    std::vector<Box> boxes;
    for (const Fixture& fixture : fixtures) {
        if (const auto* box = std::get_if<Box>(&fixture)) boxes.push_back(*box);
    }
    return boxes;
}

}  // namespace palpate
