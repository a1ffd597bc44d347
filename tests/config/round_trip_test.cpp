#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <stdexcept>

#include "config/reader.h"
#include "config/writer.h"
#include "tests/config/support.h"

namespace palpate {
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

TEST(Writer, SpellsOutEveryDefaultInAFixedOrder) {
    const test::TemporaryFolder folder;
    const SessionConfig config = read_config(folder.write("a.yaml", "probing: {epsilon: 0.25}\nobject: {mesh: part.off}\n"));
    EXPECT_EQ(write_config(config),
              "object:\n  mesh: \"" + (folder.path() / "part.off").string() +
                  "\"\n  scale: 1\n  at: [0, 0, 0]\n  rotate: [0, 0, 0]\n  repair: true\nworkspace: auto\nprobing:\n  epsilon: 0.25\n  "
                  "reach: null\n"
                  "  strategy: {refine: eager, explore: closure, infer: reach, travel: free_space}\n  standoff: null\n  audit: 0.02\n"
                  "  seed_rays: []\n  refinement_floor: 0.125\n  sizing:\n    regions: []\n    radii_of_curvature: 0\n    smallest: null\n"
                  "  min_angle: 0\n  budget: {probes: null, displacement: null, machine_time: null}\nrandom_seed: 1\n");
}

TEST(Writer, RefusesWhatYamlCannotHold) {
    SessionConfig config;
    config.probing.epsilon = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)write_config(config), std::invalid_argument);
    config.probing.epsilon = 1.0;
    for (const char* name : {"/latin-1-\xE9.off", "/cut-\xC3", "/alone-\x80", "/overlong-\xC0\xAF"}) {
        config.object = MeshSpec{name};
        EXPECT_THROW((void)write_config(config), std::invalid_argument) << name;
    }
}

}  // namespace
}  // namespace palpate
