// The curved surface against surfaces in closed form.
#include "planner/curved/curved_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

#include "planner/curved/internal/crossing_parts.h"
#include "planner/topology.h"
#include "tests/planner/torus.h"
#include "tests/random.h"

namespace palpate::curved_surface_test {
namespace {

// A unit sphere: an icosahedron whose facets are cut in four `times` times.
TriangleMesh icosphere(int times) {
    const double g = std::numbers::phi;
    TriangleMesh mesh{{{-1, g, 0},
                       {1, g, 0},
                       {-1, -g, 0},
                       {1, -g, 0},
                       {0, -1, g},
                       {0, 1, g},
                       {0, -1, -g},
                       {0, 1, -g},
                       {g, 0, -1},
                       {g, 0, 1},
                       {-g, 0, -1},
                       {-g, 0, 1}},
                      {{{0, 11, 5}},  {{0, 5, 1}},  {{0, 1, 7}},  {{0, 7, 10}}, {{0, 10, 11}}, {{1, 5, 9}}, {{5, 11, 4}},
                       {{11, 10, 2}}, {{10, 7, 6}}, {{7, 1, 8}},  {{3, 9, 4}},  {{3, 4, 2}},   {{3, 2, 6}}, {{3, 6, 8}},
                       {{3, 8, 9}},   {{4, 9, 5}},  {{2, 4, 11}}, {{6, 2, 10}}, {{8, 6, 7}},   {{9, 8, 1}}}};
    for (Point& p : mesh.points) p.normalize();
    for (int k = 0; k < times; ++k) {
        std::map<std::array<std::uint32_t, 2>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(mesh.points.size()));
            if (is_new) mesh.points.push_back((mesh.points[a] + mesh.points[b]).normalized());
            return at->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const std::uint32_t ab = middle(a, b);
            const std::uint32_t bc = middle(b, c);
            const std::uint32_t ca = middle(c, a);
            for (const auto& t : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) finer.push_back(t);
        }
        mesh.triangles = finer;
    }
    return mesh;
}

// A grid over (u, v) in [0, 1]²; with `wraps` its ends are one.
TriangleMesh grid(std::uint32_t n, std::uint32_t m, bool wraps, const std::function<Point(double, double)>& at) {
    TriangleMesh mesh;
    const std::uint32_t rows = wraps ? n : n + 1;
    const std::uint32_t columns = wraps ? m : m + 1;
    for (std::uint32_t i = 0; i < rows; ++i) {
        for (std::uint32_t j = 0; j < columns; ++j) mesh.points.push_back(at(static_cast<double>(i) / n, static_cast<double>(j) / m));
    }
    const auto number = [&](std::uint32_t i, std::uint32_t j) { return i % rows * columns + j % columns; };
    for (std::uint32_t i = 0; i < n; ++i) {
        for (std::uint32_t j = 0; j < m; ++j) {
            mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
            mesh.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
        }
    }
    return mesh;
}
TriangleMesh torus_mesh(const Torus& torus, std::uint32_t n) {
    return grid(n, n / 2, true, [&](double u, double v) { return torus.at(2 * std::numbers::pi * u, 2 * std::numbers::pi * v).point; });
}

// mm: the farthest of its points from a surface.
double farthest(const CurvedSurface& surface, const std::function<double(const Point&)>& distance) {
    double most = 0;
    for (const Point& p : surface.mesh.points) most = std::max(most, std::abs(distance(p)));
    return most;
}
CurvedOptions wide() { return {.epsilon = 10}; }

TEST(CurvedSurface, PointsConvergeFasterThanTheCubeOfTheSpacing) {
    const auto off_sphere = [](int times) {
        return farthest(curve({icosphere(times), {}, {}}, wide()), [](const Point& p) { return p.norm() - 1; });
    };
    EXPECT_LT(off_sphere(2), 2e-3);
    EXPECT_LT(off_sphere(3) * 8, off_sphere(2));
    const Torus torus;
    const auto off_torus = [&](std::uint32_t n) {
        return farthest(curve({torus_mesh(torus, n), {}, {}}, wide()), [&](const Point& p) { return torus.distance(p); });
    };
    EXPECT_LT(off_torus(40), 1e-3);
    EXPECT_LT(off_torus(80) * 8, off_torus(40));
}

TEST(CurvedSurface, KeepsTouchesTopologyAndOrientation) {
    const TriangleMesh mesh = torus_mesh({}, 32);
    const CurvedSurface surface = curve({mesh, {}, {}}, wide());
    for (std::size_t v = 0; v < mesh.points.size(); ++v) EXPECT_EQ(surface.mesh.points[v], mesh.points[v]);
    const Topology topology = analyse_topology(surface.mesh);
    EXPECT_TRUE(topology.is_closed_oriented_manifold());
    EXPECT_EQ(topology.euler_characteristic, 0);
    EXPECT_EQ(surface.mesh.triangles.size(), 36 * mesh.triangles.size());
    EXPECT_EQ(topology.vertices, surface.mesh.points.size());
    EXPECT_TRUE(crossing_pairs(surface.mesh).empty());
    EXPECT_TRUE(surface.crossing.empty());
}

TEST(CurvedSurface, NormalsAndCurvaturesAreThoseOfTheSurface) {
    const Torus torus;
    const CurvedSurface surface = curve({torus_mesh(torus, 64), {}, {}}, wide());
    for (std::size_t k = 0; k < surface.mesh.points.size(); ++k) {
        const Point& p = surface.mesh.points[k];
        EXPECT_GT(surface.normals[k].dot(torus.nearest(p).normal), std::cos(0.01));
        const double from_axis = std::hypot(p.x(), p.y());
        // Across the tube, and around the axis.
        const double around = (from_axis - torus.major) / torus.minor / from_axis;
        EXPECT_NEAR(surface.curvature[k][0], 1 / torus.minor, 0.2);
        EXPECT_NEAR(surface.curvature[k][1], around, 0.2);
    }
}

TEST(CurvedSurface, APlaneStaysAPlaneAndABoundaryItsBoundary) {
    Random random(1);
    const TriangleMesh mesh = grid(9, 7, false, [&](double u, double v) {
        const bool is_inner = u > 0 && u < 1 && v > 0 && v < 1;
        const double by = is_inner ? 0.04 : 0.0;
        return Point(u + random.uniform(-by, by), v + random.uniform(-by, by), 0.25);
    });
    const CurvedSurface surface = curve({mesh, {}, {}}, wide());
    for (std::size_t k = 0; k < surface.mesh.points.size(); ++k) {
        EXPECT_NEAR(surface.mesh.points[k].z(), 0.25, 1e-12);
        EXPECT_NEAR(surface.normals[k].z(), 1, 1e-12);
        EXPECT_LT(surface.uncertainty[k], 1e-9);
    }
    EXPECT_EQ(analyse_topology(surface.mesh).boundary_edges, 6 * analyse_topology(mesh).boundary_edges);
}

// Two planes that meet at right angles along the y axis, touched beside it only.
TriangleMesh roof() {
    return grid(11, 12, false, [](double u, double v) {
        const double x = 11 * u - 5.5;
        return Point(x, 12 * v, -std::abs(x));
    });
}

TEST(CurvedSurface, ACreaseBetweenTouchesIsFoundAndSharp) {
    const CurvedSurface surface = curve({roof(), {}, {}}, wide());
    // Its ends have touches too few to tell of a crease, and it takes three rings until that does not matter.
    std::size_t creased = 0;
    for (std::size_t k = 0; k < surface.mesh.points.size(); ++k) {
        const Point& p = surface.mesh.points[k];
        if (p.y() < 4.9 || p.y() > 7.1) continue;
        EXPECT_NEAR(p.z(), -std::abs(p.x()), 1e-6);
        if (std::abs(p.x()) > 1e-6) continue;
        ++creased;
        EXPECT_EQ(surface.tags[k], CurvedTag::crease);
    }
    EXPECT_GT(creased, 12U);
    EXPECT_EQ(analyse_topology(surface.mesh).euler_characteristic, 1);
}

TEST(CurvedSurface, NoPlaceIsFartherFromItsFacetThanEpsilon) {
    const TriangleMesh mesh = icosphere(1);
    const CurvedSurface free = curve({mesh, {}, {}}, wide());
    CurvedOptions tight = wide();
    tight.epsilon = 0.01;
    const CurvedSurface held = curve({mesh, {}, {}}, tight);
    const auto off = [&](const CurvedSurface& surface) {
        double most = 0;
        for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[surface.facet_of[t]];
            const Vector normal = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).normalized();
            for (const std::uint32_t v : surface.mesh.triangles[t])
                most = std::max(most, std::abs(normal.dot(surface.mesh.points[v] - mesh.points[a])));
        }
        return most;
    };
    EXPECT_GT(off(free), 0.02);
    EXPECT_LE(off(held), 0.01);
    EXPECT_TRUE(analyse_topology(held.mesh).is_closed_oriented_manifold());
}

TEST(CurvedSurface, NoisePassesOnAndIsNotAmplified) {
    Random random(3);
    TriangleMesh mesh = torus_mesh({}, 48);
    constexpr double kNoise = 0.004;
    for (Point& p : mesh.points) p += Torus().nearest(p).normal * random.uniform(-kNoise, kNoise);
    const std::vector<double> error(mesh.points.size(), kNoise);
    const CurvedSurface surface = curve({mesh, error, {}}, wide());
    std::size_t beyond = 0;
    std::size_t unstated = 0;
    for (std::size_t k = 0; k < surface.mesh.points.size(); ++k) {
        const double off = std::abs(Torus().distance(surface.mesh.points[k]));
        beyond += off > kNoise ? 1 : 0;
        unstated += off > surface.uncertainty[k] ? 1 : 0;
    }
    EXPECT_LT(beyond, surface.mesh.points.size() / 50);
    EXPECT_LT(unstated, surface.mesh.points.size() / 50);
    EXPECT_TRUE(analyse_topology(surface.mesh).is_closed_oriented_manifold());
}

TEST(CurvedSurface, FacetsThatAreFlatOrWithoutAreaStayWhatTheyAre) {
    TriangleMesh mesh = icosphere(2);
    std::vector<std::uint8_t> flat(mesh.triangles.size(), 0);
    for (std::size_t f = 0; f < flat.size(); ++f) flat[f] = mesh.points[mesh.triangles[f][0]].z() < 0 ? 1 : 0;
    // A facet without area: a point of an edge, once more.
    const auto [a, b, c] = mesh.triangles[0];
    const auto middle = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.emplace_back((mesh.points[a] + mesh.points[b]) / 2);
    mesh.triangles[0] = {a, middle, c};
    mesh.triangles.push_back({middle, b, c});
    mesh.triangles.push_back({a, b, middle});
    flat.push_back(flat[0]);
    flat.push_back(flat[0]);
    const CurvedSurface surface = curve({mesh, {}, flat}, wide());
    for (const Point& p : surface.mesh.points) EXPECT_TRUE(p.allFinite());
    for (const Vector& n : surface.normals) EXPECT_NEAR(n.norm(), 1, 1e-9);
    EXPECT_TRUE(analyse_topology(surface.mesh).is_closed_oriented_manifold());
    for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
        const std::uint32_t f = surface.facet_of[t];
        if (flat[f] == 0) continue;
        const Point& p = mesh.points[mesh.triangles[f][0]];
        const Vector normal = (mesh.points[mesh.triangles[f][1]] - p).cross(mesh.points[mesh.triangles[f][2]] - p);
        for (const std::uint32_t v : surface.mesh.triangles[t]) EXPECT_NEAR(normal.dot(surface.mesh.points[v] - p), 0, 1e-12);
    }
}

TEST(CurvedSurface, SegmentsAreFewerWhereThereWouldBeTooManyFacets) {
    CurvedOptions few = wide();
    few.largest_facets = 10 * icosphere(2).triangles.size();
    EXPECT_EQ(curve({icosphere(2), {}, {}}, few).mesh.triangles.size(), 9 * icosphere(2).triangles.size());
    few.largest_facets = 1;
    EXPECT_EQ(curve({icosphere(2), {}, {}}, few).mesh.triangles.size(), icosphere(2).triangles.size());
}

TEST(CurvedSurface, TheSameMeshGivesTheSameBits) {
    const CurvedSurface one = curve({torus_mesh({}, 24), {}, {}}, wide());
    const CurvedSurface two = curve({torus_mesh({}, 24), {}, {}}, wide());
    EXPECT_EQ(one.mesh.points, two.mesh.points);
    EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
    EXPECT_EQ(one.uncertainty, two.uncertainty);
}

TEST(CurvedSurface, BadInputIsRefused) {
    const TriangleMesh mesh = icosphere(0);
    const auto refuses = [](const TouchedMesh& touched, const CurvedOptions& options) {
        EXPECT_THROW((void)curve(touched, options), std::invalid_argument);
    };
    refuses({mesh, {1.0}, {}}, wide());
    refuses({mesh, {}, {1}}, wide());
    refuses({mesh, std::vector<double>(12, -1.0), {}}, wide());
    refuses({mesh, {}, {}}, {});
    refuses({mesh, {}, {}}, {.epsilon = 1, .segments = 0});
    TriangleMesh broken = mesh;
    broken.triangles[0][0] = 99;
    refuses({broken, {}, {}}, wide());
    broken = mesh;
    broken.points[0].x() = std::numeric_limits<double>::quiet_NaN();
    refuses({broken, {}, {}}, wide());
    EXPECT_TRUE(curve({{}, {}, {}}, wide()).mesh.triangles.empty());
}

// Two sheets of a thin, bent plate whose surfaces would pass through each other.
TEST(CurvedSurface, CrossingsAreFoundExactly) {
    TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.3, 0.2, 1}, {0.2, 0.3, 1}, {1, 1, 0}},
                      {{{0, 1, 2}}, {{3, 4, 5}}, {{1, 6, 2}}}};
    using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
    EXPECT_EQ(crossing_pairs(mesh), (Pairs{{0, 1}}));
    EXPECT_EQ(crossing_pairs(mesh, {2}), Pairs{});
    EXPECT_EQ(crossing_pairs(mesh, {1}), (Pairs{{0, 1}}));
    // Folded back onto its neighbour.
    mesh.points[6] = {0.1, 0.1, 0};
    EXPECT_EQ(crossing_pairs(mesh, {2}).front(), (std::pair<std::uint32_t, std::uint32_t>{0, 2}));
}

}  // namespace
}  // namespace palpate::curved_surface_test
