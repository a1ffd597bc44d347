#include "tools/formats/height_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/random.h"

namespace palpate::height_map_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// A ball of many triangles.
TriangleMesh ball(double radius, int around) {
    TriangleMesh mesh;
    const int rows = around / 2;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i < around; ++i) {
            const double polar = M_PI * j / rows;
            const double turn = 2 * M_PI * i / around;
            mesh.points.emplace_back(radius * Vector(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)));
        }
    }
    const auto at = [&](int j, int i) { return static_cast<std::uint32_t>(j * around + i % around); };
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < around; ++i) {
            mesh.triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
            mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
        }
    }
    return mesh;
}

TEST(HeightMap, IsTheUpperSideAndNothingBeside) {
    constexpr double kRadius = 10;
    const HeightMap map = height_map(ball(kRadius, 400), {-11, -12}, {11, 12}, 0.37);
    std::size_t beside = 0;
    for (std::size_t j = 0; j < map.nodes[1]; ++j) {
        for (std::size_t i = 0; i < map.nodes[0]; ++i) {
            const double square = kRadius * kRadius - map.x(i) * map.x(i) - map.y(j) * map.y(j);
            const auto& z = map.height(i, j);
            beside += square < 0 ? 1 : 0;
            if (std::abs(square) < 0.1) continue;  // the ball's facets lie within it
            ASSERT_EQ(z.has_value(), square > 0) << map.x(i) << ' ' << map.y(j);
            if (z) {
                EXPECT_NEAR(*z, std::sqrt(square), 0.02 + 0.1 / std::sqrt(square));
            }
        }
    }
    EXPECT_NEAR(static_cast<double>(map.missing()), static_cast<double>(beside), 20);
    EXPECT_LE((map.max[0] - map.min[0]) / static_cast<double>(map.nodes[0] - 1), 0.37);
    EXPECT_EQ(map.x(0), -11);
    EXPECT_EQ(map.x(map.nodes[0] - 1), 11);
}

TEST(HeightMap, OfRandomTrianglesIsTheHighestByBruteForce) {
    Random random(9);
    TriangleMesh mesh;
    for (std::uint32_t k = 0; k < 60; ++k) {
        for (int corner = 0; corner < 3; ++corner) mesh.points.push_back(random.in_box(Point::Constant(-5), Point::Constant(5)));
        mesh.triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    }
    const HeightMap map = height_map(mesh, {-4, -3}, {5, 4}, 0.25);
    for (std::size_t j = 0; j < map.nodes[1]; ++j) {
        for (std::size_t i = 0; i < map.nodes[0]; ++i) {
            std::optional<double> highest;
            for (const auto& t : mesh.triangles) {
                // Solves for the weights of the corners.
                Eigen::Matrix3d m;
                for (int corner = 0; corner < 3; ++corner) {
                    const Point& p = mesh.points[t.at(static_cast<std::size_t>(corner))];
                    m.col(corner) << p.x(), p.y(), 1;
                }
                const Vector weights = m.fullPivLu().solve(Vector(map.x(i), map.y(j), 1));
                if (weights.minCoeff() < 0) continue;
                const double z = weights.dot(Vector(mesh.points[t[0]].z(), mesh.points[t[1]].z(), mesh.points[t[2]].z()));
                if (!highest || z > *highest) highest = z;
            }
            ASSERT_EQ(map.height(i, j).has_value(), highest.has_value());
            if (highest) {
                ASSERT_NEAR(*map.height(i, j), *highest, 1e-9);
            }
        }
    }
}

// Two by three nodes of a plane.
HeightMap plane() {
    TriangleMesh mesh;
    mesh.points = {{-9, -9, 0}, {9, -9, 18}, {0, 20, 9}};  // z = x + 9
    mesh.triangles = {{0, 1, 2}};
    return height_map(mesh, {0, 1}, {1, 3}, 1);
}

TEST(HeightMap, IsWrittenAsEachReaderWantsIt) {
    EXPECT_EQ(to_bcnc(plane(), 100), "0 1 2\n1 3 3\n9 10 100\n\n\n0 1 9\n1 1 10\n\n0 2 9\n1 2 10\n\n0 3 9\n1 3 10\n\n");
    EXPECT_EQ(to_ugs(plane()), "0 1 9\n0 2 9\n0 3 9\n1 1 10\n1 2 10\n1 3 10\n");
    EXPECT_EQ(to_candle(plane()), "0;1;1;2\r\n2;3;9;10\r\n0;2;3\r\n9;10\r\n9;10\r\n9;10\r\n");
    HeightMap map = plane();
    map.heights[1].reset();
    const std::string hmap = to_opencncpilot(map);
    EXPECT_THAT(hmap, HasSubstr("<heightmap MinX=\"0\" MinY=\"1\" MaxX=\"1\" MaxY=\"3\" SizeX=\"2\" SizeY=\"3\">\n"));
    EXPECT_THAT(hmap, HasSubstr("\n  <point X=\"0\" Y=\"0\">9</point>\n  <point X=\"0\" Y=\"1\">9</point>\n"));
    EXPECT_THAT(hmap, ::testing::Not(HasSubstr("X=\"1\" Y=\"0\"")));
}

TEST(HeightMap, AWindowWithoutAnAreaOrTooManyNodesIsRefused) {
    EXPECT_THROW((void)height_map({}, {0, 0}, {0, 1}, 1), std::invalid_argument);
    EXPECT_THROW((void)height_map({}, {0, 0}, {1, 1}, 0), std::invalid_argument);
    EXPECT_THROW((void)height_map({}, {0, 0}, {1, 1}, 1e-9), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::height_map_test
