#include "config/editor.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/reader.h"
#include "config/writer.h"
#include "tests/config/support.h"

namespace palpate::editor_test {
namespace {

using ::testing::HasSubstr;

std::string edited(const std::string& text, const KeyEdit& edit) { return edited_config(text, "part.yaml", {edit}); }

TEST(Editor, AKeyGoesBehindTheLastOfItsMapping) {
    EXPECT_EQ(edited("tool:   # mine\n  ball: {diameter: 2}   # ruby\n\n# next\nprobing: {epsilon: 1}\n", {"tool.calibration", "a.json"}),
              "tool:   # mine\n  ball: {diameter: 2}   # ruby\n  calibration: a.json\n\n# next\nprobing: {epsilon: 1}\n");
    EXPECT_EQ(edited("tool:\n    ball:\n        diameter: 2\n", {"tool.calibration", "a.json", {}, "by hand"}),
              "tool:\n    ball:\n        diameter: 2\n    calibration: a.json  # by hand\n");
}

TEST(Editor, AKeyGoesIntoBraces) {
    EXPECT_EQ(edited("tool: {ball: {diameter: 2}}  # mine\n", {"tool.calibration", "a.json"}),
              "tool: {ball: {diameter: 2}, calibration: a.json}  # mine\n");
    EXPECT_EQ(
        edited("tool: {ball: {diameter: 2},\n       stylus: {diameter: 1, length: 9}}\nrandom_seed: 1\n", {"tool.calibration", "a.json"}),
        "tool: {ball: {diameter: 2},\n       stylus: {diameter: 1, length: 9}, calibration: a.json}\nrandom_seed: 1\n");
    EXPECT_EQ(edited("tool: {}\n", {"tool.calibration", "a.json"}), "tool: {calibration: a.json}\n");
    EXPECT_EQ(edited("a: {b: {c: 1, d: 'x, }'}, e: 2}\n", {"a.b.f", "3"}), "a: {b: {c: 1, d: 'x, }', f: 3}, e: 2}\n");
}

TEST(Editor, AValueIsReplacedAndItsCommentStays) {
    EXPECT_EQ(edited("tool:\n  calibration: old.json   # weekly\n  ball: {diameter: 2}\n", {"tool.calibration", "new.json", {}, "other"}),
              "tool:\n  calibration: new.json   # weekly\n  ball: {diameter: 2}\n");
    EXPECT_EQ(edited("tool: {calibration: old.json, ball: {diameter: 2}}\n", {"tool.calibration", "new.json"}),
              "tool: {calibration: new.json, ball: {diameter: 2}}\n");
    EXPECT_EQ(edited("workspace:\n  box:\n    min: [0, 0, 0]\n    # high\n    max: [1, 1, 1]\n\n# of the part\nprobing: {epsilon: 1}\n",
                     {"workspace.box", "{min: [1, 1, 1], max: [2, 2, 2]}"}),
              "workspace:\n  box: {min: [1, 1, 1], max: [2, 2, 2]}\n\n# of the part\nprobing: {epsilon: 1}\n");
}

TEST(Editor, AMarkInQuotesIsNoComment) {
    EXPECT_EQ(edited("tool:\n  calibration: \"a #1.json\"  # weekly\n", {"tool.calibration", "b.json"}),
              "tool:\n  calibration: b.json  # weekly\n");
}

TEST(Editor, WhatIsNotThereIsAppended) {
    EXPECT_EQ(edited("# mine\nprobing: {epsilon: 1}", {"tool.calibration", "a.json"}),
              "# mine\nprobing: {epsilon: 1}\ntool: {calibration: a.json}\n");
    EXPECT_EQ(edited("probing: {epsilon: 1}\n",
                     {"workspace", "{box: 1, fixtures: [{table: {z: 0}}]}", {"box: 1", "fixtures:", "  - table: {z: 0}"}, "touched"}),
              "probing: {epsilon: 1}\nworkspace:  # touched\n  box: 1\n  fixtures:\n    - table: {z: 0}\n");
}

TEST(Editor, AWordGivesWayToAMapping) {
    EXPECT_EQ(edited("workspace: auto  # for now\nrandom_seed: 1\n", {"workspace.box", "{min: 1}"}),
              "workspace: {box: {min: 1}}  # for now\nrandom_seed: 1\n");
}

TEST(Editor, AListIsReplacedWithItsItems) {
    const KeyEdit rays{"probing.seed_rays", "[{from: 1, to: 2}]", {"- {from: 1, to: 2}"}};
    EXPECT_EQ(edited("probing:\n  seed_rays:\n  - {from: 5, to: 6}\n  - {from: 7, to: 8}\n  epsilon: 1\n", rays),
              "probing:\n  seed_rays:\n    - {from: 1, to: 2}\n  epsilon: 1\n");
    EXPECT_EQ(edited("probing: {epsilon: 1}\n", rays), "probing: {epsilon: 1, seed_rays: [{from: 1, to: 2}]}\n");
}

TEST(Editor, WhatStandsInAnotherFormIsLeftToItsAuthor) {
    for (const char* text : {"{tool: {ball: {diameter: 2}}}\n", "\"tool\": {ball: {diameter: 2}}\n", "tool:\n  {ball: {diameter: 2}}\n",
                             "tool: {ball: {diameter: 2}, # why\n  stylus: 1}\n", "tool: [1]\n"}) {
        try {
            ADD_FAILURE() << edited(text, {"tool.calibration", "a.json"});
        } catch (const ConfigError& error) {
            EXPECT_THAT(error.what(), HasSubstr("part.yaml")) << text;
            EXPECT_THAT(error.what(), HasSubstr("tool")) << text;
        }
    }
}

// Whatever an example looks like.
TEST(Editor, ExamplesTakeACalibrationAndLoseNothing) {
    std::vector<std::filesystem::path> files = test::example_files();
    for (const char* machine : {"grbl.yaml", "modbus.yaml", "table.yaml"}) {
        files.push_back(std::filesystem::path(PALPATE_CONFIG_DIR) / "machines" / machine);
    }
    for (const std::filesystem::path& file : files) {
        SessionConfig config = read_config(file);
        if (!config.tool) config.tool = ToolShape{2.0, {}, {}, Vector::UnitZ()};
        const std::string text = edited_config(
            test::contents(file), file,
            {{"tool.ball", fmt::format("{{diameter: {}}}", config.tool->ball_diameter)}, {"tool.calibration", yaml_text("a b: c.json")}});
        config.calibration.file = file.parent_path() / "a b: c.json";
        EXPECT_EQ(write_config(read_config_text(text, file)), write_config(config)) << text;
    }
}

}  // namespace
}  // namespace palpate::editor_test
