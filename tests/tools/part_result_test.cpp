#include "tools/part_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/reader.h"
#include "sim/objects/mesh/mesh_file.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/simulation.h"
#include "tools/summary.h"

namespace palpate::part_result_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// A block of 12 × 10 × 6 mm on a table, probed with a ball of 2 mm.
class PartResultTest : public ::testing::Test {
protected:
    PartResultTest() {
        std::ofstream(folder_ / "block.off")
            << "OFF\n8 12 0\n-6 -5 0\n6 -5 0\n6 5 0\n-6 5 0\n-6 -5 6\n6 -5 6\n6 5 6\n-6 5 6\n"
               "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";
    }
    ~PartResultTest() override { std::filesystem::remove_all(folder_); }

    [[nodiscard]] SessionConfig config(const std::string& more = "") const {
        return read_config_text(
            "object: {mesh: block.off}\n"
            "tool: {ball: {diameter: 2}, stylus: {diameter: 1.4, length: 40}}\n"
            "workspace:\n"
            "  box: {min: [-14, -13, -1], max: [14, 13, 14]}\n"
            "  fixtures: [{table: {z: 0}}]\n"
            "probing: {epsilon: 1.2}\n" +
                more,
            folder_ / "block.yaml");
    }
    // Between the commas of a line.
    static std::vector<std::string> fields(const std::string& line) {
        std::vector<std::string> words{""};
        for (const char c : line) {
            if (c == ',') {
                words.emplace_back();
            } else {
                words.back() += c;
            }
        }
        return words;
    }

    std::filesystem::path folder_ = [] {
        const auto folder = std::filesystem::temp_directory_path() / ("palpate_part_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder);
        return folder;
    }();
};

TEST_F(PartResultTest, TouchesAndSummaryTellOfThePart) {
    const SessionConfig block = config();
    const Simulation run = simulate(block, build_scene(block));
    ASSERT_EQ(run.unsafe_moves, 0U);
    // What is plausible is now and then wrong, at the foot's crease above all.
    EXPECT_LT(static_cast<double>(run.wrong_inferences), 0.02 * static_cast<double>(run.result.mesh.triangles.size()));
    const auto part = part_of(run.result, block);
    ASSERT_TRUE(part);

    // Every measured touch is told where the block is, as sure as it says.
    std::istringstream csv(to_csv(run.result.touches, *part));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "touch,x,y,z,from_x,from_y,from_z,role,sample,tag,part_x,part_y,part_z,uncertainty");
    std::size_t tips = 0;
    std::size_t beyond = 0;
    std::size_t fixtures = 0;
    std::size_t lines = 0;
    for (; std::getline(csv, line); ++lines) {
        const std::vector<std::string> words = fields(line);
        ASSERT_EQ(words.size(), 14U) << line;
        fixtures += words[9] == "fixture" ? 1 : 0;
        EXPECT_EQ(words[9] == "fixture", run.result.touches[lines].is_known) << line;
        if (words[9] != "tip") continue;
        ++tips;
        const Point p(std::stod(words[10]), std::stod(words[11]), std::stod(words[12]));
        const double off = HiddenObject(*block.object).distance(p);
        beyond += off > std::stod(words[13]) + 1e-6 ? 1 : 0;
    }
    EXPECT_EQ(lines, run.result.touches.size());
    EXPECT_GT(tips, 100U);
    EXPECT_GT(fixtures, 100U);
    EXPECT_LE(static_cast<double>(beyond), 0.01 * static_cast<double>(tips));

    const auto json = nlohmann::json::parse(to_json(run, part, block.probing.epsilon, Provenance{}));
    EXPECT_EQ(json["samples"].get<std::size_t>() + json["virtual_contacts"].get<std::size_t>(), run.result.samples);
    EXPECT_EQ(json["part"]["facets"], part->surface.mesh.triangles.size());
    // Its top and sides: 120 mm² and 264 mm², less what the ball cannot see at the table.
    const double tip = json["part"]["area"]["tip"].get<double>() + json["part"]["area"]["bridged"].get<double>();
    EXPECT_GT(tip, 250);
    EXPECT_LT(tip, 390);
    EXPECT_EQ(json["part"]["area"]["shadow"], 0);
    EXPECT_EQ(json["part"]["boundary_edges"], 0);
}

// A sphere in closed form: what the ball touched is exact, but for what the facets' width leaves of normals.
TEST_F(PartResultTest, ASphereOnATableComesBack) {
    SessionConfig sphere = read_config_text(
        "object: {shape: {sphere: {radius: 6}, at: [0, 0, 6]}}\n"
        "tool: {ball: {diameter: 2}, stylus: {diameter: 1.4, length: 40}}\n"
        "workspace:\n"
        "  box: {min: [-15, -15, -1], max: [15, 15, 20]}\n"
        "  fixtures: [{table: {z: 0}}]\n"
        "probing: {epsilon: 1.2}\n",
        folder_ / "sphere.yaml");
    const Simulation run = simulate(sphere, build_scene(sphere));
    EXPECT_EQ(run.unsafe_moves, 0U);
    ASSERT_TRUE(run.tool);
    EXPECT_EQ(run.tool->moves_into_fixtures, 0U);
    EXPECT_GT(run.tool->touches(ToolContact::Part::ball, ToolContact::Met::object), 100U);
    EXPECT_GT(run.tool->touches(ToolContact::Part::stylus, ToolContact::Met::object), 50U) << "below its equator";
    EXPECT_EQ(run.tool->touches(ToolContact::Part::ball, ToolContact::Met::fixture), 0U);
    EXPECT_EQ(run.result.topology.euler_characteristic, 2);
    EXPECT_TRUE(run.result.topology.is_closed_oriented_manifold());
    const auto part = part_of(run.result, sphere);
    ASSERT_TRUE(part);
    std::size_t tips = 0;
    std::size_t beyond = 0;
    double farthest = 0;
    for (const TouchedPoint& touched : part->touched) {
        if (touched.tag != PartTag::tip) continue;
        ++tips;
        const double off = std::abs((touched.point - Point(0, 0, 6)).norm() - 6);
        farthest = std::max(farthest, off);
        beyond += off > touched.uncertainty + 1e-6 ? 1 : 0;
    }
    EXPECT_GT(tips, 100U);
    EXPECT_LE(static_cast<double>(beyond), 0.01 * static_cast<double>(tips));
    EXPECT_LT(farthest, 0.02);
    EXPECT_GT(part->report.area.at(static_cast<std::size_t>(PartTag::shadow)), 50) << "straight below the equator";
}

TEST_F(PartResultTest, AnOpenPartEndsWhereItWasNotMeasured) {
    const SessionConfig closed = config();
    const SessionConfig open = config("results: {part: open}\n");
    const Simulation run = simulate(open, build_scene(open));
    const auto whole = part_of(run.result, closed);
    const auto cut = part_of(run.result, open);
    ASSERT_TRUE(whole && cut);
    EXPECT_EQ(whole->topology.boundary_edges, 0U);
    EXPECT_GT(cut->topology.boundary_edges, 10U);
    for (const Point& p : cut->surface.mesh.points) EXPECT_GT(p.z(), 0.2);
    for (const PartTag tag : cut->surface.facet_tags) EXPECT_TRUE(is_measured(tag));
}

TEST_F(PartResultTest, ThePartIsAMeshThatOthersRead) {
    const SessionConfig block = config();
    const Simulation run = simulate(block, build_scene(block));
    const auto part = part_of(run.result, block);
    ASSERT_TRUE(part);
    const std::string files =
        write_results(folder_, run.result, part, curved_of(run.result, part, block), Provenance{}, "{}", {.drawn = false});
    EXPECT_EQ(files, "mesh.ply, mesh_tool.ply, touches.csv, summary.json, surface.ply");
    const TriangleMesh read = read_triangles(folder_ / kMeshFile);
    ASSERT_EQ(read.triangles, part->surface.mesh.triangles);
    for (std::size_t k = 0; k < read.points.size(); ++k) ASSERT_EQ(read.points[k], part->surface.mesh.points[k]);
    const TriangleMesh traced = read_triangles(folder_ / kToolMeshFile);
    EXPECT_EQ(traced.triangles, run.result.mesh.triangles);
    EXPECT_THAT(to_ply(part->surface, {"one"}), StartsWith("ply\nformat ascii 1.0\ncomment one\ncomment tag 0: tip\n"));
    EXPECT_THAT(describe(part->report), HasSubstr("mm² tip"));
}

TEST_F(PartResultTest, ItsPictureTellsWhatColoursMeanAndIsDrawnAgainFromItsMesh) {
    const SessionConfig block = config();
    const Simulation run = simulate(block, build_scene(block));
    const auto part = part_of(run.result, block);
    ASSERT_TRUE(part);
    const PartSurface& surface = part->surface;
    EXPECT_EQ(facet_tags_in(to_ply(surface, {})), surface.facet_tags);
    EXPECT_TRUE(facet_tags_in(to_ply(run.result.mesh)).empty());
    EXPECT_TRUE(facet_tags_in("ply\ncomment tag 0: tip\nelement face 2\nend_header\n3 0 1 2 0\n").empty()) << "cut off";
    std::vector<std::string> told;
    double percent = 0;
    for (const LegendEntry& entry : legend_of(surface.mesh, surface.facet_tags)) {
        told.push_back(entry.text.substr(0, entry.text.find(' ')));
        if (told.back() != "fixture" && entry.text.find('<') == std::string::npos)
            percent += std::stod(entry.text.substr(told.back().size()));
    }
    EXPECT_THAT(told, ::testing::IsSupersetOf({"tip", "fixture"}));
    EXPECT_THAT(told, ::testing::Not(::testing::Contains("shadow")));
    EXPECT_NEAR(percent, 100, 3);

    (void)write_results(folder_, run.result, part, std::nullopt, Provenance{}, "{}", {});
    const auto read = [&] {
        std::ifstream in(folder_ / kPictureFile, std::ios::binary);
        return std::string{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    };
    const std::string drawn = read();
    std::filesystem::remove(folder_ / kPictureFile);
    draw_session_picture(folder_, 'z');
    EXPECT_EQ(read(), drawn);
}

TEST_F(PartResultTest, WithoutAToolThereIsNone) {
    SessionConfig block = config();
    const Simulation run = simulate(block, build_scene(block));
    block.tool.reset();
    EXPECT_FALSE(part_of(run.result, block));
}

}  // namespace
}  // namespace palpate::part_result_test
