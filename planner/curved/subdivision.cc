#include "planner/curved/internal/subdivision.h"

namespace palpate {

std::uint32_t Subdivision::at(std::uint32_t facet, std::uint32_t i, std::uint32_t j) const {
    const auto& corners = mesh_->triangles[facet];
    const std::uint32_t h = n_ - i - j;
    if (h == n_) return corners[0];
    if (i == n_) return corners[1];
    if (j == n_) return corners[2];
    // `steps`: from corner k towards the next.
    const auto along = [&](std::size_t k, std::uint32_t steps) {
        const bool is_forward = corners[k] < corners[(k + 1) % 3];
        return on_edge(sides_->edge(facet, k), is_forward ? steps : n_ - steps);
    };
    if (j == 0) return along(0, i);
    if (h == 0) return along(1, j);
    if (i == 0) return along(2, h);
    // Inside, row by row of j.
    const std::uint32_t before = (j - 1) * (n_ - 1) - (j - 1) * j / 2;
    const std::uint32_t inner = (n_ - 1) * (n_ - 2) / 2;
    const auto edges = static_cast<std::uint32_t>(sides_->edges().size());
    return static_cast<std::uint32_t>(mesh_->points.size()) + edges * (n_ - 1) + facet * inner + before + i - 1;
}

void Subdivision::append_parts(std::uint32_t facet, std::vector<std::array<std::uint32_t, 3>>& triangles) const {
    for (std::uint32_t j = 0; j < n_; ++j) {
        for (std::uint32_t i = 0; i + j < n_; ++i) {
            triangles.push_back({at(facet, i, j), at(facet, i + 1, j), at(facet, i, j + 1)});
            if (i + j + 1 < n_) triangles.push_back({at(facet, i + 1, j), at(facet, i + 1, j + 1), at(facet, i, j + 1)});
        }
    }
}

}  // namespace palpate
