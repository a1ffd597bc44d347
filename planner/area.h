// What of ω is to be probed, where that is not all of it (planner/DESIGN.md, "Known solids").
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <variant>
#include <vector>

#include "planner/geometry.h"
#include "planner/known_solids.h"

namespace palpate {

// What lies above or below a polygon, as seen along z, between two heights.
struct Prism {
    std::vector<Eigen::Vector2d> corners;            // mm: x and y, either way around
    std::array<double, 2> z{-1'000'000, 1'000'000};  // mm: from, to
};

// Of places of the tool's reference point.
using Area = std::variant<Box, Prism>;

// What is wrong with the polygon, and what is allowed, as messages of a configuration have it; empty: nothing.
[[nodiscard]] std::string problem_of(const std::vector<Eigen::Vector2d>& corners);

[[nodiscard]] Box bounds_of(const Area& area);

// mm²: as seen along z.
[[nodiscard]] double size_of(const Area& area);

// Deeper than that (mm); a negative depth: or so near to it.
[[nodiscard]] bool is_inside(const Area& area, const Point& p, double depth);

// Convex solids that together are all that lies outside. Those that share a face overlap there by `overlap` (mm, > 0), so that no line runs
// between them. REQUIRES: problem_of() the polygon is empty.
[[nodiscard]] std::vector<KnownSolids::Convex> outside_of(const Area& area, double overlap);

}  // namespace palpate
