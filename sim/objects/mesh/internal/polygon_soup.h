// Faces as a mesh file lists them: polygons that name points, and nothing about how they hang together.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Up to here areas, volumes and their sums are finite numbers. Likewise no mesh is smaller than the inverse.
inline constexpr double kLargestCoordinate = 1e100;

struct PolygonSoup {
    std::vector<Point> points;  // in the file's unit, each coordinate at most kLargestCoordinate
    std::vector<std::vector<std::uint32_t>> polygons;
};

}  // namespace palpate
