#include "tools/session_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace palpate {
namespace {

namespace fs = std::filesystem;

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

TEST(SessionFiles, CsvHasOneLinePerTouch) {
    Touch sample{{1, 2, 3}, {1, 2, 4}, Touch::Role::seed_facet, 7};
    Touch crossing{{0.5, 0, 0}, {1, 0, 0}, Touch::Role::crossing, std::nullopt};
    EXPECT_EQ(to_csv({sample, crossing}),
              "touch,x,y,z,from_x,from_y,from_z,role,sample\n"
              "0,1,2,3,1,2,4,seed_facet,7\n"
              "1,0.5,0,0,1,0,0,crossing,\n");
}

TEST(SessionFiles, AFullDiskKeepsWhatWasThere) {
    // /dev/full refuses every byte; only where the system has it.
    if (!fs::exists("/dev/full")) GTEST_SKIP();
    std::string name = (fs::temp_directory_path() / "palpate_files_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    write_file(folder / "kept", "old");
    fs::create_symlink("/dev/full", folder / "kept.unfinished");
    EXPECT_THROW(write_file(folder / "kept", "new"), OutputError);
    std::ifstream in(folder / "kept");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "old");
    fs::remove_all(folder);
}

TEST(SessionFiles, AFolderWithoutASessionIsUsed) {
    std::string name = (fs::temp_directory_path() / "palpate_files_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    write_file(folder / "notes.txt", "mine");
    prepare_session_folder(folder, false);
    write_file(folder / "mesh.ply", "x");
    EXPECT_THROW(prepare_session_folder(folder, false), OutputError);
    prepare_session_folder(folder, true);
    fs::remove_all(folder);
}

}  // namespace
}  // namespace palpate
