// The edges of faces, with what meets at each.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate {

// One side of a face.
struct FaceEdge {
    std::uint32_t low = 0;  // the points that it joins, low < high
    std::uint32_t high = 0;
    std::uint32_t face = 0;
    bool upward = false;  // does the face run from low to high?

    [[nodiscard]] std::uint32_t source() const { return upward ? low : high; }
    [[nodiscard]] std::uint32_t target() const { return upward ? high : low; }
    auto operator<=>(const FaceEdge&) const = default;
};

// Of polygons or triangles, sorted: the sides that share an edge are neighbours, by face. Sides of no length are left out.
template <class Faces>
[[nodiscard]] std::vector<FaceEdge> face_edges(const Faces& faces) {
    std::vector<FaceEdge> edges;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto& corners = faces[f];
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const std::uint32_t a = corners[i];
            const std::uint32_t b = corners[(i + 1) % corners.size()];
            if (a != b) edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(f), a < b});
        }
    }
    std::ranges::sort(edges);
    return edges;
}

// Calls visit(std::span<const FaceEdge>) with all sides of each edge in turn.
template <class Visit>
void for_each_edge(std::span<const FaceEdge> edges, const Visit& visit) {
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high) ++end;
        visit(edges.subspan(begin, end - begin));
    }
}

// The sides that meet no other.
[[nodiscard]] inline std::vector<FaceEdge> open_edges(std::span<const FaceEdge> edges) {
    std::vector<FaceEdge> open;
    for_each_edge(edges, [&](std::span<const FaceEdge> sides) {
        if (sides.size() == 1) open.push_back(sides.front());
    });
    return open;
}

}  // namespace palpate
