// Parts of which an area alone is probed: the tool stays in it, and the result is right there and open at its edge.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "devices/device_oracle.h"
#include "planner/grown_fixtures.h"
#include "planner/part/part_surface.h"
#include "planner/part/traced_surface.h"
#include "planner/probe_surface.h"
#include "sim/area_audit.h"
#include "sim/simulated_device.h"
#include "sim/tool/tool_audit.h"
#include "sim/tool/tool_obstacle.h"
#include "tests/end_to_end/temporary_mesh.h"

namespace palpate::area_test {
namespace {

constexpr double kClearance = 0.002;  // mm
constexpr double kRounding = 1e-6;    // mm

// 90 × 90 × 20 mm and more: waves of 3 mm.
double height(double x, double y) { return 20 + 3 * std::sin(x / 6) * std::cos(y / 8); }

TriangleMesh wavy_plate() {
    constexpr int kCells = 60;
    constexpr double kHalf = 45;
    TriangleMesh mesh;
    const auto place = [&](int i) { return -kHalf + 2 * kHalf * i / kCells; };
    const auto number = [](int i, int j, bool top) { return static_cast<std::uint32_t>((i * (kCells + 1) + j) * 2 + (top ? 1 : 0)); };
    for (int i = 0; i <= kCells; ++i) {
        for (int j = 0; j <= kCells; ++j) {
            mesh.points.emplace_back(place(i), place(j), 0);
            mesh.points.emplace_back(place(i), place(j), height(place(i), place(j)));
        }
    }
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    };
    for (int i = 0; i < kCells; ++i) {
        for (int j = 0; j < kCells; ++j) {
            quad(number(i, j, true), number(i + 1, j, true), number(i + 1, j + 1, true), number(i, j + 1, true));
            quad(number(i, j, false), number(i, j + 1, false), number(i + 1, j + 1, false), number(i + 1, j, false));
        }
        quad(number(i, 0, false), number(i + 1, 0, false), number(i + 1, 0, true), number(i, 0, true));
        quad(number(i + 1, kCells, false), number(i, kCells, false), number(i, kCells, true), number(i + 1, kCells, true));
        quad(number(0, i + 1, false), number(0, i, false), number(0, i, true), number(0, i + 1, true));
        quad(number(kCells, i, false), number(kCells, i + 1, false), number(kCells, i + 1, true), number(kCells, i, true));
    }
    return mesh;
}

struct Case {
    std::string name;
    bool is_bunny = false;  // of 100 mm, on a table; else the plate, on none
    Box workspace;
    Area area;
    double epsilon = 0.0;
    double ball = 0.0;  // mm: diameters; 0: a point
    double stylus = 0.0;
    // What it may cost: some 15 % above what was measured.
    double probes = 0.0;   // per touched sample
    double way = 0.0;      // in ε per touched sample
    double touched = 0.0;  // samples
};

const std::vector<Case>& cases() {
    // Beyond the workspace the plate goes on.
    const Box over_plate{{-30, -30, 5}, {30, 30, 45}};
    const Box over_bunny{{-70, -60, 0}, {70, 60, 112}};
    static const std::vector<Case> all{
        {"window", false, over_plate, Box{{-16, -14, 8}, {14, 15, 45}}, 2, 3, 2, 9, 99, 9999},
        {"window_point", false, over_plate, Box{{-16, -14, 8}, {14, 15, 99}}, 2, 0, 0, 9, 99, 9999},
        {"l_shape", false, over_plate, Prism{{{-18, -18}, {18, -18}, {18, -3}, {0, -3}, {0, 18}, {-18, 18}}, {8, 99}}, 2, 3, 2, 9, 99,
         9999},
        {"star", false, over_plate, Prism{{{20, 0}, {8, 6}, {6, 20}, {-6, 8}, {-20, 6}, {-8, -6}, {-6, -20}, {6, -8}}, {8, 99}}, 1.5, 3, 2,
         9, 99, 9999},
        // Over the plate's edge, to a side of the workspace.
        {"at_the_side", false, {{-60, -60, 5}, {60, 60, 45}}, Box{{20, -12, 8}, {60, 12, 45}}, 2, 3, 2, 9, 99, 9999},
        {"head", true, over_bunny, Box{{-58, -42, 70}, {16, 48, 112}}, 3, 6, 4, 9, 99, 9999},
    };
    return all;
}

HiddenObject object_of(const Case& test, std::optional<TemporaryMesh>& file) {
    MeshSpec spec;
    if (test.is_bunny) {
        spec.file = std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off";
        spec.scale = 10;
        spec.rotate = {std::numbers::pi / 2, 0, 0};
    } else {
        file.emplace(wavy_plate(), test.name);
        spec.file = file->path();
    }
    return HiddenObject{ObjectSpec(spec)};
}

std::optional<ToolShape> tool_of(const Case& test) {
    if (test.ball == 0) return std::nullopt;
    ToolShape tool;
    tool.ball_diameter = test.ball;
    tool.stylus = ToolShape::Shaft{test.stylus, 150};
    return tool;
}

struct AreaRun {
    Result result;
    ToolAccount account{};
    std::uint64_t moves_out = 0;
};

AreaRun probe(const Case& test, const HiddenObject& object, const Fixtures& fixtures, const std::optional<Area>& area) {
    const std::optional<ToolShape> tool = tool_of(test);
    const Surroundings surroundings =
        surroundings_with(test.workspace, fixtures, tool.value_or(ToolShape{}), kClearance, test.epsilon, area);
    const ToolObstacle obstacle(object, tool, fixtures.solids);
    const ToolDepths depths(object, tool, fixtures.solids);
    ToolAudit audit(depths);
    AreaAudit area_audit(area.value_or(test.workspace), test.workspace, kRounding);
    SimulatedDeviceOptions device_options;
    device_options.audit = false;  // of points
    device_options.on_move = [&](const Segment& way, bool touched) {
        audit.record(way, touched);
        area_audit.record(way);
    };
    // Far above and aside.
    SimulatedDevice device(obstacle, test.workspace.max + Vector(40, 0, 30), device_options);
    DeviceOracle oracle(device, {}, DeviceOracle::Positions::exact);
    Options options;
    options.epsilon = test.epsilon;
    options.strategy = Strategy::adaptive();
    options.goes_home = true;
    AreaRun run{probe_surface(oracle, surroundings, options)};
    run.account = audit.account();
    run.moves_out = area_audit.moves_out();
    return run;
}

// Ends of the edges that one facet has.
std::vector<Point> boundary_of(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    }
    std::vector<Point> points;
    for (const auto& [edge, facets] : edges) {
        if (facets == 1) points.insert(points.end(), {mesh.points[edge.first], mesh.points[edge.second]});
    }
    return points;
}

class WithinAnArea : public ::testing::TestWithParam<std::size_t> {};

TEST_P(WithinAnArea, StaysInItAndEndsRightAndOpen) {
    const Case& test = cases()[GetParam()];
    std::optional<TemporaryMesh> file;
    const HiddenObject object = object_of(test, file);
    Fixtures fixtures;
    if (test.is_bunny) fixtures.solids.emplace_back(Table{0});
    const AreaRun run = probe(test, object, fixtures, test.area);
    const Result& result = run.result;

    EXPECT_EQ(run.moves_out, 0U);
    EXPECT_EQ(run.account.unsafe_moves, 0U);
    for (const Touch& touch : result.touches) {
        if (!touch.is_known) {
            ASSERT_TRUE(is_inside(test.area, touch.position, -kRounding)) << touch.position.transpose();
        }
    }
    // With its walls it is one body, and nothing to pass through.
    EXPECT_TRUE(result.topology.is_closed_oriented_manifold());
    EXPECT_EQ(result.topology.components, 1U);
    EXPECT_EQ(result.topology.euler_characteristic, 2);
    EXPECT_EQ(result.certificate.status, Certificate::Status::conditional) << result.certificate.statement;
    EXPECT_NE(result.certificate.find(Premise::Kind::within_area), nullptr);
    EXPECT_EQ(result.certificate.find(Premise::Kind::known_solids), nullptr) << "no table is in the area";

    // What was touched is a disc. It ends where the walls begin, and nowhere else.
    const TriangleMesh open = mesh_within_area(result);
    const Topology topology = analyse_topology(open);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(topology.nonmanifold_edges, 0U);
    EXPECT_GT(topology.boundary_edges, 0U);
    EXPECT_EQ(topology.euler_characteristic, 1);
    for (const Point& p : boundary_of(open)) EXPECT_FALSE(is_inside(test.area, p, 2 * test.epsilon)) << p.transpose();

    // It is right there, and nothing of what is seen from above is missing away from the walls.
    const std::optional<ToolShape> tool = tool_of(test);
    std::vector<Point> found = open.points;
    if (tool) {
        const Compensation part = compensate(traced_surface(result, points_of_touches(result)), *tool, {0, test.epsilon});
        std::size_t tips = 0;
        std::size_t beyond = 0;
        for (std::size_t v = 0; v < part.touched.size(); ++v) {
            EXPECT_EQ(part.touched[v].tag == PartTag::untouched, result.is_outside[v] != 0);
            if (part.touched[v].tag != PartTag::tip) continue;
            ++tips;
            beyond += object.distance(part.touched[v].point) > part.touched[v].uncertainty + kRounding ? 1 : 0;
        }
        EXPECT_LE(static_cast<double>(beyond), 0.01 * static_cast<double>(tips));
        EXPECT_EQ(part.report.area[static_cast<std::size_t>(PartTag::fixture)], 0) << "no wall is counted";
        EXPECT_GT(boundary_of(part.closed.mesh).size(), 0U);
        found = part.closed.mesh.points;
        std::cout << beyond << " of " << tips << " tips beyond; ";
    } else {
        for (const Point& p : found) EXPECT_LE(object.distance(p), kRounding);
    }
    if (!test.is_bunny) {
        const Box box = bounds_of(test.area);
        const double inset = 2 * test.epsilon + test.ball / 2;
        for (double x = std::max(box.min.x(), -44.0); x <= std::min(box.max.x(), 44.0); x += 1) {
            for (double y = box.min.y(); y <= box.max.y(); y += 1) {
                const Point p(x, y, height(x, y));
                if (!is_inside(test.area, p, inset)) continue;
                const auto nearest = std::ranges::min(found, {}, [&](const Point& q) { return (p - q).norm(); });
                ASSERT_LE((nearest - p).norm(), 1.2 * test.epsilon) << p.transpose();
            }
        }
    }
    const double touched = static_cast<double>(result.samples - result.known_samples);
    const double probes = static_cast<double>(result.cost.probes()) / touched;
    const double way = result.cost.displacement() / test.epsilon / touched;
    EXPECT_LE(probes, test.probes);
    EXPECT_LE(way, test.way);
    EXPECT_LE(touched, test.touched);
    std::cout << test.name << ": " << touched << " touched, " << result.known_samples << " known, " << probes << " probes, " << way
              << " way\n";
}

INSTANTIATE_TEST_SUITE_P(Parts, WithinAnArea, ::testing::Range(std::size_t{0}, cases().size()),
                         [](const auto& test) { return cases()[test.param].name; });

}  // namespace
}  // namespace palpate::area_test
