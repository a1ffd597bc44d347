// The points that cut every facet of a mesh into equal parts, each edge's once.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planner/curved/internal/facet_sides.h"

namespace palpate {

// Numbers of points: first the mesh's own, then those on edges in their order, each from its first point on, then those inside facets.
class Subdivision {
public:
    // `segments`: of every edge, > 0. REQUIRES: `mesh` and `sides`, which is of it, outlive this and stay as they are.
    Subdivision(const TriangleMesh& mesh, const FacetSides& sides, std::uint32_t segments) : mesh_(&mesh), sides_(&sides), n_(segments) {}

    [[nodiscard]] std::uint32_t segments() const { return n_; }
    [[nodiscard]] std::size_t points() const {
        const std::size_t n = n_;
        return mesh_->points.size() + (n - 1) * sides_->edges().size() + (n - 1) * (n > 1 ? n - 2 : 0) / 2 * mesh_->triangles.size();
    }
    // The k-th of an edge, 0 < k < segments.
    [[nodiscard]] std::uint32_t on_edge(std::uint32_t edge, std::uint32_t k) const {
        return static_cast<std::uint32_t>(mesh_->points.size()) + edge * (n_ - 1) + k - 1;
    }
    // Of a facet the point with the shares (n - i - j, i, j) / n of its corners.
    [[nodiscard]] std::uint32_t at(std::uint32_t facet, std::uint32_t i, std::uint32_t j) const;
    [[nodiscard]] std::array<double, 3> shares(std::uint32_t i, std::uint32_t j) const {
        const double n = n_;
        return {(n - i - j) / n, i / n, j / n};
    }
    // The parts of a facet, oriented as it is.
    void append_parts(std::uint32_t facet, std::vector<std::array<std::uint32_t, 3>>& triangles) const;

private:
    const TriangleMesh* mesh_;
    const FacetSides* sides_;
    std::uint32_t n_;
};

}  // namespace palpate
