#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <stdexcept>

#include "config/reader.h"
#include "config/writer.h"
#include "tests/config/support.h"

namespace palpate::round_trip_test {
namespace {

TEST(RoundTrip, AnyConfigReadsBackBitForBit) {
    const std::uint64_t seed = test::logged_seed();
    std::mt19937_64 random(seed);
    const test::TemporaryFolder folder;
    for (int i = 0; i < 500; ++i) {
        const SessionConfig config = test::random_config(random);
        const std::string text = write_config(config);
        const SessionConfig back = read_config(folder.write("config.yaml", text));
        ASSERT_TRUE(test::identical(config, back)) << "seed " << seed << "\n" << text << "\n" << write_config(back);
        ASSERT_EQ(text, write_config(back));
    }
}

TEST(RoundTrip, ExamplesReadBackBitForBit) {
    const test::TemporaryFolder folder;
    for (const std::filesystem::path& file : test::example_files()) {
        const SessionConfig config = read_config(file);
        EXPECT_TRUE(test::identical(config, read_config(folder.write("config.yaml", write_config(config))))) << file;
    }
}

TEST(RoundTrip, NamesKeepTheirCharacters) {
    const test::TemporaryFolder folder;
    SessionConfig config;
    config.probing.epsilon = 1.0;
    for (const std::string character : test::kCharacters) {
        config.object = MeshSpec{"/" + character + "x" + character};
        const std::string text = write_config(config);
        const SessionConfig back = read_config(folder.write("config.yaml", text));
        EXPECT_TRUE(test::identical(config, back)) << text;
        EXPECT_EQ(write_config(back), text);
    }
}

// Doubles of degrees would miss some of these (config/internal/numbers.h).
TEST(RoundTrip, EveryAngleIsReachedAndRoundOnesStayRound) {
    const std::uint64_t seed = test::logged_seed();
    std::mt19937_64 random(seed);
    const test::TemporaryFolder folder;
    ShapeSpec shape;
    SessionConfig config;
    config.probing.epsilon = 1.0;
    for (int i = 0; i < 1000; ++i) {
        std::uniform_real_distribution<double> angle(1.0, 2.0);
        shape.rotate = {angle(random), -angle(random), angle(random) * 1e-300};
        MeshSpec mesh{"/part.off"};
        mesh.rotate = shape.rotate;
        for (const ObjectSpec& object : {ObjectSpec(shape), ObjectSpec(mesh)}) {
            config.object = object;
            ASSERT_TRUE(test::identical(config, read_config(folder.write("config.yaml", write_config(config))))) << "seed " << seed;
        }
    }
    const std::string round = "rotate: [30, -360, 0.1]";
    const SessionConfig read =
        read_config(folder.write("round.yaml", "probing: {epsilon: 1}\nobject:\n  shape:\n    sphere: {radius: 1}\n    " + round));
    EXPECT_NE(write_config(read).find(round), std::string::npos) << write_config(read);
}

// A session's folder can be moved with what it names, or reached over a link.
TEST(RoundTrip, FilesAreNamedAsSeenFromTheFolderThatTheTextLiesIn) {
    const test::TemporaryFolder one;
    const test::TemporaryFolder other;
    const std::string text =
        "object: {mesh: meshes/part.off}\nmachine: {modbus: {tcp: {host: h}, profile: maps/map.yaml}, limits: {min: [0, 0, 0], max: [1, 1, "
        "1]}}\nprobing: {epsilon: 1}\n";
    std::string kept;
    for (const test::TemporaryFolder* folder : {&one, &other}) {
        std::filesystem::create_directories(folder->path() / "out/session");
        std::filesystem::create_directory_symlink(folder->path() / "out/session", folder->path() / "link");
        const SessionConfig config = read_config(folder->write("part.yaml", text));
        const std::string written = write_config(config, folder->path() / "out/session");
        EXPECT_THAT(written, testing::HasSubstr("  mesh: \"../../meshes/part.off\"\n"));
        EXPECT_THAT(written, testing::HasSubstr("profile: \"../../maps/map.yaml\"}"));
        EXPECT_EQ(write_config(config, folder->path() / "link"), written);
        EXPECT_TRUE(kept.empty() || kept == written) << kept << written;
        kept = written;
        EXPECT_TRUE(test::identical(config, read_config(folder->write("out/session/config.yaml", written))));
        EXPECT_TRUE(test::identical(config, read_config(folder->path() / "link/config.yaml")));
    }
}

TEST(RoundTrip, AnyConfigReadsBackFromAFolderThatItIsWrittenFor) {
    const std::uint64_t seed = test::logged_seed();
    std::mt19937_64 random(seed);
    const test::TemporaryFolder folder;
    for (int i = 0; i < 100; ++i) {
        const SessionConfig config = test::random_config(random);
        const SessionConfig back = read_config(folder.write("config.yaml", write_config(config, folder.path())));
        ASSERT_TRUE(test::identical(config, back)) << "seed " << seed << "\n" << write_config(config);
    }
}

TEST(Writer, SpellsOutEveryDefaultInAFixedOrder) {
    const test::TemporaryFolder folder;
    const SessionConfig config = read_config(folder.write("a.yaml", "probing: {epsilon: 0.25}\nobject: {mesh: part.off}\n"));
    EXPECT_EQ(write_config(config),
              "object:\n  mesh: \"" + (folder.path() / "part.off").string() +
                  "\"\n  scale: 1\n  at: [0, 0, 0]\n  rotate: [0, 0, 0]\n  repair: true\nworkspace: auto\nprobing:\n  epsilon: 0.25\n  "
                  "reach: null\n"
                  "  strategy: {refine: eager, explore: closure, infer: auto, travel: free_space}\n  standoff: null\n  trust: 0.01\n  "
                  "audit: 0.01\n"
                  "  seed_rays: []\n  refinement_floor: 0.125\n  sizing:\n    regions: []\n    radii_of_curvature: 0\n    smallest: null\n"
                  "  min_angle: 0\n  budget: {probes: null, displacement: null, machine_time: null}\nrandom_seed: 1\n");
}

TEST(Writer, CallsAShapeByItsKey) {
    EXPECT_EQ(shape_name({SphereSpec{}}), "sphere");
    EXPECT_EQ(shape_name({RoundedBoxSpec{}}), "rounded_box");
    EXPECT_EQ(shape_name({std::vector<ShapeSpec>{{TorusSpec{}}}}), "union");
}

// What is short is on one line, what is long on lines of its own.
TEST(Writer, SpellsOutShapesAndMachines) {
    const SessionConfig config = read_config_text(
        R"(object: {shape: {union: {parts: [{sphere: {radius: 1}}, {union: {parts: [{torus: {major: 2, minor: 0.5}}]}, rotate: [90, 0, 0]}]}}}
machine: {grbl: {port: /dev/ttyUSB0}, limits: {min: [-1, -2, -3], max: [1, 2, 3]}, feeds: {travel: 12.5}, probe_proof: hand}
workspace: {box: {min: [0, 0, 0], max: [1, 1, 0.5]}}
probing: {epsilon: 0.1, seed_rays: [{from: [0, 0, 4], to: [0, 0, 0]}], sizing: {regions: [{min: [0, 0, 0], max: [1, 1, 1], size: 0.05}]}})",
        "s.yaml");
    const std::string text = write_config(config);
    EXPECT_EQ(text.substr(0, text.find("  standoff:")), R"(object:
  shape:
    union:
      parts:
        - sphere: {radius: 1}
          at: [0, 0, 0]
          rotate: [0, 0, 0]
        - union:
            parts:
              - torus: {major: 2, minor: 0.5}
                at: [0, 0, 0]
                rotate: [0, 0, 0]
          at: [0, 0, 0]
          rotate: [90, 0, 0]
    at: [0, 0, 0]
    rotate: [0, 0, 0]
machine:
  grbl: {port: "/dev/ttyUSB0", baud: 115200, reset_on_open: false, boot_time: 8, delay: null}
  homing: require
  origin: [0, 0, 0]
  limits: {min: [-1, -2, -3], max: [1, 2, 3]}
  feeds: {travel: 12.5, probe: 5, touch: 1}
  acceleration: 200
  latency: 0.002
  overtravel: 2
  retract: 0.5
  resolution: 0.001
  noise: 0
  touch: {samples: 1, tolerance: 0.025, retries: 3, discard_first: false, confirm: true, confirm_travel: true}
  datum_tolerance: null
  probe_proof: hand
workspace: {box: {min: [0, 0, 0], max: [1, 1, 0.5]}}
probing:
  epsilon: 0.1
  reach: null
  strategy: {refine: eager, explore: closure, infer: auto, travel: free_space}
)");
    EXPECT_EQ(text.substr(text.find("  seed_rays:"), text.find("    radii_of_curvature:") - text.find("  seed_rays:")), R"(  seed_rays:
    - {from: [0, 0, 4], to: [0, 0, 0]}
  refinement_floor: 0.125
  sizing:
    regions:
      - {min: [0, 0, 0], max: [1, 1, 1], size: 0.05, slope: 0.5}
)");
}

TEST(Writer, SpellsOutToolsAndFixtures) {
    const SessionConfig config = read_config_text(
        "tool: {ball: {diameter: 2}, stylus: {diameter: 1, length: 30}}\n"
        "workspace: {box: {min: [0, 0, 0], max: [1, 1, 1]}, fixtures: [{table: {z: 0}}, {half_space: {point: [0, 0, 0], normal: [5, 0, "
        "0]}}]}\n"
        "probing: {epsilon: 0.1}\n",
        "s.yaml");
    EXPECT_THAT(write_config(config), testing::StartsWith(R"(tool: {ball: {diameter: 2}, stylus: {diameter: 1, length: 30, axis: [0, 0, 1]}}
workspace:
  box: {min: [0, 0, 0], max: [1, 1, 1]}
  fixtures:
    - {table: {z: 0}}
    - {half_space: {point: [0, 0, 0], normal: [1, 0, 0]}}
  clearance: null
  assume_clear: true
probing:
)"));
}

TEST(Writer, SpellsOutControllersThatSpeakModbus) {
    const SessionConfig config = read_config_text(
        "machine: {modbus: {rtu: {path: /dev/ttyS1, parity: odd}, profile: /p.yaml}, limits: {min: [-1, -2, -3], max: [1, 2, 3]}}\n"
        "probing: {epsilon: 0.1}\n",
        "s.yaml");
    EXPECT_THAT(write_config(config),
                testing::StartsWith("machine:\n  modbus: {rtu: {path: \"/dev/ttyS1\", baud: 19200, parity: odd, stop_bits: 1}, unit: 1, "
                                    "slowest_answer: 0.65, reconnect_time: 10, busy_time: 1, profile: \"/p.yaml\"}\n  homing: require\n"));
}

TEST(Writer, SpellsOutADatumWhereThereIsOne) {
    const std::string text =
        "machine: {grbl: {port: /dev/ttyS1}, limits: {min: [-1, -2, -3], max: [1, 2, 3]}, datum: {limit: 0.02, at: [{from: [1, 0, 0], to: "
        "[0.25, 0, 0]}]}}\nprobing: {epsilon: 0.1}\n";
    const SessionConfig config = read_config_text(text, "s.yaml");
    const std::string written = write_config(config);
    EXPECT_THAT(written, testing::HasSubstr(R"(
  probe_proof: auto
  datum:
    every: 100
    at:
      - {from: [1, 0, 0], to: [0.25, 0, 0]}
    limit: 0.02
)"));
    EXPECT_EQ(write_config(read_config_text(written, "s.yaml")), written);
    EXPECT_THAT(write_config(read_config_text(
                    "machine: {grbl: {port: p}, limits: {min: [0, 0, 0], max: [1, 1, 1]}}\nprobing: {epsilon: 1}\n", "s.yaml")),
                testing::Not(testing::HasSubstr("datum:")));
}

TEST(Writer, RefusesWhatYamlCannotHold) {
    SessionConfig config;
    config.probing.epsilon = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)write_config(config), std::invalid_argument);
    config.probing.epsilon = 1.0;
    for (const std::string bytes : test::kNoCharacters) {
        config.object = MeshSpec{"/a" + bytes};
        EXPECT_THROW((void)write_config(config), std::invalid_argument) << testing::PrintToString(bytes);
    }
}

}  // namespace
}  // namespace palpate::round_trip_test
