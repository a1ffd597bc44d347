// A surface as seen from above, on a grid: what programs that level a milling path read.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct HeightMap {
    std::array<double, 2> min{};                 // x, y in mm, of the first node
    std::array<double, 2> max{};                 // of the last
    std::array<std::size_t, 2> nodes{};          // along x and y; two at least
    std::vector<std::optional<double>> heights;  // mm, x fastest; none where nothing is below

    [[nodiscard]] double x(std::size_t i) const { return at(0, i); }
    [[nodiscard]] double y(std::size_t j) const { return at(1, j); }
    [[nodiscard]] const std::optional<double>& height(std::size_t i, std::size_t j) const { return heights[j * nodes[0] + i]; }
    [[nodiscard]] std::size_t missing() const;

private:
    [[nodiscard]] double at(std::size_t axis, std::size_t k) const {
        return min.at(axis) + static_cast<double>(k) / static_cast<double>(nodes.at(axis) - 1) * (max.at(axis) - min.at(axis));
    }
};

// The highest place of the mesh at each node. `step`: nodes are no farther apart. Throws std::invalid_argument where the window is empty,
// or has more than 10 million nodes.
[[nodiscard]] HeightMap height_map(const TriangleMesh& mesh, const std::array<double, 2>& min, const std::array<double, 2>& max,
                                   double step);

// With all nodes, but for OpenCNCPilot's, which may lack some. REQUIRES: missing() is 0.
[[nodiscard]] std::string to_bcnc(const HeightMap& map, double feed_mm_per_min);  // .probe
[[nodiscard]] std::string to_ugs(const HeightMap& map);                           // .xyz of Universal G-code Sender, y fastest
[[nodiscard]] std::string to_candle(const HeightMap& map);                        // .map
[[nodiscard]] std::string to_opencncpilot(const HeightMap& map);                  // .hmap

}  // namespace palpate
