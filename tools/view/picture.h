// A picture of a mesh and its touches, drawn in software: the same bytes on every machine with or without a screen.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// What a colour means.
struct LegendEntry {
    std::array<std::uint8_t, 3> colour{};  // sRGB
    std::string text{};                    // UTF-8
};

struct PictureOptions {
    Vector view_direction{1.0, -1.8, 1.0};  // from the object towards the viewer; any length > 0
    Vector up = Vector::UnitZ();            // not parallel to view_direction
    int width_px = 1200;
    int height_px = 1200;
    int supersampling = 3;    // samples per pixel along each axis, 1 to 8
    bool perspective = true;  // otherwise parallel
    double margin = 0.08;     // of each side of the picture, in [0, 0.5): the mesh fills the rest in one direction at least
    bool edges = true;        // fine dark lines along the triangles' edges; they fade where triangles are tiny
    bool ground = true;       // a soft shadow on a floor below the mesh, where the view is from above
    std::vector<std::array<std::uint8_t, 3>> triangle_colours{};  // sRGB, by triangle; none: all the same
    std::vector<LegendEntry> legend{};  // in a row in the lower margin; it gets smaller letters than usual where they would not fit
    double touch_radius = 0.13;         // of the median length of edges, ≥ 0: touches are balls around their points, never large ones
};

struct Picture {
    int width_px = 0;
    int height_px = 0;
    std::vector<std::uint8_t> rgb;  // sRGB, row by row from the top left
};

// Triangles hide what is behind them, also touches. Backs of triangles are drawn like fronts.
// Throws std::invalid_argument on a mesh without triangles or extent, an index or coordinate that is none, and options out
// of their ranges.
[[nodiscard]] Picture draw_picture(const TriangleMesh& mesh, std::span<const Point> touches, const PictureOptions& options = {});

}  // namespace palpate
