// A box as triangles.
#pragma once

#include <array>
#include <cstdint>

#include "planner/geometry.h"

namespace palpate {

// Appends its twelve, counter-clockwise seen from outside.
inline void append_box(TriangleMesh& mesh, const Box& box) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (unsigned k = 0; k < 8; ++k) {
        mesh.points.emplace_back((k & 1U ? box.max : box.min).x(), (k & 2U ? box.max : box.min).y(), (k & 4U ? box.max : box.min).z());
    }
    // By face: its corners in turn.
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& [a, b, c, d] : kFaces) {
        mesh.triangles.push_back({first + a, first + b, first + c});
        mesh.triangles.push_back({first + a, first + c, first + d});
    }
}

}  // namespace palpate
