#include "tools/formats/sections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/random.h"

namespace palpate::sections_test {
namespace {

// Closed, outwards: its corners in turn around z, and two tips.
TriangleMesh spindle(int corners, Random& random) {
    TriangleMesh mesh;
    for (int k = 0; k < corners; ++k) {
        const double angle = 2 * M_PI * k / corners;
        mesh.points.emplace_back(3 * std::cos(angle), 2 * std::sin(angle), random.uniform(-0.5, 0.5));
    }
    mesh.points.emplace_back(0.2, 0.1, 4);
    mesh.points.emplace_back(-0.1, 0.3, -5);
    const auto n = static_cast<std::uint32_t>(corners);
    for (std::uint32_t k = 0; k < n; ++k) {
        mesh.triangles.push_back({k, (k + 1) % n, n});
        mesh.triangles.push_back({(k + 1) % n, k, n + 1});
    }
    return mesh;
}

double area_of(const std::vector<Polyline>& lines) {
    double area = 0;
    for (const Polyline& line : lines) {
        for (std::size_t k = 0; k < line.points.size(); ++k) {
            const auto& a = line.points[k];
            const auto& b = line.points[(k + 1) % line.points.size()];
            area += (a[0] * b[1] - a[1] * b[0]) / 2;
        }
    }
    return area;
}

double volume_of(const TriangleMesh& mesh) {
    double volume = 0;
    for (const auto& t : mesh.triangles) volume += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]])) / 6;
    return volume;
}

TEST(Sections, AreClosedAndTheirAreasMakeTheVolume) {
    Random random(5);
    const TriangleMesh mesh = spindle(17, random);
    constexpr int kSlices = 4000;
    double volume = 0;
    for (int k = 0; k < kSlices; ++k) {
        const auto lines = section(mesh, -5 + 9 * (k + 0.5) / kSlices);
        ASSERT_EQ(lines.size(), 1U);
        ASSERT_TRUE(lines.front().is_closed);
        const double area = area_of(lines);
        ASSERT_GT(area, 0) << "the inside is to the left";
        volume += area * 9 / kSlices;
    }
    EXPECT_NEAR(volume, volume_of(mesh), 1e-4 * volume_of(mesh));
}

TEST(Sections, ThroughCornersAndFlatFacesTheyAreClosedToo) {
    // A box whose faces lie at the heights, and a step at another.
    TriangleMesh box;
    for (int k = 0; k < 8; ++k) box.points.emplace_back((k & 1) != 0 ? 2.0 : 0.0, (k & 2) != 0 ? 1.0 : 0.0, (k & 4) != 0 ? 3.0 : 0.0);
    box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    ASSERT_NEAR(volume_of(box), 6, 1e-12);
    EXPECT_TRUE(section(box, 3.0).empty()) << "what lies at the height is below it";
    EXPECT_TRUE(section(box, -0.1).empty());
    for (const double z : {0.0, 1.0, 2.999}) {
        const auto lines = section(box, z);
        ASSERT_EQ(lines.size(), 1U) << z;
        EXPECT_TRUE(lines.front().is_closed);
        EXPECT_NEAR(area_of(lines), 2, 1e-12);
    }
}

TEST(Sections, OfAnOpenMeshEndAtItsBoundary) {
    Random random(6);
    TriangleMesh mesh = spindle(12, random);
    mesh.triangles.erase(mesh.triangles.begin());
    const auto lines = section(mesh, 1.0);
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_FALSE(lines.front().is_closed);
    EXPECT_EQ(lines.front().points.size(), 12U) << "eleven triangles in a row";
}

TEST(Sections, ADrawingNamesItsLayersAndWhatIsClosed) {
    Random random(7);
    const std::string dxf = to_dxf(spindle(5, random), std::vector<double>{1.0, 2.5});
    EXPECT_THAT(dxf, ::testing::HasSubstr("8\nZ2.5\n66\n1\n10\n0\n20\n0\n30\n2.5\n70\n1\n"));
    EXPECT_THAT(dxf, ::testing::EndsWith("0\nENDSEC\n0\nEOF\n"));
}

}  // namespace
}  // namespace palpate::sections_test
