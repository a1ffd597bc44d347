// Sessions on a virtual machine in which an area alone is probed: of a sphere of 5 mm, from above, from the sides, and around a corner.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "planner/topology.h"
#include "sim/area_audit.h"
#include "sim/objects/mesh/mesh_file.h"
#include "tests/tools/session_rig.h"

namespace palpate::area_session_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Box kWorkspace{Point::Constant(-7), Point::Constant(7)};
constexpr double kResolution = 0.001;  // mm, of the machine

struct Case {
    std::string words;
    Area area;
    std::string size;  // as `check` tells it
};

const std::vector<Case>& cases() {
    static const std::vector<Case> all{
        {"{box: {min: [-3.2, -3.1, 0], max: [3.4, 3.3, 7]}}", Box{{-3.2, -3.1, 0}, {3.4, 3.3, 7}},
         "6.6 x 6.4 x 7 mm of the ball's centre; the tool comes from above\n"},
        {"{box: {min: [-9, -9, 3], max: [9, 9, 9]}}", Box{{-9, -9, 3}, {9, 9, 9}},
         "14 x 14 x 4 mm of the ball's centre; the tool comes from -x, +x, -y, +y, above\n"},
        {"{polygon: {corners: [[-4, -4], [4, -4], [4, 0], [0, 0], [0, 4], [-4, 4]], z: [-0.5, 9]}}",
         Prism{{{-4, -4}, {4, -4}, {4, 0}, {0, 0}, {0, 4}, {-4, 4}}, {-0.5, 9}},
         "8 x 8 x 7.5 mm of the ball's centre, in a polygon of 6 corners and 48 mm2; the tool comes from above\n"},
    };
    return all;
}

class AreaRig : public SessionRig {
protected:
    void write_session(const std::string& area, const std::string& more = "") const {
        std::ofstream(folder_ / "part.yaml") << "machine:\n  grbl: {port: " << port().string() << "}\n  homing: run\n"
                                             << "  origin: [-60, -50, -40]\n  limits: {min: [-15, -15, -15], max: [15, 15, 15]}\n"
                                                "  retract: 0.2\nworkspace: {box: {min: [-7, -7, -7], max: [7, 7, 7]}}\n"
                                                "probing:\n  epsilon: 0.8\n  area: "
                                             << area << "\n"
                                             << more;
    }
    [[nodiscard]] Topology topology_of(const std::string& file) const { return analyse_topology(read_triangles(folder_ / file)); }
};

class AreaSession : public AreaRig, public ::testing::WithParamInterface<std::size_t> {};

TEST_P(AreaSession, StaysInItAndGoesOnWhereItWasInterrupted) {
    const Case& test = cases()[GetParam()];
    write_session(test.words);
    AreaAudit audit(test.area, kWorkspace, kResolution);
    VirtualToolOptions options = axes();
    options.on_move = [&](const Segment& way, bool /*touched*/) { audit.record(way); };
    PortMachine machine(port(), {}, options);
    ASSERT_EQ(run({"check", "part.yaml"}), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("area           " + test.size));

    Process process = start(probe("part"));
    wait_for_probes(machine, 60);
    process.send(SIGINT);
    ASSERT_EQ(process.wait(), 3) << read("out.txt");
    ASSERT_EQ(run(resume("part")), 0) << read("out.txt");
    expect_safe(machine);
    machine.host().with([&](VirtualGrbl&) { EXPECT_EQ(audit.moves_out(), 0U); });

    const auto summary = nlohmann::json::parse(read("part/summary.json"));
    EXPECT_EQ(summary.at("euler_characteristic"), 2);
    EXPECT_EQ(summary.at("boundary_edges"), 0);
    EXPECT_EQ(summary.at("complete"), true);
    EXPECT_GT(summary.at("virtual_contacts"), 20);
    EXPECT_THAT(summary.at("certificate").dump(), HasSubstr("only within the area"));
    EXPECT_THAT(summary.at("certificate").dump(), Not(HasSubstr("fixtures")));
    // What was touched lies on the sphere; with its walls it is closed.
    EXPECT_TRUE(topology_of("part/mesh_tool.ply").is_closed_oriented_manifold());
    const Topology open = topology_of("part/mesh.ply");
    EXPECT_EQ(open.euler_characteristic, 1);
    EXPECT_GT(open.boundary_edges, 0U);
    for (const Point& p : read_triangles(folder_ / "part/mesh.ply").points) {
        EXPECT_NEAR(p.norm(), kRadius, 3 * kResolution);
        EXPECT_TRUE(is_inside(test.area, p, -kResolution));
    }
    // The same again, from the journal.
    const std::string mesh = read("part/mesh.ply");
    const std::string touches = read("part/touches.csv");
    ASSERT_EQ(run({"resume", "--replay", "part"}), 0) << read("out.txt");
    EXPECT_EQ(read("part/mesh.ply"), mesh);
    EXPECT_EQ(read("part/touches.csv"), touches);
}

INSTANTIATE_TEST_SUITE_P(Areas, AreaSession, ::testing::Range(std::size_t{0}, cases().size()));

TEST_F(AreaRig, WhatCannotBeProbedIsRefusedWithItsReason) {
    const auto refusal = [&](const std::string& area, const std::string& more = "") {
        write_session(area, more);
        EXPECT_EQ(run({"check", "part.yaml", "--offline"}), 2);
        return read("out.txt");
    };
    EXPECT_THAT(refusal("{box: {min: [-3, -3, 0], max: [3, 3, 6]}}"),
                HasSubstr("probing.area: no face of the workspace leads into the area"));
    EXPECT_THAT(refusal("{box: {min: [-3, -3, -7], max: [3, 3, 7]}}"), HasSubstr("only two that face each other"));
    EXPECT_THAT(refusal("{box: {min: [-1, -3, 0], max: [1, 3, 7]}}"), HasSubstr("less than 4 epsilon on a side"));
    EXPECT_THAT(refusal("{box: {min: [8, -3, 0], max: [9, 3, 7]}}"), HasSubstr("probing.area: lies outside workspace.box"));
    EXPECT_THAT(refusal("{box: {min: [-3, -3, 0], max: [3, 3, 7]}}", "  strategy: {infer: reach}\n  reach: 4.9\n"),
                HasSubstr("infer: reach proves nothing"));
}

TEST_F(AreaRig, AnAreaWithoutThePartSaysSoAndTheToolIsBackOutside) {
    write_session("{box: {min: [2, 2, 4.7], max: [6, 6, 7.9]}}", "  seed_rays: []\n");
    AreaAudit audit(Box{{2, 2, 4.7}, {6, 6, 8}}, kWorkspace, kResolution);
    VirtualToolOptions options = axes();
    options.on_move = [&](const Segment& way, bool /*touched*/) { audit.record(way); };
    PortMachine machine(port(), {}, options);
    EXPECT_NE(run({"probe", "part.yaml", "-o", "part", "--yes", "--set", "probing.epsilon=0.5"}), 0);
    EXPECT_THAT(read("out.txt"), HasSubstr("probing.seed_rays"));
    machine.host().with([&](VirtualGrbl&) { EXPECT_EQ(audit.moves_out(), 0U); });
}

}  // namespace
}  // namespace palpate::area_session_test
