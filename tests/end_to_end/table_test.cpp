// Parts on a table, probed with a ball on a stylus: what S* becomes, what that costs, and what it says of the part.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/device_oracle.h"
#include "planner/grown_fixtures.h"
#include "planner/part/part_surface.h"
#include "planner/part/traced_surface.h"
#include "planner/probe_surface.h"
#include "sim/simulated_device.h"
#include "sim/tool/tool_audit.h"
#include "sim/tool/tool_obstacle.h"
#include "tests/end_to_end/part_meshes.h"
#include "tests/end_to_end/temporary_mesh.h"

namespace palpate::table_test {
namespace {

constexpr double kClearance = 0.002;  // mm

struct Part {
    std::string name;
    TriangleMesh mesh;  // mm, on the table; empty: the bunny, 100 mm
    double ball = 0.0;  // mm: diameters
    double stylus = 0.0;
    double epsilon = 0.0;
    // What it may cost: some 10 % above what was measured.
    double probes = 0.0;  // per touched sample
    double way = 0.0;     // in ε per touched sample
    // Share of what the ball touched that may be ambiguous: some 20 % above what was measured.
    double ambiguous = 0.03;
    std::vector<Box> clamps{};
    std::vector<Segment> seed_rays{};
};

// Its lowest point is on the table.
TriangleMesh lifted(TriangleMesh mesh, double scale) {
    double lowest = 0;
    for (Point& p : mesh.points) {
        p *= scale;
        lowest = std::min(lowest, p.z());
    }
    for (Point& p : mesh.points) p.z() -= lowest;
    return mesh;
}

// 60 × 40 × 20 mm with a pocket, a boss in it and a through hole.
TriangleMesh machined() {
    std::set<std::array<int, 3>> cells;
    for (int i = 0; i < 7; ++i) {
        for (int j = 0; j < 5; ++j) {
            for (int k = 0; k < 2; ++k) {
                const bool is_pocket = i >= 1 && i <= 3 && j >= 1 && j <= 3 && k == 1;
                const bool is_boss = i == 2 && j == 2;
                const bool is_hole = i == 5 && j == 2;
                if ((!is_pocket || is_boss) && !is_hole) cells.insert({i, j, k});
            }
        }
    }
    return lifted(of_cells({{{-30, -24, -14, -7, 3, 9, 21, 30}, {-20, -16, -5, 5, 16, 20}, {0, 8, 20}}}, cells), 1);
}

// A plate on a narrower block: what is below the plate is out of reach.
TriangleMesh undercut() {
    return lifted(of_cells({{{-20, -10, 10, 20}, {-15, -8, 8, 15}, {0, 15, 22}}},
                           {{1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {2, 0, 1}, {0, 1, 1}, {1, 1, 1}, {2, 1, 1}, {0, 2, 1}, {1, 2, 1}, {2, 2, 1}}),
                  1);
}

TriangleMesh two_blocks() {
    TriangleMesh mesh;
    append(mesh, lifted(box({16, 14, 12}), 1), {-17, 0, 0});
    append(mesh, lifted(cone(48, 9, 18), 1), {17, 0, 0});
    return mesh;
}

const std::vector<Part>& parts() {
    static const std::vector<Part> all{
        {"bunny", {}, 6, 4, 4, 2.0, 8.5, 0.21},
        {"bunny_fine", {}, 6, 4, 2.5, 1.45, 5.0, 0.08},
        {"bunny_finer", {}, 6, 4, 1.5, 1.4, 7.4, 0.04},
        {"bunny_small_ball", {}, 2, 1.5, 2.5, 1.9, 8.0, 0.22},
        {"machined", machined(), 3, 2, 1.5, 1.75, 7.0},
        {"undercut", undercut(), 3, 2, 1.2, 1.5, 6.0},
        {"two_blocks", two_blocks(), 3, 2, 1.2, 1.8, 7.0, 0.03, {}, {{{-17, 0, 60}, {-17, 0, 0}}, {{17, 0, 60}, {17, 0, 0}}}},
        {"clamped", lifted(box({40, 24, 12}), 1), 3, 2, 1.5, 2.3, 9.5, 0.03, {{{-34, -6, 0}, {-14, 6, 18}}, {{14, -6, 0}, {34, 6, 18}}}},
    };
    return all;
}

// What is said of touches, beside which part of the tool made them.
struct Tally {
    std::size_t by_ball = 0;
    std::size_t called_shadow = 0;
    std::size_t called_ambiguous = 0;
    std::size_t by_stylus = 0;
    std::size_t shadow_tips = 0;      // called tip
    std::size_t shadows_far_off = 0;  // ... and farther from the part than stated
    std::size_t tips = 0;
    std::size_t beyond = 0;  // farther from the part than stated
    double farthest = 0.0;   // mm, of these
};

Tally tally_of(const TracedSurface& traced, const Compensation& found, const ToolDepths& depths, const HiddenObject& object) {
    constexpr double kTouches = 1e-6;  // mm
    Tally tally;
    for (std::size_t k = 0; k < found.touched.size(); ++k) {
        const TouchedPoint& at = found.touched[k];
        EXPECT_EQ(at.tag == PartTag::fixture, traced.is_fixture[k] != 0);
        if (at.tag == PartTag::fixture) continue;
        const std::optional<ToolContact> contact = depths.touching(traced.mesh.points[k], kTouches);
        EXPECT_TRUE(contact);
        if (!contact) continue;
        const double beyond = object.distance(at.point) - at.uncertainty;
        const bool is_tip = at.tag == PartTag::tip;
        const bool is_beyond = is_tip && beyond > kTouches;
        if (contact->part == ToolContact::Part::ball) {
            ++tally.by_ball;
            tally.called_shadow += at.tag == PartTag::shadow ? 1 : 0;
            tally.called_ambiguous += at.tag == PartTag::ambiguous ? 1 : 0;
        } else {
            ++tally.by_stylus;
            tally.shadow_tips += is_tip ? 1 : 0;
            tally.shadows_far_off += is_beyond ? 1 : 0;
        }
        tally.tips += is_tip ? 1 : 0;
        tally.beyond += is_beyond ? 1 : 0;
        if (is_tip) tally.farthest = std::max(tally.farthest, beyond);
    }
    return tally;
}

class OnATable : public ::testing::TestWithParam<std::size_t> {};

TEST_P(OnATable, EndsRightAndSaysWhatItKnows) {
    const Part& part = parts()[GetParam()];
    const bool is_bunny = part.mesh.triangles.empty();
    std::optional<TemporaryMesh> file;
    if (!is_bunny) file.emplace(part.mesh, part.name);
    MeshSpec spec;
    spec.file = is_bunny ? std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off" : file->path();
    if (is_bunny) {
        spec.scale = 10;
        spec.rotate = {std::numbers::pi / 2, 0, 0};
    }
    const HiddenObject object{ObjectSpec(spec)};
    ToolShape tool;
    tool.ball_diameter = part.ball;
    tool.stylus = ToolShape::Shaft{part.stylus, 150};
    Fixtures fixtures;
    fixtures.solids.emplace_back(Table{0});
    for (const Box& clamp : part.clamps) fixtures.solids.emplace_back(clamp);
    const double margin = part.ball + 4 * part.epsilon;
    Box workspace = object.bounds();
    for (const Box& clamp : part.clamps) {
        workspace.min = workspace.min.cwiseMin(clamp.min);
        workspace.max = workspace.max.cwiseMax(clamp.max);
    }
    workspace.min -= Vector::Constant(margin);
    workspace.max += Vector::Constant(margin);
    const Surroundings surroundings = surroundings_with(workspace, fixtures, tool, kClearance, part.epsilon);

    const ToolObstacle obstacle(object, tool, fixtures.solids);
    const ToolDepths depths(object, tool, fixtures.solids);
    ToolAudit audit(depths);
    SimulatedDeviceOptions device_options;
    device_options.audit = false;  // of points
    device_options.on_move = [&](const Segment& way, bool touched) { audit.record(way, touched); };
    SimulatedDevice device(obstacle, workspace.center() + 2 * workspace.diagonal() * Vector::UnitZ(), device_options);
    DeviceOracle oracle(device, {}, DeviceOracle::Positions::exact);
    Options options;
    options.epsilon = part.epsilon;
    options.strategy = Strategy::adaptive();
    options.seed_rays = part.seed_rays;
    for (Segment& ray : options.seed_rays) ray.source.z() = workspace.max.z() + 1;
    const Result result = probe_surface(oracle, surroundings, options);

    const double touched = static_cast<double>(result.samples - result.known_samples);
    const double probes = static_cast<double>(result.cost.probes()) / touched;
    const double way = result.cost.displacement() / part.epsilon / touched;
    // One body with the table, and nothing to pass through: a stylus that is longer than the part leaves no handle.
    EXPECT_TRUE(result.topology.is_closed_oriented_manifold());
    EXPECT_EQ(result.topology.components, 1U);
    EXPECT_EQ(result.topology.euler_characteristic, 2);
    EXPECT_NE(result.certificate.status, Certificate::Status::incomplete) << result.certificate.statement;
    EXPECT_EQ(audit.account().unsafe_moves, 0U);
    EXPECT_EQ(audit.account().moves_into_fixtures, 0U);
    EXPECT_EQ(audit.account().touches(ToolContact::Part::ball, ToolContact::Met::fixture), 0U);
    EXPECT_EQ(audit.account().touches(ToolContact::Part::stylus, ToolContact::Met::fixture), 0U);
    EXPECT_LE(probes, part.probes);
    EXPECT_LE(way, part.way);

    const TracedSurface traced = traced_surface(result, points_of_touches(result));
    const Compensation found = compensate(traced, tool, {0, part.epsilon});
    const Tally tally = tally_of(traced, found, depths, object);
    // A shadow is never measured, and what is stated of the rest holds.
    EXPECT_EQ(tally.shadows_far_off, 0U);
    EXPECT_LE(static_cast<double>(tally.beyond), 0.01 * static_cast<double>(tally.tips));
    // What the ball touched is hardly ever called a shadow, and for the most part what it is.
    EXPECT_LE(static_cast<double>(tally.called_shadow), 0.01 * static_cast<double>(tally.by_ball));
    EXPECT_LE(static_cast<double>(tally.called_ambiguous), part.ambiguous * static_cast<double>(tally.by_ball));
    const PartReport& report = found.report;
    std::cout << part.name << ": " << touched << " touched, " << result.known_samples << " known, " << probes << " probes, " << way
              << " way; " << tally.beyond << " of " << tally.tips << " tips beyond, by " << tally.farthest << " mm at most; of "
              << tally.by_ball << " of the ball's " << tally.called_shadow << " shadow, " << tally.called_ambiguous << " ambiguous; of "
              << tally.by_stylus << " of the stylus' " << tally.shadow_tips << " tip; stated median " << report.uncertainty_median
              << ", 95 % " << report.uncertainty_95 << " mm\n";
}

INSTANTIATE_TEST_SUITE_P(Parts, OnATable, ::testing::Range(std::size_t{0}, parts().size()),
                         [](const auto& test) { return parts()[test.param].name; });

}  // namespace
}  // namespace palpate::table_test
