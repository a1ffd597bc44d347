#include "sim/objects/mesh/mesh_object.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "tests/sim/objects/mesh/mesh_files.h"
#include "tests/sim/support.h"

namespace palpate::mesh_object_test {
namespace {

constexpr std::uint64_t kSeed = 424242;

// Exactly representable in single precision, so that all formats hold the same solid.
TriangleMesh single_precision(TriangleMesh mesh) {
    for (Point& p : mesh.points) {
        for (double& x : p) x = static_cast<double>(static_cast<float>(x));
    }
    return mesh;
}

TEST_F(MeshFiles, AllFormatsLoadToTheSameSolid) {
    const TriangleMesh ball = single_precision(sphere_mesh(2.0, 3));
    std::ostringstream ply;
    std::ostringstream obj;
    std::ostringstream stl;
    std::ostringstream binary(std::ios::binary);
    ply.precision(17);
    obj.precision(17);
    stl.precision(17);
    ply << "ply\nformat ascii 1.0\nelement vertex " << ball.points.size() << "\nproperty double x\nproperty double y\nproperty double z\n"
        << "element face " << ball.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    stl << "solid ball\n";
    binary << std::string(80, ' ');
    const auto put = [&](const auto& value) { binary.write(reinterpret_cast<const char*>(&value), sizeof value); };
    put(static_cast<std::uint32_t>(ball.triangles.size()));
    for (const Point& p : ball.points) {
        ply << p.transpose() << "\n";
        obj << "v " << p.transpose() << "\n";
    }
    for (const auto& [a, b, c] : ball.triangles) {
        ply << "3 " << a << " " << b << " " << c << "\n";
        obj << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
        stl << "facet normal 0 0 0\nouter loop\n";
        for (int i = 0; i < 3; ++i) put(0.0F);
        for (auto i : {a, b, c}) {
            stl << "vertex " << ball.points[i].transpose() << "\n";
            for (double x : ball.points[i]) put(static_cast<float>(x));
        }
        stl << "endloop\nendfacet\n";
        put(std::uint16_t{0});
    }
    stl << "endsolid ball\n";
    const MeshObject expected({write_off("ball.off", ball)});
    EXPECT_EQ(expected.euler_characteristic(), 2);
    for (const auto& file :
         {write("ball.ply", ply.str()), write("ball.obj", obj.str()), write("ball.stl", stl.str()), write("binary.STL", binary.str())}) {
        SCOPED_TRACE(file.string());
        const MeshObject object({file});
        EXPECT_EQ(object.mesh().points.size(), ball.points.size());
        EXPECT_EQ(object.mesh().triangles.size(), ball.triangles.size());
        EXPECT_EQ(object.euler_characteristic(), 2);
        EXPECT_EQ(object.components(), 1);
        EXPECT_NEAR(object.area(), expected.area(), 1e-9);
        EXPECT_EQ(object.bounds().max, expected.bounds().max);
        EXPECT_TRUE(object.warnings().empty());
        EXPECT_TRUE(object.contains(Point::Zero()));
    }
}

TEST_F(MeshFiles, PolygonsAreTriangulatedAndScaled) {
    const auto cube = write("cube.obj",
                            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                            "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    const MeshObject object({.file = cube, .scale = 3.0});
    EXPECT_EQ(object.mesh().triangles.size(), 12U);
    EXPECT_DOUBLE_EQ(object.area(), 54.0);
    EXPECT_EQ(object.bounds().max, Point::Constant(3.0));
    // An L-shaped prism: its caps are not convex, so a fan would leave it.
    const auto prism = write("prism.obj",
                             "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n"
                             "f 3 2 1 6 5 4\nf 9 10 11 12 7 8\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n");
    const MeshObject angle({prism});
    EXPECT_DOUBLE_EQ(angle.area(), 2.0 * 3.0 + 8.0);
    EXPECT_FALSE(angle.contains({1.5, 1.5, 0.5}));
    EXPECT_TRUE(angle.contains({0.5, 1.5, 0.5}));
}

TEST_F(MeshFiles, RefusesFilesThatCannotBeRead) {
    expect_contains(message_of({folder_ / "nothing.off"}), "no such file");
    std::filesystem::create_directory(folder_ / "folder.off");
    expect_contains(message_of({folder_ / "folder.off"}), "folder.off: is a folder");
    ASSERT_EQ(mkfifo((folder_ / "pipe.off").c_str(), 0600), 0);
    expect_contains(message_of({folder_ / "pipe.off"}), "pipe.off: is no file but a pipe");
    expect_contains(message_of({write("empty.off", "")}), "file is empty");
    expect_contains(message_of({write("mesh.xyz", "1 2 3\n")}), "unknown mesh format");
    expect_contains(message_of({write("text.ply", "this is not a ply file\n")}), "text.ply: line 1: 'this' where 'ply' was expected");
    expect_contains(message_of({write("cut.off", off_text(tetrahedron()).substr(0, 25))}),
                    "cut.off: line 5: the file ends where a coordinate was expected");
    expect_contains(message_of({write("points.off", "OFF\n1 0 0\n0 0 0\n")}), "points.off: holds no faces");
    expect_contains(message_of({write("huge.off", "OFF\n999999999 999999999 0\n0 0 0\n")}),
                    "huge.off: line 4: the file ends where a coordinate was expected");
    expect_contains(message_of({write("range.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")}),
                    "range.off: line 6: a face names point 7, but there are 3, counted from 0");
    expect_contains(message_of({write_off("t.off", tetrahedron()), 0.0}), "scale must be a positive number");
    expect_contains(message_of({write_off("t.off", tetrahedron()), std::numeric_limits<double>::quiet_NaN()}), "scale");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these end the process instead
TEST_F(MeshFiles, RefusesFilesLargerThanMemory) {
    const auto file = write("large.off", "OFF\n");
    std::error_code error;
    std::filesystem::resize_file(file, std::uintmax_t{1} << 40U, error);
    if (error) GTEST_SKIP() << error.message();
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    rlimit few = before;
    few.rlim_cur = std::min(before.rlim_cur, rlim_t{1} << 36U);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &few), 0);
    const std::string message = message_of({file});
    ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
    expect_contains(message, "large.off: is too large for the memory of this computer");
}
#endif

TEST_F(MeshFiles, RefusesNumbersThatAreNotFinite) {
    std::string binary =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    TriangleMesh mesh = tetrahedron();
    mesh.points[2].y() = std::numeric_limits<double>::infinity();
    const auto put = [&](const auto& value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (const Point& p : mesh.points) {
        for (double x : p) put(x);
    }
    for (const auto& t : mesh.triangles) {
        put(std::uint8_t{3});
        for (auto i : t) put(i);
    }
    expect_contains(message_of({write("infinite.ply", binary)}), "infinite.ply: byte 228: inf where a coordinate was expected");
}

TEST_F(MeshFiles, RefusesWhatBoundsNoSolidWithCounts) {
    TriangleMesh open = moved(tetrahedron(), {5, 0, 0});
    open.triangles.pop_back();
    expect_contains(message_of({write_off("open.off", open)}),
                    "open.off: not the surface of a solid: not closed: 3 boundary edges around 1 hole; its boundary is 3.41 mm long and "
                    "passes through (5, 0, 0) mm");

    // Two tetrahedra with a common edge, a common vertex, and through one another.
    TriangleMesh mirrored = tetrahedron();
    for (Point& p : mirrored.points) p.head<2>() *= -1.0;
    TriangleMesh edge = joined(tetrahedron(), mirrored);
    expect_contains(message_of({write_off("edge.off", edge)}), "1 non-manifold edge ");
    TriangleMesh opposite = turned(tetrahedron());
    for (Point& p : opposite.points) p *= -1.0;
    expect_contains(message_of({write_off("vertex.off", joined(tetrahedron(), opposite))}), "1 non-manifold vertex ");
    const std::string crossing = message_of({write_off("crossing.off", joined(tetrahedron(), moved(tetrahedron(), {0.2, 0.15, 0.1})))});
    expect_contains(crossing, "self-intersecting: ");
    expect_contains(crossing, " pairs of triangles");

    // The projective plane of six points.
    TriangleMesh plane{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}},
                       {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1}, {1, 2, 4}, {2, 4, 5}, {2, 3, 5}, {1, 3, 5}, {1, 3, 4}}};
    expect_contains(message_of({write_off("plane.off", plane)}), "one-sided: no orientation agrees across ");
}

TEST_F(MeshFiles, ReportsSeveralProblemsTogether) {
    TriangleMesh open = tetrahedron();
    open.triangles.pop_back();
    TriangleMesh mirrored = tetrahedron();
    for (Point& p : mirrored.points) p.head<2>() *= -1.0;
    const TriangleMesh pair = joined(tetrahedron(), mirrored);
    const std::string message = message_of({write_off("bad.off", joined(joined(moved(open, {5, 0, 0}), moved(open, {7, 0, 0})), pair))});
    expect_contains(message, "6 boundary edges around 2 holes; the boundary of the largest is 3.41 mm long");
    expect_contains(message, "1 non-manifold edge");
}

TEST_F(MeshFiles, InsideOutIsRepairedWithAWarning) {
    const TriangleMesh ball = sphere_mesh(1.0, 2);
    const MeshObject whole({write_off("whole.off", turned(ball))});
    ASSERT_EQ(whole.warnings().size(), 1U);
    expect_contains(whole.warnings().front(), "whole.off: 1 component was inside out and has been turned");
    const auto& t = whole.mesh().triangles.front();
    const Point& a = whole.mesh().points[t[0]];
    EXPECT_GT((whole.mesh().points[t[1]] - a).cross(whole.mesh().points[t[2]] - a).dot(a), 0.0);

    const MeshObject one({write_off("one.off", joined(ball, moved(turned(ball), {3, 0, 0})))});
    ASSERT_EQ(one.warnings().size(), 1U);
    expect_contains(one.warnings().front(), "1 of 2 components was inside out");
    EXPECT_TRUE(one.contains({3, 0, 0}));
    EXPECT_FALSE(one.contains({1.5, 0, 0}));
    EXPECT_EQ(one.components(), 2);
    EXPECT_EQ(one.euler_characteristic(), 4);
}

TEST_F(MeshFiles, SidesOfSmallComponentsDoNotDependOnWhatIsBesideThem) {
    const auto cube = [](double size, const Point& at) {
        TriangleMesh mesh{{},
                          {{0, 2, 1},
                           {1, 2, 3},
                           {4, 5, 6},
                           {5, 7, 6},
                           {0, 1, 4},
                           {1, 5, 4},
                           {2, 6, 3},
                           {3, 6, 7},
                           {0, 4, 2},
                           {2, 4, 6},
                           {1, 3, 5},
                           {3, 7, 5}}};
        for (int i = 0; i < 8; ++i) mesh.points.push_back(at + size * Vector(i & 1, i >> 1 & 1, i >> 2));
        return mesh;
    };
    const TriangleMesh large = cube(1.0, Point::Zero());
    for (const Point& at : {Point(3, 0.3, 0.7), Point(1.1, 2.3, 0.1), Point(-5.7, 0.9, -3.3), Point(0.3, 0.4, 7.1)}) {
        const TriangleMesh small = cube(1e-6, at);
        const MeshObject outward({write_off("outward.off", joined(large, small))});
        EXPECT_TRUE(outward.warnings().empty());
        EXPECT_TRUE(outward.contains(at + Point::Constant(5e-7)));
        const MeshObject inward({write_off("inward.off", joined(large, turned(small)))});
        ASSERT_EQ(inward.warnings().size(), 1U);
        expect_contains(inward.warnings().front(), "1 of 2 components was inside out");
        const auto& t = inward.mesh().triangles.back();
        EXPECT_EQ(t, outward.mesh().triangles.back());
    }
}

TEST_F(MeshFiles, IntersectionsAreCountedUpToALimit) {
    constexpr std::uint32_t kRim = 1000;
    TriangleMesh fan{{{0, 0, 1}, {0, 0, -1}}, {}};
    for (std::uint32_t i = 0; i < kRim; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kRim;
        fan.points.emplace_back(std::cos(angle), std::sin(angle), 0.0);
        fan.triangles.push_back({0, 2 + i, 2 + (i + 1) % kRim});
        fan.triangles.push_back({1, 2 + (i + 1) % kRim, 2 + i});
    }
    expect_contains(message_of({write_off("crossing.off", joined(fan, moved(fan, {0.01, 0.02, 0.03})))}),
                    "self-intersecting: more than 1000 pairs of triangles");
}

TEST_F(MeshFiles, CavitiesStayCavitiesAndAreWarnedOf) {
    const MeshObject hollow({write_off("hollow.off", joined(sphere_mesh(2.0, 2), turned(sphere_mesh(1.0, 2))))});
    EXPECT_FALSE(hollow.contains(Point::Zero()));
    EXPECT_TRUE(hollow.contains({1.4, 0, 0}));
    ASSERT_EQ(hollow.warnings().size(), 1U);
    expect_contains(hollow.warnings().front(), "1 component is a cavity");
}

TEST_F(MeshFiles, RaysThroughEdgesAndVerticesHitOnce) {
    const MeshObject ball({write_off("ball.off", sphere_mesh(1.0, 3))});
    Random random(kSeed);
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    const auto& mesh = ball.mesh();
    for (int i = 0; i < 2000; ++i) {
        const auto& t = mesh.triangles[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(mesh.triangles.size())))];
        const double share = i % 2 == 0 ? 0.0 : 0.5;  // a vertex, or the middle of an edge
        const Point on = (1.0 - share) * mesh.points[t[0]] + share * mesh.points[t[1]];
        const auto hit = ball.first_hit({3.0 * on, -3.0 * on});
        ASSERT_TRUE(hit);
        ASSERT_LE((*hit - on).norm(), 1e-14);
        ASSERT_EQ(ball.crossings({3.0 * on, -3.0 * on}).size(), 2U);
        ASSERT_EQ(ball.crossings({3.0 * on, Point::Zero()}).size(), 1U);
    }
}

TEST_F(MeshFiles, RaysInThePlaneOfAFaceHitItsRim) {
    const MeshObject cube({write("cube.obj",
                                 "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                 "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n")});
    const auto hit = cube.first_hit({{-1.0, 0.3, 1.0}, {2.0, 0.3, 1.0}});
    ASSERT_TRUE(hit);
    EXPECT_EQ(*hit, Point(0.0, 0.3, 1.0));
    const auto within = cube.first_hit({{0.4, 0.3, 1.0}, {2.0, 0.3, 1.0}});
    ASSERT_TRUE(within);
    EXPECT_EQ(*within, Point(0.4, 0.3, 1.0));
    EXPECT_FALSE(cube.first_hit({{-1.0, 0.3, 1.0 + 1e-15}, {2.0, 0.3, 1.0 + 1e-15}}));
}

class Bunny : public testing::Test {
protected:
    MeshObject bunny_{MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"}};
};

TEST_F(Bunny, ParityOfCrossingsMatchesContainsAndFirstIsFirst) {
    Random random(kSeed);
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    EXPECT_EQ(bunny_.euler_characteristic(), 2);
    int hits = 0;
    for (int i = 0; i < 5000; ++i) {
        const Segment s{random.around(bunny_.bounds(), 0.1), random.around(bunny_.bounds(), 0.1)};
        const auto crossings = bunny_.crossings(s);
        const auto hit = bunny_.first_hit(s);
        ASSERT_EQ(crossings.size() % 2 == 1, bunny_.contains(s.source) != bunny_.contains(s.target));
        ASSERT_EQ(hit.has_value(), !crossings.empty());
        if (!hit) continue;
        ++hits;
        ASSERT_EQ(*hit, crossings.front());
        ASSERT_LE(bunny_.distance(*hit), 1e-13 * bunny_.bounds().diagonal());
    }
    EXPECT_GT(hits, 1000);
}

TEST_F(Bunny, DistanceAndHitsAgreeWithAllTriangles) {
    Random random(kSeed);
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    const auto& mesh = bunny_.mesh();
    for (int i = 0; i < 50; ++i) {
        const Point p = random.around(bunny_.bounds(), 0.2);
        const Point q = random.around(bunny_.bounds(), 0.2);
        double least = std::numeric_limits<double>::infinity();
        std::optional<double> first;
        for (const auto& t : mesh.triangles) {
            const Point& a = mesh.points[t[0]];
            Eigen::Matrix3d m;  // q - p = -, edges: p + s (q - p) = a + u e1 + v e2
            m << p - q, mesh.points[t[1]] - a, mesh.points[t[2]] - a;
            const Vector suv = m.inverse() * (p - a);
            const bool in = suv.minCoeff() >= 0.0 && suv.x() <= 1.0 && suv.y() + suv.z() <= 1.0;
            if (in && (!first || suv.x() < *first)) first = suv.x();
            constexpr int kGrid = 12;
            for (int j = 0; j <= kGrid; ++j) {
                for (int k = 0; j + k <= kGrid; ++k) {
                    const Point on = a + (static_cast<double>(j) * m.col(1) + static_cast<double>(k) * m.col(2)) / kGrid;
                    least = std::min(least, (on - p).norm());
                }
            }
        }
        ASSERT_GE(least, bunny_.distance(p) - 1e-12);
        ASSERT_LE(least, bunny_.distance(p) + 0.01 * bunny_.bounds().diagonal());
        const auto hit = bunny_.first_hit({p, q});
        ASSERT_EQ(hit.has_value(), first.has_value());
        if (hit) {
            ASSERT_LE((*hit - (p + *first * (q - p))).norm(), 1e-11 * bunny_.bounds().diagonal());
        }
    }
}

}  // namespace
}  // namespace palpate::mesh_object_test
