#include "tools/formats/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

namespace palpate {
namespace {

constexpr double kMostNodes = 1e7;

// Which nodes of an axis lie between two places.
struct NodeRange {
    std::size_t begin = 0;
    std::size_t end = 0;  // one past
};

NodeRange nodes_between(const HeightMap& map, std::size_t axis, double low, double high) {
    const double pitch = (map.max.at(axis) - map.min.at(axis)) / static_cast<double>(map.nodes.at(axis) - 1);
    // A node on the rim may be rounded to either side: whether it lies within is asked later.
    const double first = std::floor((low - map.min.at(axis)) / pitch);
    const double last = std::ceil((high - map.min.at(axis)) / pitch);
    const double most = static_cast<double>(map.nodes.at(axis) - 1);
    if (last < 0 || first > most) return {};
    return {static_cast<std::size_t>(std::max(first, 0.0)), static_cast<std::size_t>(std::min(last, most)) + 1};
}

double cross(const Point& a, const Point& b, double x, double y) { return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x()); }

// Twice the triangle's area as seen from above, and those of its parts at (x, y): its height there, if it covers that.
std::optional<double> height_of(const Point& a, const Point& b, const Point& c, double x, double y) {
    const double area = cross(a, b, c.x(), c.y());
    if (area == 0) return std::nullopt;
    const double u = cross(b, c, x, y) / area;
    const double v = cross(c, a, x, y) / area;
    const double w = cross(a, b, x, y) / area;
    if (u < 0 || v < 0 || w < 0) return std::nullopt;
    return u * a.z() + v * b.z() + w * c.z();
}

std::pair<double, double> least_and_most(const HeightMap& map) {
    double low = **std::ranges::find_if(map.heights, [](const auto& z) { return z.has_value(); });
    double high = low;
    for (const auto& z : map.heights) {
        if (!z) continue;
        low = std::min(low, *z);
        high = std::max(high, *z);
    }
    return {low, high};
}

}  // namespace

std::size_t HeightMap::missing() const {
    return static_cast<std::size_t>(std::ranges::count_if(heights, [](const auto& z) { return !z.has_value(); }));
}

HeightMap height_map(const TriangleMesh& mesh, const std::array<double, 2>& min, const std::array<double, 2>& max, double step) {
    HeightMap map{min, max, {}, {}};
    double count = 1;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        if (!(max.at(axis) > min.at(axis)) || !(step > 0))
            throw std::invalid_argument("a height map needs a window with an area, and a step");
        const double nodes = std::max(std::ceil((max.at(axis) - min.at(axis)) / step), 1.0) + 1;
        count *= nodes;
        if (!(count <= kMostNodes)) throw std::invalid_argument("a height map of more than 10 million nodes: give a larger step");
        map.nodes.at(axis) = static_cast<std::size_t>(nodes);
    }
    map.heights.resize(map.nodes[0] * map.nodes[1]);
    for (const auto& t : mesh.triangles) {
        const Point& a = mesh.points[t[0]];
        const Point& b = mesh.points[t[1]];
        const Point& c = mesh.points[t[2]];
        const Point low = a.cwiseMin(b).cwiseMin(c);
        const Point high = a.cwiseMax(b).cwiseMax(c);
        const NodeRange along_x = nodes_between(map, 0, low.x(), high.x());
        const NodeRange along_y = nodes_between(map, 1, low.y(), high.y());
        for (std::size_t j = along_y.begin; j < along_y.end; ++j) {
            for (std::size_t i = along_x.begin; i < along_x.end; ++i) {
                const auto z = height_of(a, b, c, map.x(i), map.y(j));
                std::optional<double>& highest = map.heights[j * map.nodes[0] + i];
                if (z && (!highest || *z > *highest)) highest = z;
            }
        }
    }
    return map;
}

std::string to_bcnc(const HeightMap& map, double feed_mm_per_min) {
    const auto [low, high] = least_and_most(map);
    std::string out = fmt::format("{} {} {}\n{} {} {}\n{} {} {}\n\n\n", map.min[0], map.max[0], map.nodes[0], map.min[1], map.max[1],
                                  map.nodes[1], low, high, feed_mm_per_min);
    for (std::size_t j = 0; j < map.nodes[1]; ++j) {
        for (std::size_t i = 0; i < map.nodes[0]; ++i) {
            fmt::format_to(std::back_inserter(out), "{} {} {}\n", map.x(i), map.y(j), *map.height(i, j));
        }
        out += '\n';
    }
    return out;
}

std::string to_ugs(const HeightMap& map) {
    std::string out;
    for (std::size_t i = 0; i < map.nodes[0]; ++i) {
        for (std::size_t j = 0; j < map.nodes[1]; ++j) {
            fmt::format_to(std::back_inserter(out), "{} {} {}\n", map.x(i), map.y(j), *map.height(i, j));
        }
    }
    return out;
}

std::string to_candle(const HeightMap& map) {
    const auto [low, high] = least_and_most(map);
    const double width = map.max[0] - map.min[0];
    const double depth = map.max[1] - map.min[1];
    // Border; grid; how it is drawn between nodes (0: bicubic) and how finely.
    std::string out = fmt::format("{};{};{};{}\r\n{};{};{};{}\r\n0;{};{}\r\n", map.min[0], map.min[1], width, depth, map.nodes[0],
                                  map.nodes[1], low, high, map.nodes[0], map.nodes[1]);
    for (std::size_t j = 0; j < map.nodes[1]; ++j) {
        for (std::size_t i = 0; i < map.nodes[0]; ++i) {
            fmt::format_to(std::back_inserter(out), "{}{}", i > 0 ? ";" : "", *map.height(i, j));
        }
        out += "\r\n";
    }
    return out;
}

std::string to_opencncpilot(const HeightMap& map) {
    std::string out = fmt::format(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<heightmap MinX=\"{}\" MinY=\"{}\" MaxX=\"{}\" MaxY=\"{}\" SizeX=\"{}\" "
        "SizeY=\"{}\">\n",
        map.min[0], map.min[1], map.max[0], map.max[1], map.nodes[0], map.nodes[1]);
    // A line each: its reader loses every second of those that follow one another on a line.
    for (std::size_t i = 0; i < map.nodes[0]; ++i) {
        for (std::size_t j = 0; j < map.nodes[1]; ++j) {
            if (const auto& z = map.height(i, j))
                fmt::format_to(std::back_inserter(out), "  <point X=\"{}\" Y=\"{}\">{}</point>\n", i, j, *z);
        }
    }
    return out + "</heightmap>\n";
}

}  // namespace palpate
