#include "config/reader.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "config/writer.h"
#include "tests/config/support.h"

namespace palpate::reader_test {
namespace {

const std::string kProbing = "probing: {epsilon: 0.25}\n";

class Reader : public testing::Test {
protected:
    [[nodiscard]] SessionConfig read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
        return read_config(folder_.write("s.yaml", text), overrides);
    }

    // What the reader says about `text`, without the folder.
    [[nodiscard]] std::string complaint(const std::string& text, const std::vector<std::string>& overrides = {}) const {
        try {
            (void)read(text, overrides);
        } catch (const ConfigError& error) {
            const std::string message = error.what();
            const std::string prefix = folder_.path().string() + "/";
            return message.rfind(prefix, 0) == 0 ? message.substr(prefix.size()) : message;
        }
        return "nothing";
    }

    // The one object in `text`, a value of `object.shape`.
    [[nodiscard]] ShapeSpec shape(const std::string& text) const {
        return std::get<ShapeSpec>(read("object: {shape: " + text + "}\n" + kProbing).object.value());
    }
    [[nodiscard]] std::string shape_complaint(const std::string& text) const {
        return complaint(kProbing + "object:\n  shape: " + text + "\n");
    }

    test::TemporaryFolder folder_;
};

TEST_F(Reader, FillsInDefaults) {
    const SessionConfig config = read(kProbing);
    EXPECT_FALSE(config.object.has_value());
    EXPECT_TRUE(std::holds_alternative<AutoWorkspace>(config.workspace));
    EXPECT_EQ(config.probing.epsilon, 0.25);
    EXPECT_FALSE(config.probing.reach.has_value());
    EXPECT_EQ(config.probing.strategy, Strategy{});
    EXPECT_TRUE(config.probing.seed_rays.empty());
    EXPECT_EQ(config.probing.refinement_floor, 0.125);
    EXPECT_EQ(config.probing.random_seed, 1U);
}

TEST_F(Reader, ReadsEveryKeyOfASession) {
    const SessionConfig config = read(
        "object: {mesh: sub/../part.off, scale: 2.5, at: [1, 2, 3], rotate: [90, 0, -180], repair: false}\n"
        "workspace: {box: {min: [-1, -2, -3], max: [1, 2, 3e0]}}\n"
        "probing:\n"
        "  epsilon: +0.05\n"
        "  reach: 0.4\n"
        "  strategy: {refine: exhaustive}\n"
        "  seed_rays: [{from: [0, 0, 9], to: [0, 0, 0]}]\n"
        "  refinement_floor: 1\n"
        "random_seed: 18446744073709551615\n");
    const auto& mesh = std::get<MeshSpec>(config.object.value());
    EXPECT_EQ(mesh.file, folder_.path() / "part.off");
    EXPECT_EQ(mesh.scale, 2.5);
    EXPECT_EQ(mesh.at, Point(1, 2, 3));
    EXPECT_EQ(mesh.rotate, Vector(std::numbers::pi / 2, 0, -std::numbers::pi));
    EXPECT_FALSE(mesh.repair);
    EXPECT_EQ(std::get<Box>(config.workspace).min, Point(-1, -2, -3));
    EXPECT_EQ(std::get<Box>(config.workspace).max, Point(1, 2, 3));
    EXPECT_EQ(config.probing.epsilon, 0.05);
    EXPECT_EQ(config.probing.reach, 0.4);
    EXPECT_EQ(config.probing.strategy.refine, Strategy::Refine::exhaustive);
    EXPECT_EQ(config.probing.strategy.explore, Strategy::Explore::closure);
    ASSERT_EQ(config.probing.seed_rays.size(), 1U);
    EXPECT_EQ(config.probing.seed_rays[0].source, Point(0, 0, 9));
    EXPECT_EQ(config.probing.seed_rays[0].target, Point(0, 0, 0));
    EXPECT_EQ(config.probing.refinement_floor, 1.0);
    EXPECT_EQ(config.probing.random_seed, std::numeric_limits<std::uint64_t>::max());
}

TEST_F(Reader, ReadsToolsAndFixtures) {
    const SessionConfig plain = read(kProbing);
    EXPECT_FALSE(plain.tool);
    EXPECT_TRUE(plain.fixtures.solids.empty() && !plain.fixtures.clearance && plain.fixtures.assume_clear);
    const SessionConfig floating = read("tool: {ball: {diameter: 2}}\n" + kProbing);
    EXPECT_EQ(floating.tool.value().ball_diameter, 2);
    EXPECT_FALSE(floating.tool->stylus || floating.tool->holder);
    EXPECT_EQ(floating.tool->axis, Vector(0, 0, 1));
    const SessionConfig config = read(
        "tool:\n  ball: {diameter: 2}\n  stylus: {diameter: 1.5, length: 30, axis: [0, 3, 4]}\n  holder: {diameter: 20, length: 40}\n"
        "workspace:\n  box: {min: [0, 0, 0], max: [9, 9, 9]}\n"
        "  fixtures: [{table: {z: 1}}, {box: {min: [0, 0, 1], max: [2, 2, 3]}}, {half_space: {point: [1, 2, 3], normal: [-2, 0, 0]}}]\n"
        "  clearance: 0.5\n  assume_clear: false\n" +
        kProbing);
    EXPECT_EQ(config.tool.value().stylus.value().length, 30);
    EXPECT_LT((config.tool->axis - Vector(0, 0.6, 0.8)).norm(), 1e-15) << "of length 1, whatever was given";
    EXPECT_EQ(config.tool->holder.value().diameter, 20);
    ASSERT_EQ(config.fixtures.solids.size(), 3U);
    EXPECT_EQ(std::get<Table>(config.fixtures.solids[0]).z, 1);
    EXPECT_EQ(std::get<Box>(config.fixtures.solids[1]).max, Point(2, 2, 3));
    EXPECT_EQ(std::get<HalfSpace>(config.fixtures.solids[2]).normal, Vector(-1, 0, 0));
    EXPECT_EQ(config.fixtures.clearance, 0.5);
    EXPECT_FALSE(config.fixtures.assume_clear);
}

TEST_F(Reader, ReadsAreas) {
    EXPECT_FALSE(read(kProbing).area);
    EXPECT_EQ(write_config(read(kProbing)).find("area"), std::string::npos) << "what is not given is not written";
    const std::string begin = "workspace: {box: {min: [0, 0, 0], max: [9, 9, 9]}}\nprobing:\n  epsilon: 1\n  area: ";
    const SessionConfig box = read(begin + "{box: {min: [1, 2, 3], max: [4, 5, 99]}}\n");
    EXPECT_EQ(std::get<Box>(box.area.value()).max, Point(4, 5, 99));
    EXPECT_EQ(box.probing.strategy.infer, Strategy::Infer::adaptive) << "walls make creases";
    const SessionConfig polygon = read(begin + "{polygon: {corners: [[1, 2], [8, 2], [3, 7]], z: [4, 20]}}\n");
    const auto& prism = std::get<Prism>(polygon.area.value());
    ASSERT_EQ(prism.corners.size(), 3U);
    EXPECT_EQ(prism.corners[2], Eigen::Vector2d(3, 7));
    EXPECT_EQ(prism.z[1], 20);
    const SessionConfig any_height = read(begin + "{polygon: {corners: [[1, 2], [8, 2], [3, 7]]}}\n");
    EXPECT_EQ(std::get<Prism>(any_height.area.value()).z[0], -1'000'000);
}

TEST_F(Reader, RefusesAreasThatCannotBe) {
    const auto area = [this](const std::string& value, const std::string& workspace = "{box: {min: [0, 0, 0], max: [9, 9, 9]}}") {
        return complaint("workspace: " + workspace + "\nprobing: {epsilon: 1, area: " + value + "}\n");
    };
    const std::string start = "s.yaml:2: probing.area";
    EXPECT_EQ(area("{}"), start + ": holds none of its alternatives; allowed: exactly one of box, polygon");
    EXPECT_EQ(area("{box: {min: [1, 1, 1], max: [2, 2, 2]}}", "{ball: {center: [0, 0, 0], radius: 9}}"),
              start + ": has no box around it; allowed: with workspace.box only");
    EXPECT_EQ(area("{box: {min: [1, 1, 1], max: [2, 2, 2]}}", "auto"), start + ": has no box around it; allowed: with workspace.box only");
    EXPECT_EQ(area("{box: {min: [1, 1, 9], max: [2, 2, 12]}}"), start + ": lies outside workspace.box; allowed: one that has some of it");
    EXPECT_EQ(area("{box: {min: [1, 1, 3], max: [2, 2, 3]}}"),
              start + ".box.max: is not greater than min in each coordinate; allowed: greater than min in x, y and z (mm)");
    const std::string allowed = "; allowed: at least 3 corners, in order around the area, with edges that do not meet elsewhere (mm)";
    EXPECT_EQ(area("{polygon: {corners: [[1, 1], [2, 2]]}}"), start + ".polygon.corners: has 2 corner(s)" + allowed);
    EXPECT_EQ(area("{polygon: {corners: [[0, 0], [2, 2], [2, 0], [0, 2]]}}"),
              start + ".polygon.corners: crosses itself, or goes back along itself" + allowed);
    EXPECT_EQ(area("{polygon: {corners: [[1, 1], [2, 1], [2, 2]], z: [3, 3]}}"),
              start + ".polygon.z: does not rise; allowed: [low, high], high greater than low (mm)");
    EXPECT_EQ(area("{polygon: {corners: [[1, 1], [2, 1], [2]]}}"),
              start +
                  ".polygon.corners[2]: a list of 1 is not a list of 2 numbers; allowed: 2 numbers in brackets, each from -1000000 to "
                  "1000000 (mm)");
    EXPECT_EQ(area("{polygon: {corners: 5}}"),
              start + ".polygon.corners: 5 is not a list of pairs; allowed: [[x, y], ...], each number from -1000000 to 1000000 (mm)");
    EXPECT_EQ(area("{polygon: {z: [1, 2]}}"), start + ".polygon.corners: is required; allowed: from -1000000 to 1000000 (mm)");
}

TEST_F(Reader, ReadsErrorsOfASimulatedProbe) {
    const std::string begin =
        "tool: {ball: {diameter: 2}, stylus: {diameter: 1, length: 20, axis: [0, 3, 4]}}\nprobing: {epsilon: 1}\nrandom_seed: 7\n";
    const SessionConfig none = read_config_text(begin, "s.yaml");
    EXPECT_FALSE(none.errors);
    EXPECT_FALSE(none.probe_errors().is_any());
    EXPECT_EQ(none.traits().touch_error, 0.0);
    EXPECT_EQ(write_config(none).find("simulation"), std::string::npos) << "what holds nothing is not written";
    const SessionConfig config = read_config_text(
        begin +
            "simulation: {errors: {sigma: 0.001, lobes: 0.04, latency: 0.002, harmonics: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], "
            "trigger_force: 0.1, compliance_across: 0.3, compliance_along: 0.01, backlash: [0.01, 0.02, 0], drift: {per_hour: [0, 0, "
            "-0.01], per_1000_touches: [1, 2, 3], swing: [0, 0, 0.5], period: 60}, false_triggers: 0.01, misses: 0.02, bounces: 0.03}}",
        "s.yaml");
    const ProbeErrors errors = config.probe_errors();
    EXPECT_EQ(errors.sigma_mm, 0.001);
    EXPECT_EQ(errors.lobes_mm, 0.04);
    EXPECT_EQ(errors.latency, Seconds(0.002));
    EXPECT_EQ(errors.harmonics_mm[11], 12);
    EXPECT_EQ(errors.trigger_force_n, 0.1);
    EXPECT_EQ(errors.compliance_across_mm_per_n, 0.3);
    EXPECT_EQ(errors.compliance_along_mm_per_n, 0.01);
    EXPECT_EQ(errors.backlash_mm, Vector(0.01, 0.02, 0));
    EXPECT_EQ(errors.drift_mm_per_hour, Vector(0, 0, -0.01));
    EXPECT_EQ(errors.drift_mm_per_1000_touches, Vector(1, 2, 3));
    EXPECT_EQ(errors.swing_mm, Vector(0, 0, 0.5));
    EXPECT_EQ(errors.swing_period, Seconds(60));
    EXPECT_EQ(errors.false_triggers, 0.01);
    EXPECT_EQ(errors.misses, 0.02);
    EXPECT_EQ(errors.bounces, 0.03);
    EXPECT_EQ(errors.axis, Vector(0, 0.6, 0.8)) << "that of the tool";
    EXPECT_EQ(errors.seed, 7U) << "that of the run";
    EXPECT_GT(config.traits().touch_error, 0.08) << "told to the planner where no machine says it";
}

TEST_F(Reader, RefusesErrorsThatAreNone) {
    const auto errors = [this](const std::string& value) { return complaint(kProbing + "simulation: " + value); };
    const std::string start = "s.yaml:2: simulation.errors";
    EXPECT_EQ(errors("{}"), start + ": is required; allowed: a mapping of the keys below it");
    EXPECT_EQ(errors("{errors: {sigma: -1}}"), start + ".sigma: -1 is out of range; allowed: from 0 to 1000000 (mm)");
    EXPECT_EQ(errors("{errors: {misses: 1.5}}"), start + ".misses: 1.5 is out of range; allowed: from 0 to 1");
    EXPECT_EQ(
        errors("{errors: {harmonics: [1, 2]}}"),
        start + ".harmonics: a list of 2 is not a list of 12 numbers; allowed: 12 numbers in brackets, each from -1000000 to 1000000 (mm)");
    EXPECT_EQ(errors("{errors: {drift: {period: 0}}}"), start + ".drift.period: 0 is out of range; allowed: greater than 0 (s)");
}

TEST_F(Reader, RefusesToolsThatAreNone) {
    const auto tool = [this](const std::string& value) { return complaint(kProbing + "tool: " + value); };
    const std::string start = "s.yaml:2: tool";
    EXPECT_EQ(tool("{}"), start + ".ball: is required; allowed: a mapping of the keys below it");
    EXPECT_EQ(tool("{ball: {diameter: 0}}"), start + ".ball.diameter: 0 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(tool("{ball: {diameter: 1}, stylus: {diameter: 1.1, length: 9}}"),
              start + ".stylus: is thicker than the ball; allowed: a diameter of at most that of the ball (mm)");
    EXPECT_EQ(tool("{ball: {diameter: 1}, holder: {diameter: 9, length: 9}}"),
              start + ".holder: has no stylus that it could hold; allowed: with tool.stylus only");
    EXPECT_EQ(tool("{ball: {diameter: 1}, stylus: {diameter: 1, length: 9, axis: [0, 0, 0]}}"),
              start + ".stylus.axis: has no direction; allowed: [x, y, z], not all 0");
}

TEST_F(Reader, RefusesFixturesThatLeaveNothingAndThoseBesideABall) {
    const std::string box = "box: {min: [0, 0, 0], max: [1, 1, 1]}";
    const auto workspace = [this](const std::string& value) { return complaint(kProbing + "workspace: {" + value + "}"); };
    const std::string start = "s.yaml:2: workspace";
    EXPECT_EQ(workspace("ball: {center: [0, 0, 0], radius: 1}, fixtures: [{table: {z: -0.5}}]"),
              start + ".fixtures: stand beside a ball; allowed: with workspace.box only");
    EXPECT_EQ(workspace("fixtures: [{table: {z: 0}}]"), start + ": holds none of its alternatives; allowed: exactly one of ball, box");
    const std::string covered =
        start + ".fixtures: one of them covers the whole workspace; allowed: those that leave some of workspace.box free";
    EXPECT_EQ(workspace(box + ", fixtures: [{table: {z: 1}}]"), covered);
    EXPECT_EQ(workspace(box + ", fixtures: [{half_space: {point: [0, 0, 0], normal: [-1, 0, 0]}}]"), covered);
    EXPECT_EQ(workspace(box + ", fixtures: [{table: {z: 0}}, {box: {min: [-1, -1, -1], max: [1, 1, 1]}}]"), covered);
    EXPECT_EQ(workspace(box + ", fixtures: [{}]"),
              start + ".fixtures[0]: holds none of its alternatives; allowed: exactly one of table, box, half_space");
    EXPECT_EQ(workspace(box + ", fixtures: [{half_space: {point: [0, 0, 0], normal: [0, 0, 0]}}]"),
              start + ".fixtures[0].half_space.normal: has no direction; allowed: [x, y, z], not all 0");
    EXPECT_EQ(workspace(box + ", fixtures: [{table: {z: 0.99}}]"), "nothing");
}

TEST_F(Reader, ReadsWordsForStrategies) {
    EXPECT_EQ(read("probing: {epsilon: 1, strategy: thesis}").probing.strategy, Strategy::thesis());
    EXPECT_EQ(read("probing: {epsilon: 1, strategy: adaptive}").probing.strategy, Strategy::adaptive());
    EXPECT_EQ(read("probing: {epsilon: 1, strategy: default}").probing.strategy, Strategy{});
}

TEST_F(Reader, ReadsEveryShape) {
    EXPECT_EQ(std::get<SphereSpec>(shape("{sphere: {radius: 2}}").kind).radius, 2.0);
    EXPECT_EQ(std::get<EllipsoidSpec>(shape("{ellipsoid: {semi_axes: [3, 2, 1]}}").kind).semi_axes, Vector(3, 2, 1));
    const ShapeSpec torus = shape("{torus: {major: 1, minor: 0.4}, at: [0, 0, 1], rotate: [90, 0, -180]}");
    EXPECT_EQ(std::get<TorusSpec>(torus.kind).major, 1.0);
    EXPECT_EQ(std::get<TorusSpec>(torus.kind).minor, 0.4);
    EXPECT_EQ(torus.at, Point(0, 0, 1));
    EXPECT_EQ(torus.rotate, Vector(std::numbers::pi / 2.0, 0.0, -std::numbers::pi));
    EXPECT_EQ(std::get<CapsuleSpec>(shape("{capsule: {radius: 2, length: 0}}").kind).length, 0.0);
    EXPECT_EQ(std::get<RoundedBoxSpec>(shape("{rounded_box: {size: [4, 3, 0.6], fillet: 0.3}}").kind).fillet, 0.3);
    EXPECT_EQ(std::get<Genus2Spec>(shape("{genus2: {scale: 3}}").kind).scale, 3.0);
}

TEST_F(Reader, ReadsNestedUnions) {
    const ShapeSpec outer = shape("{union: {parts: [{sphere: {radius: 1}}, {union: {parts: [{genus2: {scale: 2}}]}, at: [9, 0, 0]}]}}");
    const auto& parts = std::get<std::vector<ShapeSpec>>(outer.kind);
    ASSERT_EQ(parts.size(), 2U);
    EXPECT_EQ(std::get<SphereSpec>(parts[0].kind).radius, 1.0);
    EXPECT_EQ(parts[1].at, Point(9, 0, 0));
    EXPECT_EQ(std::get<Genus2Spec>(std::get<std::vector<ShapeSpec>>(parts[1].kind).at(0).kind).scale, 2.0);
}

// What ".." means behind a link is the system's business, not the text's.
TEST_F(Reader, FollowsLinksOfFoldersInMeshPaths) {
    std::filesystem::create_directories(folder_.path() / "real/inner");
    std::filesystem::create_directory_symlink(folder_.path() / "real/inner", folder_.path() / "link");
    const SessionConfig config = read("object: {mesh: link/../part.off}\n" + kProbing);
    EXPECT_EQ(std::get<MeshSpec>(config.object.value()).file, folder_.path() / "real/part.off");
}

TEST_F(Reader, RefusesNumbersWithLineAndRange) {
    EXPECT_EQ(complaint("# a\n\nprobing:\n  epsilon: -1\n"),
              "s.yaml:4: probing.epsilon: -1 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    const auto epsilon = [this](const std::string& value) { return complaint("probing:\n  epsilon: " + value); };
    const std::string start = "s.yaml:2: probing.epsilon: ";
    const std::string allowed = "; allowed: greater than 0, at most 1000000 (mm)";
    EXPECT_EQ(epsilon("0"), start + "0 is out of range" + allowed);
    EXPECT_EQ(epsilon(".nan"), start + ".nan is not finite" + allowed);
    EXPECT_EQ(epsilon("nan"), start + "nan is not finite" + allowed);
    EXPECT_EQ(epsilon("+.inf"), start + "+.inf is not finite" + allowed);
    EXPECT_EQ(epsilon("infinity"), start + "infinity is beyond the range of floating-point numbers" + allowed);
    EXPECT_EQ(epsilon("1e999"), start + "1e999 is beyond the range of floating-point numbers" + allowed);
    EXPECT_EQ(epsilon("0.25mm"), start + "0.25mm is not a number" + allowed);
    EXPECT_EQ(epsilon("0,25"), start + "0,25 is not a number" + allowed);
    EXPECT_EQ(epsilon("'0.25'"), start + "\"0.25\" is not a number" + allowed);
    EXPECT_EQ(epsilon("0x1p3"), start + "0x1p3 is not a number" + allowed);
    EXPECT_EQ(epsilon("[1]"), start + "a list is not a number" + allowed);
    EXPECT_EQ(epsilon("{a: 1}"), start + "a mapping is not a number" + allowed);
    EXPECT_EQ(epsilon(""), start + "null is not a number" + allowed);
    EXPECT_EQ(complaint("probing: {epsilon: 1, reach: 0}"),
              "s.yaml:1: probing.reach: 0 is out of range; allowed: greater than 0, at most 1000000 (mm), or null");
    EXPECT_EQ(complaint("probing: {epsilon: 1,\n refinement_floor: 1.5}"),
              "s.yaml:2: probing.refinement_floor: 1.5 is out of range; allowed: greater than 0, at most 1");
}

TEST_F(Reader, RefusesSeedsThatAreNotWholeNumbers) {
    const std::string allowed = "; allowed: from 0 to 18446744073709551615";
    for (const char* value : {"-1", "1.0", "1e3", "one", "[1]", "'1'", "+1"}) {
        const std::string spelled = value == std::string("[1]") ? "a list" : value == std::string("'1'") ? "\"1\"" : value;
        EXPECT_EQ(complaint(kProbing + "random_seed: " + value), "s.yaml:2: random_seed: " + spelled + " is not a whole number" + allowed);
    }
    EXPECT_EQ(complaint(kProbing + "random_seed: 18446744073709551616"),
              "s.yaml:2: random_seed: 18446744073709551616 is out of range" + allowed);
}

TEST_F(Reader, RefusesUnknownKeysAndSuggestsNearOnes) {
    EXPECT_EQ(complaint("probing:\n  epsilom: 0.25\n"),
              "s.yaml:2: probing.epsilom: unknown key; did you mean \"epsilon\"?; allowed: epsilon, reach, strategy, standoff, tolerance, "
              "spacing_min, tolerance_box, trust, audit, "
              "seed_rays, refinement_floor, sizing, min_angle, budget, earlier, earlier_limit, area");
    EXPECT_EQ(complaint(kProbing + "colour: red\n"),
              "s.yaml:2: colour: unknown key; allowed: object, machine, tool, simulation, workspace, probing, results, random_seed");
    EXPECT_EQ(complaint(kProbing + "workspace: {ball: {centre: [0, 0, 0], radius: 1}}"),
              "s.yaml:2: workspace.ball.centre: unknown key; did you mean \"center\"?; allowed: center, radius");
    EXPECT_EQ(complaint(kProbing + "workspace: {bal: {}}"),
              "s.yaml:2: workspace.bal: unknown key; did you mean \"ball\"?; allowed: ball, box, fixtures, clearance, assume_clear");
    EXPECT_EQ(shape_complaint("{spere: {radius: 1}}").substr(0, 71),
              "s.yaml:3: object.shape.spere: unknown key; did you mean \"sphere\"?; allo");
    EXPECT_EQ(complaint("probing: {epsilon: 1, strategy: {Refine: eager}}"),
              "s.yaml:1: probing.strategy.Refine: unknown key; did you mean \"refine\"?; allowed: refine, explore, infer, travel");
}

TEST_F(Reader, RefusesMissingKeys) {
    EXPECT_EQ(complaint("random_seed: 1\n"), "s.yaml:1: probing: is required; allowed: a mapping of the keys below it");
    EXPECT_EQ(complaint("\nprobing:\n  reach: null\n"),
              "s.yaml:2: probing.epsilon: is required; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(shape_complaint("\n    torus: {major: 1}"),
              "s.yaml:4: object.shape.torus.minor: is required; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(complaint("probing:\n  epsilon: 1\n  seed_rays:\n    - {from: [0, 0, 1]}\n"),
              "s.yaml:4: probing.seed_rays[0].to: is required; allowed: from -1000000 to 1000000 (mm)");
}

TEST_F(Reader, RefusesKeysThatExcludeEachOther) {
    EXPECT_EQ(complaint(kProbing + "object:\n  mesh: a.off\n  shape: {sphere: {radius: 1}}\n"),
              "s.yaml:4: object: holds mesh and shape; allowed: exactly one of mesh, shape");
    EXPECT_EQ(complaint(kProbing + "object: {}\n"),
              "s.yaml:2: object: holds none of its alternatives; allowed: exactly one of mesh, shape");
    EXPECT_EQ(complaint(kProbing + "object:\n  shape: {sphere: {radius: 1}}\n  scale: 2\n"),
              "s.yaml:4: object.scale: goes with mesh only; allowed: the measures of the shape");
    for (const auto& [key, allowed] : {std::pair{"at: [1, 2, 3]", "at of the shape"}, std::pair{"rotate: [1, 2, 3]", "rotate of the shape"},
                                       std::pair{"repair: true", "nothing, a shape needs none"}}) {
        const std::string name = std::string(key).substr(0, std::string(key).find(':'));
        EXPECT_EQ(complaint(kProbing + "object:\n  shape: {sphere: {radius: 1}}\n  " + key + "\n"),
                  "s.yaml:4: object." + name + ": goes with mesh only; allowed: " + allowed);
    }
    EXPECT_EQ(shape_complaint("{sphere: {radius: 1}, genus2: {scale: 1}}"),
              "s.yaml:3: object.shape: holds sphere and genus2; allowed: exactly one of sphere, ellipsoid, torus, capsule, rounded_box, "
              "genus2, union");
    EXPECT_EQ(complaint(kProbing + "workspace: {ball: {center: [0, 0, 0], radius: 1}, box: {min: [0, 0, 0], max: [1, 1, 1]}}"),
              "s.yaml:2: workspace: holds ball and box; allowed: exactly one of ball, box");
}

TEST_F(Reader, RefusesMeasuresThatDoNotFitEachOther) {
    EXPECT_EQ(shape_complaint("\n    torus:\n      minor: 1\n      major: 1"),
              "s.yaml:5: object.shape.torus.minor: is not less than major; allowed: greater than 0, less than major (mm)");
    EXPECT_EQ(
        shape_complaint("{rounded_box: {size: [4, 3, 2], fillet: 1.01}}"),
        "s.yaml:3: object.shape.rounded_box.fillet: is more than half the smallest side; allowed: from 0 to half the smallest side (mm)");
    EXPECT_EQ(shape_complaint("{capsule: {radius: 1, length: -1}}"),
              "s.yaml:3: object.shape.capsule.length: -1 is out of range; allowed: from 0 to 1000000 (mm)");
    EXPECT_EQ(complaint(kProbing + "workspace:\n  box:\n    min: [0, 0, 0]\n    max: [1, 0, 1]\n"),
              "s.yaml:5: workspace.box.max: is not greater than min in each coordinate; allowed: greater than min in x, y and z (mm)");
    EXPECT_EQ(complaint("probing: {epsilon: 1, seed_rays: [{from: [0, 0, 1], to: [0, -0, 1]}]}"),
              "s.yaml:1: probing.seed_rays[0].to: is the same point as from; allowed: another point (mm)");
}

TEST_F(Reader, RefusesVectorsThatAreNotThreeNumbers) {
    const std::string start = "s.yaml:2: workspace.ball.center";
    const auto center = [this](const std::string& value) {
        return complaint(kProbing + "workspace: {ball: {radius: 1, center: " + value + "}}");
    };
    EXPECT_EQ(center("[0, 0]"),
              start + ": a list of 2 is not a list of three numbers; allowed: [x, y, z], each from -1000000 to 1000000 (mm)");
    EXPECT_EQ(center("0"), start + ": 0 is not a list of three numbers; allowed: [x, y, z], each from -1000000 to 1000000 (mm)");
    EXPECT_EQ(center("[0, x, 0]"), start + "[1]: x is not a number; allowed: from -1000000 to 1000000 (mm)");
    EXPECT_EQ(center("[0,\n 0, .inf]"), "s.yaml:3: workspace.ball.center[2]: .inf is not finite; allowed: from -1000000 to 1000000 (mm)");
    EXPECT_EQ(shape_complaint("{ellipsoid: {semi_axes: [1, 1, 0]}}"),
              "s.yaml:3: object.shape.ellipsoid.semi_axes[2]: 0 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(shape_complaint("{sphere: {radius: 1}, rotate: [0, 0, 361]}"),
              "s.yaml:3: object.shape.rotate[2]: 361 is out of range; allowed: from -360 to 360 (degrees)");
}

TEST_F(Reader, RefusesOtherTypes) {
    EXPECT_EQ(complaint("probing: 1"), "s.yaml:1: probing: 1 is not a mapping; allowed: a mapping");
    EXPECT_EQ(complaint(kProbing + "workspace: Auto"),
              "s.yaml:2: workspace: Auto is not one of the words; did you mean \"auto\"?; allowed: auto, or a mapping");
    EXPECT_EQ(complaint(kProbing + "workspace:"), "s.yaml:2: workspace: null is not one of the words; allowed: auto, or a mapping");
    EXPECT_EQ(complaint("probing: {epsilon: 1, strategy: fast}"),
              "s.yaml:1: probing.strategy: fast is not one of the words; allowed: default, thesis, adaptive, or a mapping");
    EXPECT_EQ(complaint("probing: {epsilon: 1, strategy: {explore: all}}"),
              "s.yaml:1: probing.strategy.explore: all is not one of the words; allowed: exhaustive, closure");
    EXPECT_EQ(complaint("probing: {epsilon: 1, seed_rays: {}}"),
              "s.yaml:1: probing.seed_rays: a mapping is not a list; allowed: a list of mappings, any length");
    EXPECT_EQ(complaint("probing: {epsilon: 1, seed_rays: [1]}"), "s.yaml:1: probing.seed_rays[0]: 1 is not a mapping; allowed: a mapping");
    EXPECT_EQ(shape_complaint("{union: {parts: []}}"),
              "s.yaml:3: object.shape.union.parts: the list is too short; allowed: a list of mappings, at least 1");
    EXPECT_EQ(complaint(kProbing + "object: {mesh: ''}"),
              "s.yaml:2: object.mesh: \"\" is empty or holds a zero byte; allowed: a text that is not empty");
    EXPECT_EQ(complaint(kProbing + "object: {mesh: [a]}"),
              "s.yaml:2: object.mesh: a list is not a text; allowed: a text that is not empty");
}

TEST_F(Reader, ProposesTheWordThatWasMeant) {
    EXPECT_EQ(complaint("probing: {epsilon: 1, strategy: {infer: adaptiv}}"),
              "s.yaml:1: probing.strategy.infer: adaptiv is not one of the words; did you mean \"adaptive\"?; allowed: none, reach, "
              "adaptive, auto");
    EXPECT_EQ(
        complaint("probing: {epsilon: 1, strategy: thesiss}"),
        "s.yaml:1: probing.strategy: thesiss is not one of the words; did you mean \"thesis\"?; allowed: default, thesis, adaptive, or "
        "a mapping");
    EXPECT_EQ(complaint(kProbing + "object: {mesh: a.off, repair: True}"),
              "s.yaml:2: object.repair: True is not one of the words; did you mean \"true\"?; allowed: false, true");
    EXPECT_EQ(complaint("probing: {epsilon: 1, strategy: {infer: [adaptive]}}"),
              "s.yaml:1: probing.strategy.infer: a list is not one of the words; allowed: none, reach, adaptive, auto");
}

// Lengths whose squares no double holds have made an endless search of a workspace.
TEST_F(Reader, RefusesLengthsBeyondAKilometre) {
    EXPECT_EQ(shape("{sphere: {radius: 1000000}}").at, Point::Zero());
    EXPECT_EQ(shape_complaint("{sphere: {radius: 1e300}}"),
              "s.yaml:3: object.shape.sphere.radius: 1e300 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(shape_complaint("{sphere: {radius: 1}, at: [0, -1000001, 0]}"),
              "s.yaml:3: object.shape.at[1]: -1000001 is out of range; allowed: from -1000000 to 1000000 (mm)");
    EXPECT_EQ(shape_complaint("{capsule: {radius: 1, length: 1e7}}"),
              "s.yaml:3: object.shape.capsule.length: 1e7 is out of range; allowed: from 0 to 1000000 (mm)");
    EXPECT_EQ(shape_complaint("{genus2: {scale: 1e7}}"),
              "s.yaml:3: object.shape.genus2.scale: 1e7 is out of range; allowed: greater than 0, at most 1000000");
    EXPECT_EQ(complaint("probing: {epsilon: 2e6}"),
              "s.yaml:1: probing.epsilon: 2e6 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    // A way is no length of a thing.
    EXPECT_EQ(read("probing: {epsilon: 1, budget: {displacement: 1e9}}").probing.budget.displacement, 1e9);
}

TEST_F(Reader, RefusesDuplicateKeys) {
    EXPECT_EQ(complaint("probing:\n  epsilon: 1\n  reach: null\n  epsilon: 2\n"),
              "s.yaml:4: probing.epsilon: is given twice, first on line 2; allowed: once");
    EXPECT_EQ(complaint("probing: {epsilon: 1, seed_rays: [{from: [0, 0, 0], from: [0, 0, 0]}]}"),
              "s.yaml:1: probing.seed_rays[0].from: is given twice, first on line 1; allowed: once");
}

TEST_F(Reader, RefusesYamlThatNoSessionNeeds) {
    EXPECT_EQ(complaint(kProbing + "object: &a {mesh: x}\n").substr(0, 48), "s.yaml:2: object: anchors and aliases (& and *) ");
    EXPECT_EQ(complaint(kProbing + "random_seed: !!int 3\n").substr(0, 45), "s.yaml:2: random_seed: tags (!) are not suppo");
    EXPECT_EQ(complaint(kProbing + "---\nrandom_seed: 2\n"), "s.yaml:2: a second document starts here; allowed: exactly one");
    EXPECT_EQ(complaint(kProbing + "object: {mesh: latin-1-\xE9.off}\n"), "s.yaml:2: object.mesh: is not UTF-8; allowed: Unicode text");
    EXPECT_EQ(complaint(kProbing + "object:\n  <<: {mesh: x}\n"),
              "s.yaml:3: object: merge keys (<<) are not supported; allowed: the keys themselves");
    EXPECT_EQ(complaint("<<: {epsilon: 1}\n" + kProbing), "s.yaml:1: merge keys (<<) are not supported; allowed: the keys themselves");
    EXPECT_EQ(complaint(kProbing + "[a]: 2\n"), "s.yaml:2: a list is not a key; allowed: a word before the colon");
    EXPECT_EQ(complaint(kProbing + "object: " + std::string(100, '[')), "s.yaml:2: nested too deeply; allowed: 64 levels");
}

TEST_F(Reader, RefusesBytesThatAreNoCharacters) {
    for (const std::string bytes : test::kNoCharacters) {
        SCOPED_TRACE(testing::PrintToString(bytes));
        const std::string allowed = "is not UTF-8; allowed: Unicode text";
        EXPECT_EQ(complaint(kProbing + "object: {mesh: a" + bytes + "b.off}\n"), "s.yaml:2: object.mesh: " + allowed);
        EXPECT_EQ(complaint(kProbing + "object:\n  mesh: \"" + bytes + "\"\n"), "s.yaml:3: object.mesh: " + allowed);
        EXPECT_EQ(complaint(kProbing + "a" + bytes + ": 1\n"), "s.yaml:2: " + allowed);
        EXPECT_EQ(complaint(kProbing, {"object.mesh=" + bytes}), "--set object.mesh=" + bytes + ": " + allowed);
    }
}

TEST_F(Reader, ReadsEveryLengthOfCharacter) {
    for (const std::string character : test::kCharacters) {
        const std::string name = character + "x" + character;
        const SessionConfig config = read("object: {mesh: " + name + "}\n" + kProbing);
        EXPECT_EQ(std::get<MeshSpec>(config.object.value()).file, folder_.path() / name);
        const SessionConfig given = read(kProbing, {"object.mesh=" + name});
        EXPECT_EQ(std::get<MeshSpec>(given.object.value()).file, folder_.path() / name);
    }
}

TEST_F(Reader, RefusesBrokenYaml) {
    EXPECT_EQ(complaint("probing:\n  epsilon: 1\n reach: 2\n").substr(0, 29), "s.yaml:3: is not valid YAML: ");
    EXPECT_EQ(complaint("probing: {epsilon: 1\n").substr(0, 29), "s.yaml:2: is not valid YAML: ");
    EXPECT_EQ(complaint("probing: {epsilon: ]}\n").substr(0, 29), "s.yaml:1: is not valid YAML: ");
}

// yaml-cpp has several words for it, of which none says "tab" in the first case.
TEST_F(Reader, NamesATabInTheIndentation) {
    EXPECT_EQ(complaint("probing:\n\tepsilon: 1\n"), "s.yaml:2: a tab in the indentation; allowed: blanks");
    EXPECT_EQ(complaint("probing:\n  epsilon: 1\n \treach: 2\n"), "s.yaml:3: a tab in the indentation; allowed: blanks");
    EXPECT_EQ(complaint("probing:\n  seed_rays:\n\t- {}\n"), "s.yaml:3: a tab in the indentation; allowed: blanks");
    EXPECT_EQ(read("probing:\t# a tab that indents nothing\n  epsilon:\t0.25\n").probing.epsilon, 0.25);
}

TEST_F(Reader, RefusesFilesThatHoldNoConfig) {
    EXPECT_EQ(complaint(""), "s.yaml:1: is empty; allowed: one YAML document");
    EXPECT_EQ(complaint("# only a comment\n"), "s.yaml:1: is empty; allowed: one YAML document");
    EXPECT_EQ(complaint("---\n"), "s.yaml:2: null is not a mapping; allowed: a mapping with at least the key probing");
    EXPECT_EQ(complaint("- 1\n"), "s.yaml:1: a list is not a mapping; allowed: a mapping with at least the key probing");
    EXPECT_EQ(complaint(std::string(2000000, '#')), "s.yaml: is too long; allowed: 1048576 bytes");
    const auto message = [](const std::filesystem::path& file) {
        try {
            (void)read_config(file);
        } catch (const ConfigError& error) {
            return std::string(error.what());
        }
        return std::string("nothing");
    };
    EXPECT_EQ(message(folder_.path()), folder_.path().string() + ": is a folder; allowed: a YAML file");
    EXPECT_EQ(message("no/such.yaml"), "no/such.yaml: does not exist; allowed: a YAML file");
}

TEST_F(Reader, OverridesReplaceAndCreateKeys) {
    const SessionConfig config = read(kProbing, {"probing.epsilon=1", "probing.epsilon=0.5", "probing.strategy.refine=exhaustive",
                                                 "random_seed=7", "workspace={ball: {center: [0, 0, 0], radius: 2}}",
                                                 "workspace.ball.radius=3", "object.mesh=a=b.off", "probing.reach=null"});
    EXPECT_EQ(config.probing.epsilon, 0.5);
    EXPECT_EQ(config.probing.strategy.refine, Strategy::Refine::exhaustive);
    EXPECT_EQ(config.probing.random_seed, 7U);
    EXPECT_EQ(std::get<Ball>(config.workspace).radius, 3.0);
    EXPECT_EQ(std::get<MeshSpec>(config.object.value()).file, folder_.path() / "a=b.off");
}

TEST_F(Reader, ErrorsInOverridesNameTheOverride) {
    const auto set = [this](const std::string& assignment) { return complaint(kProbing + "workspace: auto\n", {assignment}); };
    EXPECT_EQ(set("probing.epsilon=-1"),
              "--set probing.epsilon=-1: probing.epsilon: -1 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(set("probing.epsilom=1").substr(0, 81),
              "--set probing.epsilom=1: probing.epsilom: unknown key; did you mean \"epsilon\"?; a");
    EXPECT_EQ(set("a.b=1"),
              "--set a.b=1: a: unknown key; allowed: object, machine, tool, simulation, workspace, probing, results, random_seed");
    EXPECT_EQ(set("probing.epsilon={a: 1, a: 2}"), "--set probing.epsilon={a: 1, a: 2}: probing.epsilon.a: is given twice; allowed: once");
    EXPECT_EQ(set("probing.epsilon="), "--set probing.epsilon=: probing.epsilon: is empty; allowed: one YAML document");
    EXPECT_EQ(set("probing.epsilon=[").substr(0, 59), "--set probing.epsilon=[: probing.epsilon: is not valid YAML");
    EXPECT_EQ(set("workspace.ball.radius=3"),
              "--set workspace.ball.radius=3: workspace: auto is not a mapping; allowed: --set workspace={...}, which replaces it");
    for (const std::string malformed : {"probing", "=1", "probing..epsilon=1", ".epsilon=1", "probing.=1", ""}) {
        EXPECT_EQ(set(malformed), "--set " + malformed + ": is not an assignment; allowed: KEY=VALUE with a key such as probing.epsilon");
    }
}

TEST_F(Reader, LongAndStrangeValuesDoNotGarbleMessages) {
    EXPECT_EQ(
        complaint("probing: {epsilon: \"a\\x07" + std::string(100, 'b') + "\"}"),
        "s.yaml:1: probing.epsilon: \"a?" + std::string(58, 'b') + "...\" is not a number; allowed: greater than 0, at most 1000000 (mm)");
}

}  // namespace
}  // namespace palpate::reader_test
