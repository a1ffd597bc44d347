#include "planner/open_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate::open_area_test {
namespace {

constexpr double kSmallEnough = 2;

// A sphere of radius 1 from a grid of latitudes and longitudes.
TriangleMesh sphere(std::uint32_t rows, std::uint32_t columns) {
    TriangleMesh mesh;
    for (std::uint32_t row = 0; row <= rows; ++row) {
        const double latitude = std::numbers::pi * (static_cast<double>(row) / rows - 0.5);
        for (std::uint32_t column = 0; column < columns; ++column) {
            const double longitude = 2 * std::numbers::pi * column / columns;
            mesh.points.emplace_back(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                                     std::sin(latitude));
        }
    }
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const auto at = [&](std::uint32_t r, std::uint32_t c) { return r * columns + c % columns; };
            mesh.triangles.push_back({at(row, column), at(row, column + 1), at(row + 1, column + 1)});
            mesh.triangles.push_back({at(row, column), at(row + 1, column + 1), at(row + 1, column)});
        }
    }
    return mesh;
}

TEST(OpenArea, OfAClosedMeshIsNone) {
    // The poles are rings of no length.
    const OpenArea area = measure_open_area(sphere(40, 80), kSmallEnough);
    EXPECT_NEAR(area.covered, 4 * std::numbers::pi, 0.02);
    EXPECT_NEAR(area.open, 0, 1e-12);
    EXPECT_EQ(measure_open_area({}, kSmallEnough).open, 0);
}

TEST(OpenArea, OfFlatHolesIsExact) {
    // A grid of unit squares without some of them; two of the holes meet in a corner.
    TriangleMesh mesh;
    constexpr std::uint32_t kSide = 10;
    for (std::uint32_t y = 0; y <= kSide; ++y) {
        for (std::uint32_t x = 0; x <= kSide; ++x) mesh.points.emplace_back(x, y, 0);
    }
    double holes = 0;
    for (std::uint32_t y = 0; y < kSide; ++y) {
        for (std::uint32_t x = 0; x < kSide; ++x) {
            const bool is_hole = (x == 2 && y == 2) || (x == 3 && y == 3) || (x >= 6 && x < 8 && y >= 5 && y < 8);
            holes += is_hole;
            if (is_hole) continue;
            const std::uint32_t corner = y * (kSide + 1) + x;
            mesh.triangles.push_back({corner, corner + 1, corner + kSide + 2});
            mesh.triangles.push_back({corner, corner + kSide + 2, corner + kSide + 1});
        }
    }
    const OpenArea area = measure_open_area(mesh, kSmallEnough);
    EXPECT_DOUBLE_EQ(area.covered, kSide * kSide - holes);
    // The sheet's own border is a loop, too.
    EXPECT_NEAR(area.open, kSide * kSide + holes, 1e-9);
}

TEST(OpenArea, OfSmallHolesInACurvedSurfaceIsAboutRight) {
    TriangleMesh mesh = sphere(60, 120);
    const double whole = measure_open_area(mesh, kSmallEnough).covered;
    // Patches of 6 by 6 cells, every tenth.
    std::vector<std::array<std::uint32_t, 3>> kept;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        const std::size_t cell = k / 2;
        if (cell / 120 % 10 >= 6 || cell % 120 % 10 >= 6 || cell / 120 < 10 || cell / 120 >= 50) kept.push_back(mesh.triangles[k]);
    }
    mesh.triangles = kept;
    const OpenArea area = measure_open_area(mesh, kSmallEnough);
    const double missing = whole - area.covered;
    EXPECT_GT(missing, 0.2 * whole);
    EXPECT_NEAR(area.open, missing, 0.1 * missing);
}

// They will be refined.
TEST(OpenArea, OfLargeFacetsIsTheirs) {
    TriangleMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 0}, {3, 2, 0}};
    const double circumradius = std::sqrt(0.5);
    for (const double share : {0.99, 1.01}) {
        const OpenArea area = measure_open_area(mesh, share * circumradius);
        EXPECT_EQ(area.facets, share > 1 ? 4U : 0U);
        EXPECT_DOUBLE_EQ(area.covered, share > 1 ? 2 : 0);
        EXPECT_DOUBLE_EQ(area.open, share > 1 ? 0 : 2);
    }
}

}  // namespace
}  // namespace palpate::open_area_test
