#include "tools/session_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "devices/version.h"
#include "tools/provenance.h"
#include "tools/session_folder.h"
#include "tools/summary.h"

namespace palpate::session_files_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(SessionFiles, PlyReadsBackToTheSameBits) {
    TriangleMesh mesh{{{0.1, 1.0 / 3, -2e-17}, {1e300, 5e-324, 0}, {1, 2, 3}}, {{{0, 1, 2}}}};
    std::istringstream ply(to_ply(mesh));
    std::string line;
    while (std::getline(ply, line) && line != "end_header") {
    }
    for (const Point& p : mesh.points) {
        std::string x;
        std::string y;
        std::string z;
        ply >> x >> y >> z;
        EXPECT_EQ(std::strtod(x.c_str(), nullptr), p.x());
        EXPECT_EQ(std::strtod(y.c_str(), nullptr), p.y());
        EXPECT_EQ(std::strtod(z.c_str(), nullptr), p.z());
    }
    int n = 0;
    int a = 0;
    int b = 0;
    int c = 0;
    ply >> n >> a >> b >> c;
    EXPECT_EQ((std::array{n, a, b, c}), (std::array{3, 0, 1, 2}));
}

TEST(SessionFiles, PlyTellsWhereItIsFromAndWhatItIsNot) {
    const std::string program = "made by Palpate " + std::string(program_version()) + "; millimetres";
    Provenance provenance{"0123abcd"};
    Certificate certificate;
    certificate.statement = "Nothing is guaranteed.";
    for (const auto status : {Certificate::Status::certified, Certificate::Status::conditional}) {
        certificate.status = status;
        EXPECT_THAT(mesh_comments(provenance, certificate), ElementsAre(program, "configuration: CRC-32 0123abcd"));
    }
    provenance.object_sha256 = "ff00";
    certificate.status = Certificate::Status::incomplete;
    EXPECT_THAT(mesh_comments(provenance, certificate),
                ElementsAre(program, "configuration: CRC-32 0123abcd", "object: SHA-256 ff00", "incomplete: Nothing is guaranteed."));
    certificate.status = Certificate::Status::refuted;
    EXPECT_EQ(mesh_comments(provenance, certificate).back(), "refuted: Nothing is guaranteed.");
    EXPECT_THAT(to_ply(TriangleMesh{}, {"one", "two"}),
                ::testing::StartsWith("ply\nformat ascii 1.0\ncomment one\ncomment two\nelement vertex 0\n"));
}

// NIST's examples for SHA-256; the long one is read in pieces.
TEST(SessionFiles, TheObjectsHashIsThatOfItsFile) {
    std::string name = (fs::temp_directory_path() / "palpate_files_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    const auto hash_of = [&](const std::string& content) {
        write_file(folder / "part.off", content);
        return file_sha256(folder / "part.off");
    };
    EXPECT_EQ(hash_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hash_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hash_of(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    EXPECT_EQ(file_sha256(folder / "missing"), "");
    EXPECT_EQ(file_sha256(folder), "");

    SessionConfig config;
    EXPECT_EQ(object_sha256(config), "");
    config.object = MeshSpec{folder / "part.off"};
    EXPECT_EQ(object_sha256(config), file_sha256(folder / "part.off"));
    const Provenance of_mesh = provenance_of(config, folder / "out/session", "0123abcd", "ff00");
    EXPECT_EQ(of_mesh.mesh, "../../part.off");
    EXPECT_EQ(of_mesh.object_sha256, "ff00");
    EXPECT_EQ(of_mesh.shape, "");
    config.object = ShapeSpec{std::vector<ShapeSpec>{ShapeSpec{TorusSpec{}}}};
    EXPECT_EQ(object_sha256(config), "");
    EXPECT_EQ(provenance_of(config, folder, "0123abcd", "").shape, "union");
    EXPECT_EQ(provenance_of(config, folder, "0123abcd", "").mesh, "");
    fs::remove_all(folder);
}

// The tables of planner/DESIGN.md, "Session folder": the names in the first column of the one with that head.
std::vector<std::string> documented(const std::string& head) {
    std::ifstream in(fs::path(PALPATE_SOURCE_DIR) / "planner/DESIGN.md");
    std::vector<std::string> names;
    std::string line;
    while (std::getline(in, line) && line != head) {
    }
    std::getline(in, line);  // what stands between head and rows
    while (std::getline(in, line) && line.starts_with('|')) {
        const std::size_t end = line.find(" | ");
        const std::string first = line.substr(0, end);
        const std::string unit = line.substr(end + 3, line.find(" | ", end + 3) - end - 3);
        EXPECT_THAT(unit, ::testing::AnyOf("–", "mm", "mm²", "s")) << line;
        static const std::regex kName("`([^`]+)`");
        for (std::sregex_iterator it(first.begin(), first.end(), kName); it != std::sregex_iterator(); ++it) names.push_back((*it)[1]);
    }
    return names;
}

// The keys of all values, "[]" for each element of a list of objects.
void collect_keys(const nlohmann::json& json, const std::string& path, std::set<std::string>& keys) {
    if (json.is_object()) {
        for (const auto& [key, value] : json.items()) collect_keys(value, path.empty() ? key : path + "." + key, keys);
    } else if (json.is_array() && !json.empty() && json[0].is_object()) {
        for (const auto& element : json) collect_keys(element, path + "[]", keys);
    } else {
        keys.insert(path);
    }
}

TEST(SessionFiles, EveryKeyOfASummaryIsDocumentedAndEveryDocumentedKeyIsWritten) {
    // All that may be missing is there.
    const BadPlace place{{1, 2, 3}, "thin", 0.1};
    Simulation simulation;
    simulation.result.certificate.premises.emplace_back();
    simulation.result.bad_places = simulation.result.thin_places = {place};
    simulation.truth.emplace();
    simulation.curved_truth.emplace();
    simulation.tool.emplace();
    simulation.moves_out_of_area.emplace();
    MachineRun machine;
    machine.result = simulation.result;
    machine.resumptions = {JournalResumption{{1}, {0.5}, 1}};
    machine.drift.emplace();
    std::set<std::string> written;
    const auto add = [&](const std::string& text) { collect_keys(nlohmann::json::parse(text), "", written); };
    Provenance of_mesh{"0123abcd"};
    of_mesh.mesh = "part.stl";
    Provenance of_shape{"0123abcd"};
    of_shape.shape = "torus";
    simulation.result.certificate.premises.push_back({Premise::Kind::known_solids, Premise::State::assumed, ""});
    simulation.result.deviation.emplace().stated[0].touched = 1;
    simulation.result.earlier.emplace();
    add(to_json(simulation, PartResult{}, 0.5, of_mesh));
    add(to_json(machine, {}, 0.5, of_shape));

    const std::vector<std::string> rows = documented("| key | unit | what |");
    EXPECT_GT(rows.size(), 50U) << "the test looks at the wrong table";
    const std::set<std::string> expected(rows.begin(), rows.end());
    EXPECT_EQ(expected.size(), rows.size()) << "a key has two rows";
    EXPECT_EQ(written, expected);

    // With a tool nothing is said of the object's surface.
    simulation.truth.reset();
    const auto of_tool = nlohmann::json::parse(to_json(simulation, {}, 0.5, of_mesh)).at("truth");
    EXPECT_FALSE(of_tool.contains("hausdorff") || of_tool.contains("wrong_facets"));
    EXPECT_TRUE(of_tool.contains("unsafe_moves") && of_tool.contains("tool"));

    // What is null instead.
    const auto bare = nlohmann::json::parse(to_json(MachineRun{}, {}, 0.5, Provenance{"0123abcd"}));
    EXPECT_TRUE(bare.at("object").is_null());
    EXPECT_TRUE(bare.at("machine").at("datum").is_null());
    EXPECT_FALSE(bare.at("machine").contains("drift"));
}

TEST(SessionFiles, EveryColumnOfTouchesIsDocumented) {
    std::string header;
    for (const std::string& column : documented("| column | unit | what |")) header += (header.empty() ? "" : ",") + column;
    EXPECT_EQ(to_csv({}, PartResult{}), header + "\n");
    EXPECT_THAT(header, ::testing::StartsWith("touch,x,y,z,from_x,from_y,from_z,role,sample,"));
}

TEST(SessionFiles, CsvHasOneLinePerTouch) {
    Touch sample{{1, 2, 3}, {1, 2, 4}, Touch::Role::seed_facet, 7};
    Touch crossing{{0.5, 0, 0}, {1, 0, 0}, Touch::Role::crossing, std::nullopt};
    EXPECT_EQ(to_csv({sample, crossing}),
              "touch,x,y,z,from_x,from_y,from_z,role,sample\n"
              "0,1,2,3,1,2,4,seed_facet,7\n"
              "1,0.5,0,0,1,0,0,crossing,\n");
}

std::string complaint_of_writing(const fs::path& file, const std::string& content) {
    try {
        write_file(file, content);
    } catch (const OutputError& error) {
        return error.what();
    }
    return "nothing";
}

TEST(SessionFiles, AFullDiskKeepsWhatWasThere) {
    // /dev/full refuses every byte; only where the system has it.
    if (!fs::exists("/dev/full")) GTEST_SKIP();
    std::string name = (fs::temp_directory_path() / "palpate_files_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    write_file(folder / "kept", "old");
    fs::create_symlink("/dev/full", folder / "kept.unfinished");
    EXPECT_EQ(complaint_of_writing(folder / "kept", "new"), (folder / "kept").string() + ": cannot be written: No space left on device");
    std::ifstream in(folder / "kept");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "old");
    // Larger than a buffer.
    fs::create_symlink("/dev/full", folder / "kept.unfinished");
    EXPECT_THAT(complaint_of_writing(folder / "kept", std::string(1'000'000, 'x')), HasSubstr("No space left on device"));
    fs::remove_all(folder);
}

TEST(SessionFiles, WhatCannotBeWrittenIsSaidWithTheSystemsReason) {
    std::string name = (fs::temp_directory_path() / "palpate_files_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    EXPECT_THAT(complaint_of_writing(folder / "gone/summary.json", "x"),
                HasSubstr("gone/summary.json: cannot be written: No such file or directory"));
    fs::create_directory(folder / "mesh.ply");
    EXPECT_THAT(complaint_of_writing(folder / "mesh.ply", "x"), HasSubstr("mesh.ply: cannot be written: Is a directory"));
    EXPECT_FALSE(fs::exists(folder / "mesh.ply.unfinished"));
    EXPECT_EQ(complaint_of_writing(folder / "empty", ""), "nothing");
    EXPECT_EQ(fs::file_size(folder / "empty"), 0U);
    fs::remove_all(folder);
}

TEST(SessionFiles, AFolderWithoutASessionIsUsed) {
    std::string name = (fs::temp_directory_path() / "palpate_files_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    write_file(folder / "notes.txt", "mine");
    const auto keep = [](std::string_view) { return false; };
    (void)SessionFolder::begin(folder, {}, keep);
    write_file(folder / "mesh.ply", "x");
    EXPECT_THROW((void)SessionFolder::begin(folder, {}, keep), OutputError);
    (void)SessionFolder::begin(folder, {}, [](std::string_view) { return true; });
    EXPECT_TRUE(fs::exists(folder / "notes.txt"));
    fs::remove_all(folder);
}

}  // namespace
}  // namespace palpate::session_files_test
