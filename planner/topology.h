// What kind of surface a triangle mesh is (thesis 1.2, I1), and where it fails to be one.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// An edge or a vertex at which the mesh is not an oriented manifold.
struct Defect {
    enum class Kind {
        boundary_edge,      // one facet
        nonmanifold_edge,   // three facets or more
        inconsistent_edge,  // two facets that run through it the same way
        split_vertex,       // facets around it form several umbrellas
    };
    Kind kind = Kind::boundary_edge;
    std::array<std::uint32_t, 2> vertices{};  // of the edge, the smaller first; a vertex twice
    std::vector<std::uint32_t> facets;        // incident ones, by index
};

struct Topology {
    std::size_t vertices = 0;
    std::size_t edges = 0;
    std::size_t facets = 0;
    std::size_t components = 0;
    std::int64_t euler_characteristic = 0;
    std::size_t boundary_edges = 0;
    std::size_t nonmanifold_edges = 0;
    std::size_t inconsistent_edges = 0;
    std::size_t split_vertices = 0;
    std::size_t inward_components = 0;  // whose enclosed volume is negative
    std::vector<Defect> defects;

    // A closed, consistently oriented 2-manifold that faces outwards.
    [[nodiscard]] bool is_closed_oriented_manifold() const { return facets > 0 && defects.empty() && inward_components == 0; }
};

// Counts vertices that a facet uses. Linear time but for a sort of the edges.
[[nodiscard]] Topology analyse_topology(const TriangleMesh& mesh);

[[nodiscard]] double surface_area(const TriangleMesh& mesh);  // mm²

}  // namespace palpate
