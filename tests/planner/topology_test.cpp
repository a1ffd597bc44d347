#include "planner/topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::topology_test {
namespace {

TriangleMesh tetrahedron(const Point& at = Point::Zero(), double size = 1) {
    return {{at, at + size * Vector::UnitX(), at + size * Vector::UnitY(), at + size * Vector::UnitZ()},
            {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

// n × m quads around both circles of a torus, two triangles each.
TriangleMesh torus(std::uint32_t n, std::uint32_t m) {
    TriangleMesh mesh;
    const auto turn = [](std::uint32_t k, std::uint32_t of) { return 2 * std::numbers::pi * k / of; };
    for (std::uint32_t i = 0; i < n; ++i) {
        for (std::uint32_t j = 0; j < m; ++j) {
            const double around = 2 + std::cos(turn(j, m));
            mesh.points.emplace_back(around * std::cos(turn(i, n)), around * std::sin(turn(i, n)), std::sin(turn(j, m)));
            const std::uint32_t a = i * m + j;
            const std::uint32_t b = (i + 1) % n * m + j;
            const std::uint32_t c = (i + 1) % n * m + (j + 1) % m;
            const std::uint32_t d = i * m + (j + 1) % m;
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
        }
    }
    return mesh;
}

TriangleMesh together(TriangleMesh mesh, const TriangleMesh& other) {
    const auto shift = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + shift, b + shift, c + shift});
    return mesh;
}

TriangleMesh turned_inside_out(TriangleMesh mesh) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

std::size_t count(const Topology& topology, Defect::Kind kind) {
    return static_cast<std::size_t>(
        std::count_if(topology.defects.begin(), topology.defects.end(), [&](const Defect& d) { return d.kind == kind; }));
}

// The counts say how many defects of each kind are listed.
void expect_consistent(const Topology& t) {
    EXPECT_EQ(count(t, Defect::Kind::boundary_edge), t.boundary_edges);
    EXPECT_EQ(count(t, Defect::Kind::nonmanifold_edge), t.nonmanifold_edges);
    EXPECT_EQ(count(t, Defect::Kind::inconsistent_edge), t.inconsistent_edges);
    EXPECT_EQ(count(t, Defect::Kind::split_vertex), t.split_vertices);
    EXPECT_EQ(t.euler_characteristic,
              static_cast<std::int64_t>(t.vertices) - static_cast<std::int64_t>(t.edges) + static_cast<std::int64_t>(t.facets));
}

TEST(Topology, ATetrahedronIsASphere) {
    const Topology t = analyse_topology(tetrahedron());
    EXPECT_TRUE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.vertices, 4U);
    EXPECT_EQ(t.edges, 6U);
    EXPECT_EQ(t.facets, 4U);
    EXPECT_EQ(t.components, 1U);
    EXPECT_EQ(t.euler_characteristic, 2);
    EXPECT_EQ(t.inward_components, 0U);
    expect_consistent(t);
}

TEST(Topology, ATorusHasEulerCharacteristicZero) {
    const Topology t = analyse_topology(torus(12, 7));
    EXPECT_TRUE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.vertices, 84U);
    EXPECT_EQ(t.facets, 168U);
    EXPECT_EQ(t.edges, 252U);
    EXPECT_EQ(t.components, 1U);
    EXPECT_EQ(t.euler_characteristic, 0);
}

TEST(Topology, NothingIsNoManifold) {
    const Topology t = analyse_topology({});
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.components, 0U);
    EXPECT_EQ(t.euler_characteristic, 0);
}

TEST(Topology, CountsComponents) {
    const Topology t = analyse_topology(together(tetrahedron(), torus(5, 5)));
    EXPECT_TRUE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.components, 2U);
    EXPECT_EQ(t.euler_characteristic, 2);
}

TEST(Topology, UnusedPointsDoNotCount) {
    TriangleMesh mesh = tetrahedron();
    mesh.points.insert(mesh.points.begin(), Point(9, 9, 9));
    mesh.points.emplace_back(8, 8, 8);
    for (auto& triangle : mesh.triangles) {
        for (std::uint32_t& v : triangle) ++v;
    }
    const Topology t = analyse_topology(mesh);
    EXPECT_TRUE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.vertices, 4U);
    EXPECT_EQ(t.components, 1U);
    EXPECT_EQ(t.euler_characteristic, 2);
}

TEST(Topology, AMissingFacetLeavesThreeBoundaryEdges) {
    TriangleMesh mesh = torus(5, 5);
    const auto [a, b, c] = mesh.triangles.back();
    mesh.triangles.pop_back();
    const Topology t = analyse_topology(mesh);
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.boundary_edges, 3U);
    EXPECT_EQ(t.defects.size(), 3U);
    for (const Defect& defect : t.defects) {
        EXPECT_LT(defect.vertices[0], defect.vertices[1]);
        for (const std::uint32_t v : defect.vertices) EXPECT_TRUE(v == a || v == b || v == c);
        ASSERT_EQ(defect.facets.size(), 1U);
        const auto& facet = mesh.triangles[defect.facets[0]];
        for (const std::uint32_t v : defect.vertices) EXPECT_NE(std::find(facet.begin(), facet.end(), v), facet.end());
    }
    expect_consistent(t);
}

TEST(Topology, AFlippedFacetMakesThreeInconsistentEdges) {
    TriangleMesh mesh = torus(5, 5);
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    const Topology t = analyse_topology(mesh);
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.inconsistent_edges, 3U);
    EXPECT_EQ(t.defects.size(), 3U);
    for (const Defect& defect : t.defects) {
        ASSERT_EQ(defect.facets.size(), 2U);
        EXPECT_NE(std::find(defect.facets.begin(), defect.facets.end(), 7U), defect.facets.end());
    }
    expect_consistent(t);
}

TEST(Topology, ThreeFacetsAtAnEdgeAreNotAManifold) {
    TriangleMesh mesh = tetrahedron();
    mesh.points.emplace_back(-1, -1, -1);
    mesh.triangles.push_back({0, 1, 4});
    const Topology t = analyse_topology(mesh);
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.nonmanifold_edges, 1U);
    EXPECT_EQ(t.boundary_edges, 2U);
    EXPECT_EQ(t.split_vertices, 0U);
    const auto bad =
        std::find_if(t.defects.begin(), t.defects.end(), [](const Defect& d) { return d.kind == Defect::Kind::nonmanifold_edge; });
    EXPECT_EQ(bad->vertices, (std::array<std::uint32_t, 2>{0, 1}));
    EXPECT_EQ(bad->facets, (std::vector<std::uint32_t>{0, 1, 4}));
    expect_consistent(t);
}

// Two tetrahedra that share an edge: four facets there, two and two consistent.
TEST(Topology, FourFacetsAtAnEdgeAreNotAManifold) {
    TriangleMesh mesh = together(tetrahedron(), tetrahedron());
    for (std::size_t v = 4; v < 8; ++v) mesh.points[v] *= -1;
    mesh = turned_inside_out(mesh);
    for (std::size_t f = 0; f < 4; ++f) std::swap(mesh.triangles[f][1], mesh.triangles[f][2]);
    for (auto& triangle : mesh.triangles) {
        for (std::uint32_t& v : triangle) v = v == 4 ? 0 : v == 5 ? 1 : v;
    }
    mesh.points[4] = mesh.points[5] = Point(7, 7, 7);
    const Topology t = analyse_topology(mesh);
    EXPECT_EQ(t.nonmanifold_edges, 1U);
    EXPECT_EQ(t.boundary_edges, 0U);
    EXPECT_EQ(t.inconsistent_edges, 0U);
    EXPECT_EQ(t.components, 1U);
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    expect_consistent(t);
}

TEST(Topology, TwoConesThatShareAnApexSplitIt) {
    // The second tetrahedron's vertex 4 is the first one's vertex 0.
    TriangleMesh mesh = together(tetrahedron(), turned_inside_out(tetrahedron(Point::Zero(), -1)));
    for (auto& triangle : mesh.triangles) {
        for (std::uint32_t& v : triangle) v = v == 4 ? 0 : v;
    }
    const Topology t = analyse_topology(mesh);
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    EXPECT_EQ(t.split_vertices, 1U);
    EXPECT_EQ(t.boundary_edges + t.nonmanifold_edges + t.inconsistent_edges, 0U);
    EXPECT_EQ(t.components, 1U);
    EXPECT_EQ(t.euler_characteristic, 3);
    EXPECT_EQ(t.inward_components, 0U);
    ASSERT_EQ(t.defects.size(), 1U);
    EXPECT_EQ(t.defects[0].vertices, (std::array<std::uint32_t, 2>{0, 0}));
    EXPECT_EQ(t.defects[0].facets, (std::vector<std::uint32_t>{0, 1, 2, 4, 5, 6}));
    expect_consistent(t);
}

TEST(Topology, AComponentThatIsInsideOutIsFound) {
    const Topology t = analyse_topology(together(torus(6, 6), turned_inside_out(tetrahedron({100, 0, 0}))));
    EXPECT_TRUE(t.defects.empty());
    EXPECT_EQ(t.inward_components, 1U);
    EXPECT_FALSE(t.is_closed_oriented_manifold());
    EXPECT_EQ(analyse_topology(turned_inside_out(torus(6, 6))).inward_components, 1U);
    // Far from the origin the orientation is still told by the component itself.
    EXPECT_EQ(analyse_topology(tetrahedron({1e6, -1e6, 1e6}, 1e-3)).inward_components, 0U);
    EXPECT_EQ(analyse_topology(turned_inside_out(tetrahedron({1e6, -1e6, 1e6}, 1e-3))).inward_components, 1U);
}

TEST(SurfaceArea, OfKnownMeshes) {
    EXPECT_EQ(surface_area({}), 0);
    EXPECT_NEAR(surface_area(tetrahedron()), 1.5 + std::sqrt(3) / 2, 1e-14);
    EXPECT_NEAR(surface_area(tetrahedron({5, 5, 5}, 3)), 9 * (1.5 + std::sqrt(3) / 2), 1e-12);
    const double smooth = 4 * std::numbers::pi * std::numbers::pi * 2;
    EXPECT_NEAR(surface_area(torus(200, 100)), smooth, 0.002 * smooth);
    EXPECT_LT(surface_area(torus(20, 10)), smooth);
}

}  // namespace
}  // namespace palpate::topology_test
