// What is mended in a mesh, what is not, and what is said of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/objects/hidden_object.h"
#include "sim/objects/mesh/internal/mesh_weld.h"
#include "tests/sim/objects/mesh/mesh_files.h"
#include "tests/sim/support.h"

namespace palpate::mesh_repair_test {
namespace {

constexpr std::uint64_t kSeed = 20240229;

TriangleMesh box_mesh(const Vector& size) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) mesh.points.emplace_back(size.cwiseProduct(Vector(i & 1, i >> 1 & 1, i >> 2)));
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

// STL of the mesh, every corner put through `change` on its own.
template <class Change>
std::string stl(const TriangleMesh& mesh, const Change& change) {
    std::ostringstream text;
    text.precision(17);
    text << "solid\n";
    for (const auto& t : mesh.triangles) {
        text << "facet normal 0 0 0\nouter loop\n";
        for (const auto i : t) text << "vertex " << change(mesh.points[i]).transpose() << "\n";
        text << "endloop\nendfacet\n";
    }
    return text.str();
}

class MeshRepair : public MeshFiles {
protected:
    // The corners of every triangle off by up to `noise` along each axis.
    [[nodiscard]] std::filesystem::path write_noisy(const TriangleMesh& mesh, double noise) {
        return write("noisy.stl",
                     stl(mesh, [&](const Point& p) { return Point(p + random_.in_box(Point::Constant(-noise), Point::Constant(noise))); }));
    }
    static std::string only_warning_of(const MeshObject& object) {
        EXPECT_EQ(object.warnings().size(), 1U);
        return object.warnings().empty() ? "" : object.warnings().front();
    }

    Random random_{kSeed};
};

TEST_F(MeshRepair, CubesWithADefectAreMendedWithOneWarning) {
    const auto expect = [&](const char* name, const std::string& warning) {
        const MeshObject cube({test_case(name)});
        EXPECT_EQ(cube.euler_characteristic(), 2) << name;
        EXPECT_NEAR(cube.area(), 2400.0, 1e-10) << name;
        EXPECT_TRUE(cube.contains({1, 1, 1})) << name;
        EXPECT_EQ(only_warning_of(cube), test_case(name).string() + ": " + warning);
    };
    expect("near_duplicate_1e-12.stl", "1 corner that differs from another by at most 1e-12 mm was joined");
    expect("one_face_flipped.off", "2 triangles that faced the other way than those around them were turned");
    expect("repeated_corner.off", "2 faces without area were dropped");
    expect("zero_area_bridge.off", "1 face without area was dropped");
}

TEST_F(MeshRepair, ForbiddenRepairsAreNamedAndRefused) {
    const auto message = [&](const char* name) { return message_of({.file = test_case(name), .repair = false}); };
    EXPECT_EQ(message("near_duplicate_1e-12.stl"),
              test_case("near_duplicate_1e-12.stl").string() +
                  ": needs repair, which object.repair forbids: 1 corner that differs from another by at most 1e-12 mm; set object.repair: "
                  "true, or export the mesh again");
    expect_contains(message("one_face_flipped.off"), "2 triangles that faced the other way");
    expect_contains(message("repeated_corner.off"), "2 faces without area");
    expect_contains(message("zero_area_bridge.off"), "1 face without area");
    expect_contains(message_of({.file = write_off("inside out.off", turned(tetrahedron())), .repair = false}),
                    "1 component was inside out");
    EXPECT_EQ(message_of({.file = test_case("bom.off"), .repair = false}), "");
    EXPECT_EQ(message_of({.file = test_case("asc_bom.stl"), .repair = false}), "");  // equal points are no defect
}

TEST_F(MeshRepair, CornersThatAlmostCoincideAreJoinedAtAnyScaleAndPlace) {
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    const TriangleMesh ball = sphere_mesh(10.0, 3);
    for (const double share : {1e-15, 1e-13, 1e-9, 1e-7, 1e-6, 2e-6}) {
        const MeshObject mended({write_noisy(ball, share * 20.0)});
        EXPECT_EQ(mended.mesh().points.size(), ball.points.size()) << share;
        EXPECT_EQ(mended.euler_characteristic(), 2) << share;
        expect_contains(only_warning_of(mended), " corners that differ from others by at most ");
    }
    for (const double scale : {1e-9, 1e-3, 1e6, 1e12}) {
        const MeshObject mended({write_noisy(ball, 1e-11), scale});
        EXPECT_EQ(mended.mesh().points.size(), ball.points.size()) << scale;
        EXPECT_NEAR(mended.bounds().diagonal(), scale * 20.0 * std::sqrt(3.0), scale * 1e-9);
        TriangleMesh scaled = ball;
        for (Point& p : scaled.points) p *= scale;
        EXPECT_EQ(MeshObject({write_noisy(scaled, scale * 1e-11)}).mesh().points.size(), ball.points.size()) << scale;
    }
    const Vector far(4e6, -4e6, 4e6);
    EXPECT_EQ(MeshObject({write_noisy(moved(ball, far), 1e-9)}).mesh().points.size(), ball.points.size());
    EXPECT_EQ(MeshObject({.file = write_noisy(ball, 1e-9), .at = far}).mesh().points.size(), ball.points.size());
}

TEST_F(MeshRepair, ThinFeaturesOutliveTheJoining) {
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    for (const double thickness : {1e-3, 1e-4, 1e-6}) {
        for (int round = 0; round < 20; ++round) {
            const MeshObject plate({write_noisy(box_mesh({100, 100, thickness}), 0.1 * thickness)});
            EXPECT_EQ(plate.mesh().points.size(), 8U) << thickness;
            EXPECT_EQ(plate.euler_characteristic(), 2) << thickness;
        }
    }
    for (const double thickness : {1e-2, 1e-4, 1e-6}) {
        const MeshObject plate({write_noisy(box_mesh({100, 100, thickness}), 1e-3 * thickness)});
        EXPECT_EQ(plate.mesh().points.size(), 8U) << thickness;
        EXPECT_EQ(plate.mesh().triangles.size(), 12U) << thickness;
        EXPECT_NEAR(plate.bounds().max.z() - plate.bounds().min.z(), thickness, 0.01 * thickness);
    }
}

// What programs write: the share of the size that rounding of each corner moves it, measured, stays within the reach of the weld.
TEST_F(MeshRepair, RoundingToSinglePrecisionOrSixDigitsIsWithinReach) {
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    const auto in_single = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    const auto in_six_digits = [](double x) {
        std::ostringstream text;
        text << x;
        return std::stod(text.str());
    };
    double single = 0.0;
    double digits = 0.0;
    for (int i = 0; i < 10000; ++i) {
        const Vector half = random_.in_box(Point::Constant(0.1), Point::Constant(100.0));
        const Point corner = half + 1e-12 * random_.direction();
        const double size = 2.0 * half.norm();
        single = std::max(single, (half.unaryExpr(in_single) - corner.unaryExpr(in_single)).norm() / size);
        digits = std::max(digits, (half.unaryExpr(in_six_digits) - corner.unaryExpr(in_six_digits)).norm() / size);
        single = std::max(single,
                          (half.unaryExpr([&](double x) { return in_single(x * (1 + 1e-7)); }) - half.unaryExpr(in_single)).norm() / size);
        digits = std::max(
            digits,
            (half.unaryExpr([&](double x) { return in_six_digits(x * (1 + 2e-6)); }) - half.unaryExpr(in_six_digits)).norm() / size);
    }
    RecordProperty("single", std::to_string(1e9 * single));
    RecordProperty("digits", std::to_string(1e9 * digits));
    EXPECT_LE(single, kWeldReach);
    EXPECT_LE(digits, kWeldReach);
}

// Coordinates of 4e6 in single precision are multiples of 0.25 or 0.5 mm.
TEST_F(MeshRepair, SinglePrecisionFarAwayIsReadAsFarAsItIsStillThere) {
    const auto far = [](const Point& p) { return Point((p + Vector::Constant(4e6)).cast<float>().cast<double>()); };
    const TriangleMesh large = box_mesh({20, 30, 40.3});
    const MeshObject object({write("large.stl", stl(large, far))});
    EXPECT_EQ(object.mesh().points.size(), 8U);
    EXPECT_EQ(object.bounds().max, Point(4e6 + 20, 4e6 + 30, 4e6 + 40.25));
    EXPECT_TRUE(object.warnings().empty());

    // Most triangles become points or lines; what is left is a ball in steps.
    const MeshObject small({write("small.stl", stl(sphere_mesh(1.0, 4), far))});
    EXPECT_EQ(small.euler_characteristic(), 2);
    expect_contains(only_warning_of(small), " faces without area were dropped");
    const std::string gone = message_of({write("gone.stl", stl(sphere_mesh(0.01, 1), far))});
    expect_contains(gone, "all its faces are without area");

    // Two copies of a corner that rounding has put 0.5 mm apart are no longer the same corner.
    TriangleMesh split = moved(box_mesh({20, 30, 40}), Vector::Constant(4e6));
    split.points.push_back(split.points[0] + Vector(0.5, 0, 0));
    split.triangles[0][0] = 8;
    expect_contains(message_of({write_off("split.off", split)}), "boundary edges around 1 hole");
}

TEST_F(MeshRepair, HolesAreNeverFilled) {
    TriangleMesh open = box_mesh({1, 1, 1});
    open.triangles.erase(open.triangles.begin());
    expect_contains(
        message_of({.file = write_off("open.off", open), .scale = 10.0, .at = {1, 2, 3}}),
        "not closed: 3 boundary edges around 1 hole; its boundary is 34.1 mm long and passes through (1, 2, 3) mm (fill the holes)");
    open.triangles.erase(open.triangles.begin() + 1);  // a triangle of the opposite side
    expect_contains(message_of({write_off("two.off", open)}),
                    "6 boundary edges around 2 holes; the boundary of the largest is 3.41 mm long");
    // A vertex on an edge, without a face between: a hole without area, all the same.
    TriangleMesh split = box_mesh({1, 1, 1});
    split.points.emplace_back(0.5, 0.5, 0);
    split.triangles.erase(split.triangles.begin());
    split.triangles.insert(split.triangles.end(), {{0, 2, 8}, {0, 8, 1}});
    expect_contains(message_of({write_off("split.off", split)}), "3 boundary edges around 1 hole");
}

TEST_F(MeshRepair, TinyHolesAreNotFilledByJoining) {
    for (const double side : {1e-5, 1e-6, 1e-9}) {
        std::ostringstream text;
        text.precision(17);
        text << "OFF\n12 9 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n";
        for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) text << 0.5 + side * x << " " << 0.5 + side * y << " 1\n";
        text << "4 3 2 1 0\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n4 4 5 9 8\n4 5 6 10 9\n4 6 7 11 10\n4 7 4 8 11\n";
        expect_contains(message_of({write("hole.off", text.str())}), "4 boundary edges around 1 hole");
    }
}

TEST_F(MeshRepair, FacesThatAreThereAlreadyAreDropped) {
    TriangleMesh doubled = tetrahedron();
    doubled.triangles.push_back(doubled.triangles[1]);
    doubled.triangles.push_back({doubled.triangles[2][1], doubled.triangles[2][0], doubled.triangles[2][2]});
    const MeshObject object({write_off("doubled.off", doubled)});
    expect_contains(only_warning_of(object), "2 faces that were there already were dropped");
    EXPECT_EQ(object.mesh().triangles.size(), 4U);
    // A wall inside, between two solids, is no copy of anything: three triangles and more meet at its edges.
    TriangleMesh wall = tetrahedron();
    wall.points.emplace_back(0.5, 0.5, 0.5);
    wall.points.emplace_back(1, 1, 1);
    wall.triangles.insert(wall.triangles.end(), {{1, 2, 5}, {2, 3, 5}, {3, 1, 5}});
    expect_contains(message_of({write_off("wall.off", wall)}), "3 non-manifold edges with more than two triangles");
}

// One edge of a box, from 0 to 8, where faces without area fill what is between many and few points on it.
TEST_F(MeshRepair, ChainsOfFacesWithoutAreaAreDroppedInPlace) {
    Random random(kSeed);
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    for (int round = 0; round < 50; ++round) {
        TriangleMesh mesh = box_mesh({8, 3, 5});
        // The triangle {0, 1, 4} keeps its edge; the one on the other side of it, {0, 2, 1}, is fanned from 2 over points on the edge.
        mesh.triangles.erase(mesh.triangles.begin());
        std::vector<std::uint32_t> chain{0};
        for (int i = 1; i < 8; ++i) {
            chain.push_back(static_cast<std::uint32_t>(mesh.points.size()));
            mesh.points.emplace_back(i, 0, 0);
        }
        chain.push_back(1);
        for (std::size_t i = 0; i + 1 < chain.size(); ++i) mesh.triangles.push_back({chain[i], 2, chain[i + 1]});
        std::vector<std::uint32_t> left = chain;  // a random triangulation of the polygon without area
        while (left.size() > 2) {
            const auto at = 1 + static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(left.size() - 2)));
            mesh.triangles.push_back({left[at - 1], left[at], left[at + 1]});
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
        }
        const MeshObject object({write_off("chain.off", mesh)});
        EXPECT_EQ(object.euler_characteristic(), 2);
        EXPECT_EQ(object.mesh().points.size(), 15U);
        EXPECT_DOUBLE_EQ(object.area(), 2.0 * (8 * 3 + 3 * 5 + 5 * 8));
        expect_contains(only_warning_of(object), "7 faces without area were dropped");
    }
}

// A point in the middle of a slanted edge, rounded to single precision: within the face below, or beyond its edge.
TEST_F(MeshRepair, BridgesThatRoundingFoldsBackAreDropped) {
    int folded = 0;
    for (int k = 1; k < 40; ++k) {
        std::ostringstream text;
        text.precision(17);
        text << "OFF\n9 9 0\n0 0 0\n10 0 0\n10 6 0\n0 6 0\n0 0 5\n10 0 8.7\n10 6 8.7\n0 6 5\n"
             << static_cast<double>(static_cast<float>(k / 4.3)) << " 0 " << static_cast<double>(static_cast<float>(5 + 0.37 * k / 4.3))
             << "\n4 3 2 1 0\n3 4 8 7\n3 8 5 6\n3 8 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n3 4 5 8\n";
        const MeshObject prism({write("prism.off", text.str())});
        EXPECT_EQ(prism.euler_characteristic(), 2);
        EXPECT_NEAR(prism.area(), 60 + 2 * 68.5 + 30 + 52.2 + 6 * std::hypot(10, 3.7), 1e-5);
        folded += static_cast<int>(prism.warnings().size());
    }
    EXPECT_GT(folded, 5);
    EXPECT_LT(folded, 35);
}

// A point in the middle of an edge, moved off it by as little as rounding does, to either side of both faces.
TEST_F(MeshRepair, BridgesThatRoundingMovesOffTheirLineAreMerged) {
    for (const auto& [y, z] : {std::pair{1e-16, -1e-16}, {-1e-16, 1e-16}, {1e-14, 1e-14}, {-1e-13, -1e-13}, {1e-13, 0.0}, {0.0, -1e-13}}) {
        TriangleMesh mesh = box_mesh({1, 1, 1});
        mesh.points.emplace_back(0.5, y, z);
        mesh.triangles.erase(mesh.triangles.begin());
        mesh.triangles.insert(mesh.triangles.end(), {{0, 2, 8}, {8, 2, 1}, {0, 8, 1}});
        const MeshObject object({write_off("bridge.off", mesh)});
        EXPECT_EQ(object.euler_characteristic(), 2);
        EXPECT_NEAR(object.area(), 6.0, 1e-10);
        EXPECT_EQ(object.mesh().points.size(), 9U);
    }
}

TEST_F(MeshRepair, AsFewTrianglesAsPossibleAreTurned) {
    Random random(kSeed);
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    for (int round = 0; round < 20; ++round) {
        TriangleMesh ball = joined(sphere_mesh(1.0, 2), moved(sphere_mesh(1.0, 2), {3, 0, 0}));
        std::size_t turned_around = 0;
        for (auto& t : ball.triangles) {
            if (random.uniform(0.0, 1.0) > 0.3) continue;
            std::swap(t[0], t[1]);
            ++turned_around;
        }
        const MeshObject object({write_off("mixed.off", ball)});
        expect_contains(only_warning_of(object), ": " + std::to_string(turned_around) + " triangles that faced the other way");
        EXPECT_TRUE(object.contains(Point::Zero()));
        EXPECT_TRUE(object.contains({3, 0, 0}));
    }
}

TEST_F(MeshRepair, TheSameFileGivesTheSameMesh) {
    const auto file = write_noisy(sphere_mesh(1.0, 3), 1e-9);
    const MeshObject first({file});
    const MeshObject second({file});
    EXPECT_EQ(first.mesh().points, second.mesh().points);
    EXPECT_EQ(first.mesh().triangles, second.mesh().triangles);
}

TEST_F(MeshRepair, MeshesArePlacedAsShapesAre) {
    const ShapeSpec shape{RoundedBoxSpec{{1, 2, 3}, 0}, {4, -5, 6}, {0.3, -0.5, 2.0}};
    const MeshSpec spec{.file = write_off("box.off", moved(box_mesh({0.5, 1, 1.5}), {-0.25, -0.5, -0.75})),
                        .scale = 2.0,
                        .at = shape.at,
                        .rotate = shape.rotate};
    const HiddenObject expected{ObjectSpec(shape)};
    const HiddenObject placed{ObjectSpec(spec)};
    EXPECT_LE((placed.bounds().min - expected.bounds().min).norm(), 1e-14);
    EXPECT_LE((placed.bounds().max - expected.bounds().max).norm(), 1e-14);
    Random random(kSeed);
    for (int i = 0; i < 200; ++i) {
        const Point p = random.around(expected.bounds(), 0.2);
        EXPECT_NEAR(placed.distance(p), expected.distance(p), 1e-13);
        EXPECT_EQ(placed.contains(p), expected.contains(p));
    }
    EXPECT_NE(message_of({.file = spec.file, .at = {std::numeric_limits<double>::infinity(), 0, 0}}), "");
    expect_contains(message_of({.file = spec.file, .scale = 1e-9, .at = {4e9, 0, 0}}), "degenerate triangles");
    expect_contains(message_of({.file = spec.file, .scale = 1e308 * 1.5}), "is too large or too far away");
    // A bridge stays exact in the file's coordinates, whatever they become.
    EXPECT_EQ(message_of({.file = test_case("zero_area_bridge.off"), .scale = 1e-9, .at = {1, 2, 3}, .rotate = {0.1, 0.2, 0.3}}), "");
}

}  // namespace
}  // namespace palpate::mesh_repair_test
