// Parts as people make them, at random: thin, sharp, planar, with slots and holes about as wide as epsilon.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planner/geometry.h"
#include "planner/region.h"

namespace palpate {

struct RandomPart {
    std::string kind;
    TriangleMesh mesh;               // closed, oriented outwards; about 1 mm large
    double feature = 0.0;            // mm: its thinnest wall or narrowest gap; 0 if it has an edge so sharp that it has none
    std::vector<Segment> seed_rays;  // empty, or one for every component
    double epsilon = 0.0;            // mm: the middle one of those that it is to be probed with
};

// Same seed, same part. The kinds take turns.
[[nodiscard]] RandomPart random_part(std::uint64_t seed);

}  // namespace palpate
