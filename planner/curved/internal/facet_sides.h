// The sides of a mesh at its points: facets around a point that go on into each other without a crease.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// rad: two facets that turn by more have a crease between them. A torus whose balls are 0.75 of its smaller radius turns by up to 55°.
inline constexpr double kCrease = 1.05;

inline constexpr std::uint32_t kNoFacet = std::numeric_limits<std::uint32_t>::max();

struct MeshEdge {
    std::array<std::uint32_t, 2> points{};                    // the smaller number first
    std::array<std::uint32_t, 2> facets{kNoFacet, kNoFacet};  // the first two that have it
    std::array<std::array<std::uint8_t, 2>, 2> corners{};     // of these: which corners the two points are
    std::uint32_t count = 0;                                  // of facets
    bool is_smooth = false;                                   // two facets without a crease between them
};

class FacetSides {
public:
    struct Side {
        std::uint32_t point = 0;
        Vector normal = Vector::Zero();  // unit: its facets' by the angles at the point; zero if none has an area
        double spacing = 0.0;            // mm: mean length of its facets' edges at the point
        std::uint32_t first = 0;         // its facets in facets()
        std::uint32_t count = 0;
    };

    // Facets that are `flat` (empty: none) and those beside them have no side in common. REQUIRES: `mesh` outlives this and stays as it is.
    FacetSides(const TriangleMesh& mesh, const std::vector<std::uint8_t>& flat, double crease = kCrease);

    [[nodiscard]] const std::vector<MeshEdge>& edges() const { return edges_; }
    // From corner k on.
    [[nodiscard]] std::uint32_t edge(std::uint32_t facet, std::size_t k) const { return edge_of_[3 * std::size_t{facet} + k]; }
    [[nodiscard]] const std::vector<Side>& sides() const { return sides_; }
    [[nodiscard]] std::uint32_t side(std::uint32_t facet, std::size_t corner) const { return side_of_[3 * std::size_t{facet} + corner]; }
    [[nodiscard]] std::span<const std::uint32_t> facets(const Side& side) const {
        return std::span(facets_).subspan(side.first, side.count);
    }
    [[nodiscard]] const Vector& normal(std::uint32_t facet) const { return normals_[facet]; }  // unit; zero without area
    // How many sides a point has.
    [[nodiscard]] std::uint32_t sides_at(std::uint32_t point) const { return sides_at_[point]; }
    // The sides around `side` over `depth` facets: itself first, then ring by ring, at most `most`, one for each point.
    [[nodiscard]] std::vector<std::uint32_t> rings(std::uint32_t side, int depth, std::size_t most) const;

private:
    void find_edges(double crease);
    void find_sides();

    const TriangleMesh* mesh_;
    std::vector<std::uint8_t> flat_;
    std::vector<Vector> normals_;
    std::vector<MeshEdge> edges_;
    std::vector<std::uint32_t> edge_of_;  // by facet and corner
    std::vector<Side> sides_;
    std::vector<std::uint32_t> side_of_;  // by facet and corner
    std::vector<std::uint32_t> facets_;   // by side
    std::vector<std::uint32_t> sides_at_;
};

}  // namespace palpate
