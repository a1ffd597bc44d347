// palpate export: each format is read again by a reader that others wrote (formats/reread.py), or by one made here from what is known of
// it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace palpate::export_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Export : public ::testing::Test {
protected:
    Export() {
        std::string name = (fs::temp_directory_path() / "palpate_export_XXXXXX").string();
        folder_ = mkdtemp(name.data());
        std::ofstream(folder_ / "torus.yaml")
            << "object: {shape: {torus: {major: 1, minor: 0.4}}}\nworkspace: auto\nprobing: {epsilon: 0.2}\n";
        EXPECT_EQ(palpate("simulate torus.yaml -o s --no-picture"), 0) << read("out.txt");
    }
    ~Export() override { fs::remove_all(folder_); }
    int run(const std::string& command) const {
        const int status = std::system(("cd '" + folder_.string() + "' && " + command + " >out.txt 2>&1 </dev/null").c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    int palpate(const std::string& words) const { return run("'" PALPATE_EXECUTABLE "' " + words); }
    std::string read(const std::string& file) const {
        std::ifstream in(folder_ / file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }

    fs::path folder_;
};

class ExportedMesh : public Export, public ::testing::WithParamInterface<const char*> {};

TEST_P(ExportedMesh, IsReadByOthersAsItIs) {
    const std::string file = std::string("torus.") + GetParam();
    const std::string more = file.ends_with("dxf") ? " --sections -0.3,0,0.125" : "";
    ASSERT_EQ(palpate("export s " + file + more), 0) << read("out.txt");
    const int code = run("/usr/bin/python3 '" PALPATE_SOURCE_DIR "/tests/tools/formats/reread.py' s/mesh.ply " + file);
    if (code == 77) GTEST_SKIP() << read("out.txt");
    EXPECT_EQ(code, 0) << read("out.txt");
}

INSTANTIATE_TEST_SUITE_P(All, ExportedMesh, ::testing::Values("ply", "stl", "obj", "off", "3mf", "vtp", "dxf"),
                         [](const auto& info) { return std::string(info.param); });

TEST_F(Export, PointsHaveNormalsThatPointOutwards) {
    ASSERT_EQ(palpate("export s points.xyz"), 0);
    ASSERT_EQ(palpate("export s points.csv"), 0);
    std::istringstream xyz(read("points.xyz"));
    std::size_t count = 0;
    for (double x, y, z, nx, ny, nz; xyz >> x >> y >> z >> nx >> ny >> nz; ++count) {
        const double out = std::hypot(x, y) - 1;
        EXPECT_NEAR(std::hypot(nx, ny, nz), 1, 1e-12);
        EXPECT_GT((out * (x * nx + y * ny) / std::hypot(x, y) + z * nz) / 0.4, 0.8) << "along the tube's own";
    }
    EXPECT_TRUE(xyz.eof());
    EXPECT_GT(count, 200U);
    EXPECT_THAT(read("points.csv"), ::testing::StartsWith("x,y,z,nx,ny,nz\n"));
    EXPECT_EQ(read("points.csv").size(), read("points.xyz").size() + std::string("x,y,z,nx,ny,nz\n").size());
}

TEST_F(Export, HeightMapsWantAllNodesOrSayWhatIsMissing) {
    EXPECT_EQ(palpate("export s all.probe"), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("nodes lie beside the surface"));
    EXPECT_EQ(palpate("export s all.probe --missing -1 --step 0.5"), 0) << read("out.txt");
    ASSERT_EQ(palpate("export s all.hmap"), 0) << "which may lack some";
    ASSERT_EQ(palpate("export s part.probe --window 0.8,-0.2,1.2,0.2 --step 0.1"), 0) << read("out.txt");
    std::istringstream probe(read("part.probe"));
    double low = 0;
    double high = 0;
    double feed = 0;
    int nx = 0;
    int ny = 0;
    ASSERT_TRUE(probe >> low >> high >> nx >> low >> high >> ny >> low >> high >> feed);
    EXPECT_EQ(nx * ny, 25);
    int count = 0;
    for (double x, y, z; probe >> x >> y >> z; ++count) {
        const double out = std::hypot(x, y) - 1;
        EXPECT_NEAR(z, std::sqrt(0.16 - out * out), 0.05) << x << ' ' << y;
    }
    EXPECT_EQ(count, 25);
    for (const char* words : {"export s m.map --window 0.8,-0.2,1.2,0.2", "export s m.xyz --format ugs --window 0.8,-0.2,1.2,0.2"}) {
        EXPECT_EQ(palpate(words), 0) << read("out.txt");
    }
}

// Against a finely meshed torus of one's own: samples lie on the exact one.
TEST_F(Export, AResultIsInspectedAgainstAReference) {
    std::ofstream(folder_ / "fine.yaml") << "object: {shape: {torus: {major: 1, minor: 0.4}}}\nworkspace: auto\nprobing: {epsilon: 0.05}\n";
    ASSERT_EQ(palpate("simulate fine.yaml -o fine --no-picture"), 0) << read("out.txt");
    EXPECT_EQ(palpate("inspect fine --against fine/mesh.ply --tolerance 1e-9 -o deviations.csv"), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("all samples lie within"));
    EXPECT_THAT(read("deviations.csv"), ::testing::StartsWith("x,y,z,deviation\n"));
    EXPECT_EQ(palpate("inspect s --against fine/mesh.ply --tolerance 0.005"), 0) << read("out.txt");
    EXPECT_EQ(palpate("inspect s --against fine/mesh.ply --tolerance 1e-6"), 6) << read("out.txt");
    EXPECT_EQ(palpate("inspect s --against nowhere.stl"), 2);
    // The same, moved: as it lies, and aligned.
    std::ofstream(folder_ / "moved.yaml") << "object: {shape: {torus: {major: 1, minor: 0.4}, at: [0.02, -0.01, 0.03]}}\nworkspace: auto\n"
                                             "probing: {epsilon: 0.2}\n";
    ASSERT_EQ(palpate("simulate moved.yaml -o moved --no-picture"), 0) << read("out.txt");
    EXPECT_EQ(palpate("inspect moved --against fine/mesh.ply --tolerance 0.005"), 6);
    EXPECT_EQ(palpate("inspect moved --against fine/mesh.ply --tolerance 0.005 --align"), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), ::testing::ContainsRegex("moved by \\(-0.0[12][0-9]*, 0.0[01][0-9]*, -0.0[23]"));
}

TEST_F(Export, WhatCannotBeIsSaidAndNothingIsWritten) {
    const auto says = [&](const std::string& words) {
        EXPECT_EQ(palpate(words), 2) << words;
        return read("out.txt");
    };
    EXPECT_THAT(says("export s torus.step"), HasSubstr("its extension names no format; say --format, one of ply, stl"));
    EXPECT_THAT(says("export s torus.stl --format step"), HasSubstr("--format step: allowed: ply, stl"));
    EXPECT_THAT(says("export nowhere torus.stl"), HasSubstr("nowhere/mesh.ply is not there"));
    EXPECT_THAT(says("export s torus.stl --mesh tool"), HasSubstr("s/mesh_tool.ply is not there"));
    EXPECT_THAT(says("export s torus.dxf"), HasSubstr("--sections"));
    EXPECT_THAT(says("export s torus.dxf --sections 7"), HasSubstr("reaches none of the heights"));
    EXPECT_THAT(says("export s t.probe --window 5,5,6,6"), HasSubstr("nothing of the surface lies in that window"));
    EXPECT_THAT(says("export s t.probe --window 1,1,1,2"), HasSubstr("a window with an area"));
    EXPECT_THAT(says("export s t.probe --step 1e-6"), HasSubstr("10 million"));
    EXPECT_THAT(says("export s nowhere/t.stl"), HasSubstr("nowhere"));
    EXPECT_FALSE(fs::exists(folder_ / "torus.dxf"));
    ASSERT_EQ(palpate("export s torus.stl"), 0);
    const std::string before = read("torus.stl");
    EXPECT_THAT(says("export s torus.stl --mesh part"), HasSubstr("--force"));
    EXPECT_EQ(palpate("export s torus.stl --mesh surface --force"), 0) << read("out.txt");
    EXPECT_NE(read("torus.stl"), before);
}

}  // namespace
}  // namespace palpate::export_test
