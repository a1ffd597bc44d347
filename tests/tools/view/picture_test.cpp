#include "tools/view/picture.h"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/objects/errors.h"
#include "tools/results.h"
#include "tools/session_files.h"
#include "tools/view/internal/lettering.h"
#include "tools/view/png.h"

namespace palpate::picture_test {
namespace {

constexpr int kSize = 160;

TriangleMesh cube() {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) {
        mesh.points.emplace_back((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, (i >> 2) - 0.5);
    }
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

TriangleMesh sphere(std::uint32_t around, std::uint32_t along) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i <= along; ++i) {
        const double latitude = std::numbers::pi * i / along;
        for (std::uint32_t j = 0; j < around; ++j) {
            const double longitude = 2.0 * std::numbers::pi * j / around;
            mesh.points.emplace_back(std::sin(latitude) * std::cos(longitude), std::sin(latitude) * std::sin(longitude),
                                     std::cos(latitude));
            if (i < along) {
                const std::uint32_t a = i * around + j;
                const std::uint32_t b = i * around + (j + 1) % around;
                mesh.triangles.push_back({a, a + around, b});
                mesh.triangles.push_back({b, a + around, b + around});
            }
        }
    }
    return mesh;
}

// Small, parallel and without a floor, so that what is not paper is the mesh.
PictureOptions plain(const Vector& view) {
    PictureOptions options;
    options.view_direction = view;
    options.width_px = kSize;
    options.height_px = kSize;
    options.supersampling = 2;
    options.perspective = false;
    options.ground = false;
    return options;
}

std::array<int, 3> pixel(const Picture& picture, int x, int y) {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width_px) + static_cast<std::size_t>(x));
    return {picture.rgb.at(i), picture.rgb.at(i + 1), picture.rgb.at(i + 2)};
}

// The corners of these pictures are paper.
bool is_paper(const Picture& picture, int x, int y) { return pixel(picture, x, y) == pixel(picture, 0, 0); }

// Of touches, and of nothing else that is drawn.
bool is_red(const Picture& picture, int x, int y) {
    const auto [red, green, blue] = pixel(picture, x, y);
    return red > 2 * green && red > 2 * blue;
}

template <class Test>
int count(const Picture& picture, const Test& test) {
    int result = 0;
    for (int y = 0; y < picture.height_px; ++y) {
        for (int x = 0; x < picture.width_px; ++x) {
            result += test(picture, x, y) ? 1 : 0;
        }
    }
    return result;
}

int covered(const Picture& picture) { return picture.width_px * picture.height_px - count(picture, is_paper); }

std::string complaint(const TriangleMesh& mesh, const PictureOptions& options, std::span<const Point> touches = {}) {
    try {
        (void)draw_picture(mesh, touches, options);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "nothing";
}

TEST(Picture, SpheresSilhouetteHasTheAreaOfACircle) {
    const PictureOptions options = plain({1.0, -2.0, 0.7});
    const double diameter = kSize * (1.0 - 2.0 * options.margin);
    const double area = std::numbers::pi / 4.0 * diameter * diameter;
    // Pixels that are only partly covered count in full: half a pixel more all around.
    EXPECT_NEAR(covered(draw_picture(sphere(96, 48), {}, options)), area + std::numbers::pi * diameter / 2.0, 0.01 * area);
}

TEST(Picture, CubesSilhouetteAlongItsDiagonalIsAHexagon) {
    const PictureOptions options = plain({1.0, 1.0, 1.0});
    const double side = kSize * (1.0 - 2.0 * options.margin) / 2.0;  // two corners are above each other
    const double area = 1.5 * std::sqrt(3.0) * side * side;
    EXPECT_NEAR(covered(draw_picture(cube(), {}, options)), area + 3.0 * side, 0.015 * area);
}

TEST(Picture, CubesFaceFillsThePictureUpToTheMargin) {
    PictureOptions options = plain({0.0, -1.0, 0.0});
    options.margin = 0.1;
    const Picture picture = draw_picture(cube(), {}, options);
    const int low = kSize / 10;
    const int high = kSize - kSize / 10;
    EXPECT_EQ(covered(picture), (high - low) * (high - low));
    EXPECT_FALSE(is_paper(picture, low, low));
    EXPECT_FALSE(is_paper(picture, high - 1, high - 1));
    EXPECT_TRUE(is_paper(picture, low - 1, kSize / 2));
    EXPECT_TRUE(is_paper(picture, kSize / 2, high));
}

TEST(Picture, PerspectiveFillsTheSameFrame) {
    PictureOptions options = plain({1.0, -1.5, 0.8});
    options.perspective = true;
    options.width_px = 2 * kSize;  // the height decides
    options.margin = 0.1;
    const Picture picture = draw_picture(sphere(48, 24), {}, options);
    EXPECT_EQ(picture.width_px, 2 * kSize);
    EXPECT_EQ(picture.height_px, kSize);
    int first = kSize;
    int last = 0;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < 2 * kSize; ++x) {
            if (!is_paper(picture, x, y)) {
                first = std::min(first, y);
                last = std::max(last, y);
            }
        }
    }
    EXPECT_NEAR(first, kSize / 10, 1);
    EXPECT_NEAR(last, kSize - kSize / 10 - 1, 1);
}

TEST(Picture, NearFacesHideFarOnes) {
    // Whichever is drawn first.
    TriangleMesh mesh = cube();
    const Picture picture = draw_picture(mesh, {}, plain({0.3, -1.0, 0.4}));
    std::reverse(mesh.triangles.begin(), mesh.triangles.end());
    EXPECT_EQ(picture.rgb, draw_picture(mesh, {}, plain({0.3, -1.0, 0.4})).rgb);
}

TEST(Picture, TouchesOnTheNearSideAreDotsWhereTheyAre) {
    for (const bool perspective : {false, true}) {
        PictureOptions options = plain({0.0, -1.0, 0.0});
        options.perspective = perspective;
        options.touch_radius = 10.0;  // as large as they get
        const std::vector<Point> touches{{0.0, -0.5, 0.0}};
        const Picture picture = draw_picture(cube(), touches, options);
        EXPECT_TRUE(is_red(picture, kSize / 2, kSize / 2));
        // 0.025 of half the cube's diagonal, on a cube 134 pixels wide: 2.9 pixels in radius.
        EXPECT_NEAR(count(picture, is_red), 27, 10);
        EXPECT_FALSE(is_red(picture, kSize / 2 + 5, kSize / 2));
    }
}

TEST(Picture, TouchesOnTheFarSideAndInsideAreHidden) {
    const std::vector<Point> touches{{0.0, 0.5, 0.0}, {0.2, 0.5, -0.3}, {0.0, 0.0, 0.0}, {0.1, -0.4, 0.1}};
    for (const bool perspective : {false, true}) {
        PictureOptions options = plain({0.0, -1.0, 0.0});
        options.perspective = perspective;
        EXPECT_EQ(count(draw_picture(cube(), touches, options), is_red), 0);
    }
}

TEST(Picture, ASphereShowsTheTouchesOfOneHalf) {
    const TriangleMesh mesh = sphere(24, 12);
    std::vector<Point> front;
    std::vector<Point> back;
    for (const Point& p : mesh.points) {
        if (std::abs(p.y()) > 0.4) {  // not on the silhouette, where half a dot looks around the corner
            (p.y() < 0.0 ? front : back).push_back(p);
        }
    }
    EXPECT_EQ(count(draw_picture(mesh, back, plain({0.0, -1.0, 0.0})), is_red), 0);
    EXPECT_GT(count(draw_picture(mesh, front, plain({0.0, -1.0, 0.0})), is_red), static_cast<int>(5 * front.size()));
}

TEST(Picture, EdgesAreDarkLines) {
    PictureOptions options = plain({0.0, -1.0, 0.0});
    const std::array<int, 3> with = pixel(draw_picture(cube(), {}, options), kSize / 2, kSize / 2);  // on the face's diagonal
    options.edges = false;
    const std::array<int, 3> without = pixel(draw_picture(cube(), {}, options), kSize / 2, kSize / 2);
    EXPECT_LT(with[0], without[0] - 20);
}

TEST(Picture, TheFloorIsShadedFromAboveOnly) {
    PictureOptions options = plain({1.0, -1.8, 1.0});
    const int bare = covered(draw_picture(cube(), {}, options));
    options.ground = true;
    EXPECT_GT(covered(draw_picture(cube(), {}, options)), bare + kSize);
    options.view_direction.z() = -1.0;
    const int below = covered(draw_picture(cube(), {}, options));
    options.ground = false;
    EXPECT_EQ(below, covered(draw_picture(cube(), {}, options)));
}

TEST(Picture, NothingShowsBetweenTriangles) {
    for (const int supersampling : {1, 3}) {
        PictureOptions options = plain({1.0, -2.0, 0.7});
        options.perspective = true;
        options.supersampling = supersampling;
        const Picture picture = draw_picture(sphere(301, 157), {}, options);
        const double radius = kSize * (0.5 - options.margin) - 2.0;
        EXPECT_EQ(count(picture,
                        [radius](const Picture& p, int x, int y) {
                            return std::hypot(x + 0.5 - kSize / 2.0, y + 0.5 - kSize / 2.0) < radius && is_paper(p, x, y);
                        }),
                  0);
    }
}

TEST(Picture, LightIsEvenOnFlatFacesUpToTheirCrease) {
    PictureOptions options = plain({1.0, -1.0, 0.0});
    options.edges = false;
    const Picture picture = draw_picture(cube(), {}, options);  // its vertical edge is in the middle
    const std::array<int, 3> left = pixel(picture, kSize / 4, kSize / 2);
    const std::array<int, 3> right = pixel(picture, 3 * kSize / 4, kSize / 2);
    EXPECT_GT(std::abs(left[0] - right[0]), 20);
    for (int x = 20; x < kSize / 2; ++x) {
        for (int channel = 0; channel < 3; ++channel) {
            EXPECT_NEAR(pixel(picture, x, kSize / 2).at(channel), left.at(channel), 1) << x;
            EXPECT_NEAR(pixel(picture, kSize - 1 - x, kSize / 2).at(channel), right.at(channel), 1) << x;
        }
    }
}

TEST(Picture, FlatMeshesAndSliversAreDrawn) {
    const TriangleMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 0}}, {{0, 1, 2}, {1, 2, 3}, {0, 0, 1}}};
    EXPECT_GT(covered(draw_picture(flat, {}, plain({0.0, -1.0, 1.0}))), kSize);
    EXPECT_EQ(draw_picture(flat, {}, plain({0.0, -1.0, 0.0})).rgb.size(), std::size_t{3} * kSize * kSize);  // seen edge-on
}

TEST(PictureLegend, NamesColoursInTheLowerMarginAndChangesNothingElse) {
    PictureOptions options = plain({1.0, -2.0, 0.7});
    options.width_px = 4 * kSize;
    options.height_px = 3 * kSize;
    const Picture without = draw_picture(cube(), {}, options);
    options.legend = {{{10, 200, 30}, "green 12 %"}, {{200, 20, 210}, "violet < 1 %"}};
    const Picture with = draw_picture(cube(), {}, options);
    const int free = options.height_px - static_cast<int>(options.margin * options.height_px);
    const auto is_same = [&](int x, int y) { return pixel(with, x, y) == pixel(without, x, y); };
    std::vector<std::array<int, 2>> reach;  // of each colour, from left to right
    for (const LegendEntry& entry : options.legend) {
        const std::array<int, 3> colour{entry.colour[0], entry.colour[1], entry.colour[2]};
        int left = options.width_px;
        int right = -1;
        for (int x = 0; x < options.width_px; ++x) {
            for (int y = 0; y < options.height_px; ++y) {
                if (pixel(with, x, y) != colour) continue;
                left = std::min(left, x);
                right = std::max(right, x);
            }
        }
        EXPECT_GE(right - left, 5);
        reach.push_back({left, right});
    }
    // Dark letters to the right of each colour.
    const auto darkest = [&](int from, int to) {
        int least = 255;
        for (int x = from; x < to; ++x) {
            for (int y = free; y < options.height_px; ++y) least = std::min(least, pixel(with, x, y)[1]);
        }
        return least;
    };
    EXPECT_LT(reach[0][1], reach[1][0]);
    EXPECT_LT(darkest(reach[0][1] + 1, reach[1][0]), 90);
    EXPECT_LT(darkest(reach[1][1] + 1, options.width_px), 90);
    for (int y = 0; y < options.height_px; ++y) {
        for (int x = 0; x < options.width_px; ++x) ASSERT_TRUE(y >= free || is_same(x, y)) << x << ", " << y;
    }
    EXPECT_EQ(with.rgb, draw_picture(cube(), {}, options).rgb);
}

TEST(PictureLegend, GetsSmallerWhereItWouldNotFit) {
    PictureOptions options = plain({1.0, -2.0, 0.7});
    options.height_px = 4 * kSize;
    options.width_px = 3 * kSize;
    const Picture without = draw_picture(cube(), {}, options);
    const std::string text = "a rather long text of something";
    options.legend = {{{10, 200, 30}, text}, {{200, 20, 210}, text}, {{10, 20, 210}, text}};
    const Picture with = draw_picture(cube(), {}, options);
    for (int y = 0; y < options.height_px; ++y) {
        for (const int x : {0, 1, options.width_px - 2, options.width_px - 1}) EXPECT_EQ(pixel(with, x, y), pixel(without, x, y));
    }
    EXPECT_NE(with.rgb, without.rgb);
    // ... and smallest letters that do not fit are cut off.
    options.width_px = options.height_px = 20;
    EXPECT_EQ(draw_picture(cube(), {}, options).rgb.size(), 3U * 20 * 20);
}

TEST(PictureLegend, DrawsAnyText) {
    const auto ink = [](const std::string& text) {
        const Lettering line = letter(text, 20);
        EXPECT_EQ(line.cover.size(), static_cast<std::size_t>(line.width_px * line.height_px));
        EXPECT_TRUE(std::ranges::all_of(line.cover, [](float c) { return c >= 0 && c <= 1; }));
        return std::accumulate(line.cover.begin(), line.cover.end(), 0.0F);
    };
    EXPECT_EQ(ink(""), 0.0F);
    EXPECT_EQ(ink("   "), 0.0F);
    EXPECT_GT(ink("l"), 10.0F);
    EXPECT_GT(ink("ll"), 1.9F * ink("l"));
    EXPECT_NE(ink("tip"), ink("pit "));
    EXPECT_GT(ink("µ"), 10.0F);
    EXPECT_EQ(ink("\xff\xfe"), 0.0F) << "no UTF-8";
    EXPECT_GT(letter("tip", 40).width_px, letter("tip", 20).width_px);
}

class PictureFile : public testing::Test {
protected:
    void SetUp() override {
        std::string name = (std::filesystem::temp_directory_path() / "palpate-XXXXXX").string();
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    [[nodiscard]] std::string read(const std::string& file) const {
        std::ifstream in(folder_ / file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    // What is said of the session's mesh, without its name.
    [[nodiscard]] std::string refusal() const {
        try {
            draw_session_picture(folder_, 'z');
        } catch (const ObjectError& error) {
            return std::string(error.what()).substr((folder_ / "mesh.ply: ").string().size());
        }
        return "nothing";
    }

    std::filesystem::path folder_;
};

TEST_F(PictureFile, HoldsWhatIsDrawnAndIsTheSameEachTime) {
    PictureOptions options = plain({1.0, -1.8, 1.0});
    options.height_px = kSize / 2;
    options.ground = true;
    const TriangleMesh mesh = sphere(24, 12);
    const std::string png = to_png(draw_picture(mesh, mesh.points, options));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0);
    EXPECT_EQ(image.width, static_cast<png_uint_32>(kSize));
    EXPECT_EQ(image.height, static_cast<png_uint_32>(kSize / 2));
    image.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
    ASSERT_NE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr), 0);
    EXPECT_EQ(rgb, draw_picture(mesh, mesh.points, options).rgb);
}

TEST_F(PictureFile, OfASessionIsDrawnAgainFromItsMesh) {
    Result result;
    result.mesh = sphere(24, 12);
    EXPECT_EQ(write_results(folder_, result, {}, {}, Provenance{}, "{}", {.drawn = true, .up = 'y'}),
              "mesh.ply, touches.csv, summary.json, picture.png");
    const std::string drawn = read("picture.png");
    std::filesystem::remove(folder_ / "picture.png");
    draw_session_picture(folder_, 'y');
    EXPECT_EQ(read("picture.png"), drawn);
    draw_session_picture(folder_, 'z');
    EXPECT_NE(read("picture.png"), drawn);
}

TEST_F(PictureFile, OfAnotherMeshDoesNotStay) {
    Result result;
    result.mesh = cube();
    (void)write_results(folder_, result, {}, {}, Provenance{}, "{}", {});
    EXPECT_TRUE(std::filesystem::exists(folder_ / "picture.png"));
    EXPECT_EQ(write_results(folder_, result, {}, {}, Provenance{}, "{}", {.drawn = false}), "mesh.ply, touches.csv, summary.json");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "picture.png"));
}

TEST_F(PictureFile, IsRefusedWithoutAMeshOfTriangles) {
    const std::string header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n";
    const std::string faces = "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    EXPECT_EQ(refusal(), "no such file; check the path (it is taken as written)");
    write_file(folder_ / "mesh.ply", to_ply(TriangleMesh{}));
    EXPECT_EQ(refusal(), "holds no faces; export it as a surface mesh");
    write_file(folder_ / "mesh.ply", header + "element face 1\n" + faces + "4 0 1 2 3\n");
    EXPECT_EQ(refusal(), "a face has 4 corners, and only triangles are expected");
    write_file(folder_ / "mesh.ply", header + "element face 2\n" + faces + "3 0 1 2\n");
    EXPECT_EQ(refusal(), "line 15: the file ends where the length of a list was expected");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "picture.png"));
}

TEST(PictureErrors, SayWhatIsWrong) {
    const PictureOptions good = plain({1.0, -1.0, 1.0});
    EXPECT_EQ(complaint({}, good), "picture: the mesh has no triangles");
    EXPECT_EQ(complaint({{{0, 0, 0}}, {{0, 0, 1}}}, good), "picture: a triangle has vertex 1 of 1");
    EXPECT_EQ(complaint({{{1, 2, 3}}, {{0, 0, 0}}}, good), "picture: all vertices of the mesh are one point");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(complaint({{{0, 0, 0}, {1, nan, 0}}, {{0, 0, 1}}}, good), "picture: vertex 1 is not finite");
    const std::vector<Point> touches{{nan, 0, 0}};
    EXPECT_EQ(complaint(cube(), good, touches), "picture: a touch is not finite");
}

TEST(PictureErrors, CoverEveryOption) {
    const auto with = [](auto change) {
        PictureOptions options = plain({1.0, -1.0, 1.0});
        change(options);
        return complaint(cube(), options);
    };
    EXPECT_EQ(with([](PictureOptions& o) { o.width_px = 0; }), "picture: width and height have to be at least 1 pixel");
    EXPECT_EQ(with([](PictureOptions& o) { o.height_px = -1; }), "picture: width and height have to be at least 1 pixel");
    EXPECT_EQ(with([](PictureOptions& o) { o.width_px = o.height_px = 1000000; }), "picture: width times height is too large");
    EXPECT_EQ(with([](PictureOptions& o) { o.supersampling = 0; }), "picture: supersampling has to be 1 to 8");
    EXPECT_EQ(with([](PictureOptions& o) { o.margin = 0.5; }), "picture: the margin has to be at least 0 and less than 0.5");
    EXPECT_EQ(with([](PictureOptions& o) { o.touch_radius = -1.0; }), "picture: the radius of touches has to be at least 0");
    const std::string direction = "picture: the view has to have a direction that is not parallel to up";
    EXPECT_EQ(with([](PictureOptions& o) { o.view_direction = 3.0 * o.up; }), direction);
    EXPECT_EQ(with([](PictureOptions& o) { o.view_direction.setZero(); }), direction);
    EXPECT_EQ(with([](PictureOptions& o) { o.up.setConstant(std::numeric_limits<double>::infinity()); }), direction);
}

}  // namespace
}  // namespace palpate::picture_test
