// Mesh files as common programs write them, and what is said of those that cannot be read.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <clocale>
#include <numbers>

#include "tests/sim/objects/mesh/mesh_files.h"

namespace palpate::mesh_formats_test {
namespace {

using namespace std::string_literals;

// A cube of side 20, as text after text of the same eight points and six faces.
constexpr std::array<std::array<int, 4>, 6> kFaces{{{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
std::array<Point, 8> corners() {
    std::array<Point, 8> points;
    for (int i = 0; i < 8; ++i) points.at(static_cast<std::size_t>(i)) = 20.0 * Point(i / 4, i / 2 % 2, i % 2);
    return points;
}

// The points and faces of an OFF file, each line with something behind it.
std::string off_body(const std::string& after_points = "", const std::string& after_faces = "") {
    std::ostringstream text;
    for (const Point& p : corners()) text << p.transpose() << after_points << "\n";
    for (const auto& [a, b, c, d] : kFaces) text << "4 " << a << " " << b << " " << c << " " << d << after_faces << "\n";
    return text.str();
}

std::string obj_points(const std::string& after = "") {
    std::ostringstream text;
    for (const Point& p : corners()) text << "v " << p.transpose() << after << "\n";
    return text.str();
}

// Corner numbers as `spell` writes them, from 0.
template <class Spell>
std::string obj_faces(const Spell& spell) {
    std::string text;
    for (const auto& face : kFaces) {
        text += "f";
        for (const int i : face) text += " " + spell(i);
        text += "\n";
    }
    return text;
}

std::string stl_facets(const std::string& end_of_line, const std::string& normal = "0 0 0") {
    std::ostringstream text;
    text << std::scientific << std::uppercase;
    for (const auto& [a, b, c, d] : kFaces) {
        for (const auto& triangle : {std::array{a, b, c}, std::array{a, c, d}}) {
            text << "facet normal " << normal << end_of_line << "outer loop" << end_of_line;
            for (const int i : triangle) text << "vertex +" << corners().at(static_cast<std::size_t>(i)).transpose() << end_of_line;
            text << "endloop" << end_of_line << "endfacet" << end_of_line;
        }
    }
    return text.str();
}

template <class Number>
void put(std::string& bytes, Number value, std::endian order = std::endian::little) {
    auto raw = std::bit_cast<std::array<char, sizeof value>>(value);
    if (order != std::endian::native) std::ranges::reverse(raw);
    bytes.append(raw.data(), raw.size());
}

std::string binary_stl(const std::string& header) {
    std::string bytes = header + std::string(80 - header.size(), ' ');
    put(bytes, std::uint32_t{12});
    for (const auto& [a, b, c, d] : kFaces) {
        for (const auto& triangle : {std::array{a, b, c}, std::array{a, c, d}}) {
            for (int i = 0; i < 3; ++i) put(bytes, 0.0F);
            for (const int i : triangle) {
                for (const double x : corners().at(static_cast<std::size_t>(i))) put(bytes, static_cast<float>(x));
            }
            put(bytes, std::uint16_t{0});
        }
    }
    return bytes;
}

// Coordinates, list lengths and indices of the given types, among properties and elements that do not count.
template <class Coordinate, class Count, class Index>
std::string binary_ply(std::endian order, const std::string& coordinate, const std::string& count, const std::string& index) {
    std::string text =
        "ply\r\nformat binary_"s + (order == std::endian::little ? "little" : "big") +
        "_endian 1.0\r\ncomment element face 9\r\nelement material 1\r\nproperty list uchar uchar name\r\nproperty short n\r\n"
        "element vertex 8\r\nproperty uchar red\r\nproperty " +
        coordinate + " x\r\nproperty " + coordinate + " y\r\nproperty float64 nx\r\nproperty " + coordinate +
        " z\r\nelement face 6\r\nproperty uint8 flags\r\nproperty list " + count + " " + index +
        " vertex_index\r\nproperty list uchar float texcoord\r\nelement edge 1\r\nproperty int vertex1\r\n"
        "property int vertex2\r\nend_header\r\n";
    text += "\2ab"s;
    put(text, std::int16_t{7}, order);
    for (const Point& p : corners()) {
        text += "\n";
        put(text, static_cast<Coordinate>(p.x()), order);
        put(text, static_cast<Coordinate>(p.y()), order);
        put(text, std::numeric_limits<double>::quiet_NaN(), order);
        put(text, static_cast<Coordinate>(p.z()), order);
    }
    for (const auto& face : kFaces) {
        text += "\r";
        put(text, static_cast<Count>(4), order);
        for (const int i : face) put(text, static_cast<Index>(i), order);
        text += "\1"s;
        put(text, 0.5F, order);
    }
    put(text, std::int32_t{0}, order);
    put(text, std::int32_t{1}, order);
    return text;
}

class MeshFormats : public MeshFiles {
protected:
    static void expect_cube(const MeshSpec& spec) {
        SCOPED_TRACE(spec.file.string());
        try {
            const MeshObject cube(spec);
            EXPECT_EQ(cube.euler_characteristic(), 2);
            EXPECT_EQ(cube.mesh().points.size(), 8U);
            EXPECT_EQ(cube.mesh().triangles.size(), 12U);
            EXPECT_EQ(cube.bounds().min, Point::Zero());
            EXPECT_EQ(cube.bounds().max, Point::Constant(20.0));
            EXPECT_DOUBLE_EQ(cube.area(), 2400.0);
            EXPECT_TRUE(cube.warnings().empty()) << cube.warnings().front();
        } catch (const ObjectError& error) {
            ADD_FAILURE() << error.what();
        }
    }
    void expect_cube(const std::string& name, const std::string& text) const { expect_cube({write(name, text)}); }
    void expect_refusal(const std::string& name, const std::string& text, const std::string& message) const {
        EXPECT_EQ(message_of({write(name, text)}), (folder_ / name).string() + ": " + message);
    }
};

TEST_F(MeshFormats, FilesOfOtherProgramsAreTheSameCube) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    for (const char* name : {"asc_bom.stl", "bom.off", "asc_upper.stl", "uppercase.obj", "asc_name_facet.stl", "asc_no_endsolid.stl",
                             "tabs.obj", "lines_points.obj", "continuation.obj", "tokens_per_line.off", "nocount_edges.off",
                             "big_char_short.ply", "little_int_list_ushort.ply"}) {
        expect_cube({test_case(name)});
    }
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(MeshFormats, OffInAllItsForms) {
    expect_cube("plain.off", "OFF\n8 6 12\n" + off_body());
    expect_cube("header.off", "# made by\nOFF 8 6 12 # counts\n\n" + off_body());
    expect_cube("no keyword.off", "8 6 12\n" + off_body());
    expect_cube(
        "returns.off", "OFF\r8 6 12\r\r" + [] {
            std::string body = off_body();
            std::ranges::replace(body, '\n', '\r');
            return body;
        }());
    expect_cube("colours.off", "OFF\n8 6 0\n" + off_body(" # point", " 3 255 0 0 # red"));
    expect_cube("c.off", "COFF\n8 6 0\n" + off_body(" 0.5 0.5 0.5 1", " 0.5 0.5 0.5"));
    for (const char* keyword : {"NCOFF", "NCSTOFF", "NSTOFF", "CSTOFF", "ncstoff"}) {
        const std::string name = std::string(keyword) + ".off";
        expect_cube(name, std::string(keyword) + "\n8 6 0\n" + off_body(" 1 1 1"));
    }
    std::string broken = "OFF 8 6 0\n";
    for (const Point& p : corners()) broken += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + " ";
    broken += "\n";
    for (const auto& [a, b, c, d] : kFaces) {
        for (const int i : {4, a, b, c, d}) broken += std::to_string(i) + "\n";
    }
    expect_cube("broken.off", broken);
    expect_cube("n.off", "NOFF\n8 6 0\n" + off_body(" 0 0 1"));
    expect_cube("st.off", "STCNOFF\n8 6 0\n" + off_body(" 0 0 1 255 255 255 255 0.5 0.5"));
    expect_cube("undeclared colours.off", "OFF\n8 6 0\n" + off_body(" 255 0 0"));
    expect_cube("garbage.off", "off\n8 6 0\n" + off_body() + "\n\n\n# end\n \t\n");
    std::string one_line = "OFF 8 6 0\n" + off_body();
    std::ranges::replace(one_line, '\n', ' ');
    expect_cube("one line.off", one_line);
}

TEST_F(MeshFormats, OffThatCannotBeRead) {
    expect_refusal("word.off", "OFF\n8 6 0\n0 0 0\n0 0 abc\n", "line 4: 'abc' where a coordinate was expected");
    expect_refusal("nan.off", "OFF\n8 6 0\n0 0 0\n0 nan 0\n", "line 4: 'nan' where a coordinate was expected");
    expect_refusal("large.off", "OFF\n8 6 0\n0 0 0\n0 -1e999 0\n", "line 4: '-1e999' where a coordinate was expected");
    expect_refusal("comma.off", "OFF\n8 6 0\n0,5 0 0\n", "line 3: '0,5' where a coordinate was expected");
    expect_refusal("other.off", "solid \x1B[31m\n", "line 1: 'solid' where 'OFF' was expected");
    expect_refusal("escape.off", "\x1B[31m\n", "line 1: '?[31m' where 'OFF' was expected");
    expect_refusal("counts.off", "OFF\n8 -6 0\n", "line 2: '-6' where the number of faces was expected");
    expect_refusal("cut.off", "OFF\n2 1 0\n0 0 0\n", "line 4: the file ends where a coordinate was expected");
    expect_refusal("binary.off", "OFF BINARY\n8 6 0\n", "line 1: binary OFF cannot be read; export the mesh as text, or in another format");
    expect_refusal("4.off", "4OFF\n8 6 0\n", "line 1: '4OFF' has points that are not of three coordinates; export the mesh as OFF");
    expect_refusal("more.off", "OFF\n8 6 0\n" + off_body() + "# more\n4 0 1 2 3\n",
                   "line 18: '4' follows the 6 faces that the header announces");
    expect_refusal("row.off", "OFF\n3 1 0\n0 0 0\n0 1\n0 1 0\n3 0 1 2\n", "line 4: the line ends where a coordinate was expected");
    expect_refusal("corner.off", "OFF\n3 2 0\n0 0 0\n1 0 1\n0 1 0\n3 0 1\n3 0 1 2\n",
                   "line 6: the line ends where the index of a point was expected");
    expect_refusal("qnan.off", "OFF\n8 6 0\n0 0 0\n0 0 1.#QNAN\n", "line 4: '1.#QNAN' where a coordinate was expected");
    const std::string large = "1" + std::string(450, '0') + "e-50";
    expect_refusal("zeros.off", "OFF\n8 6 0\n" + large + " 0 0\n",
                   "line 3: '" + large.substr(0, 30) + "...' where a coordinate was expected");
    expect_refusal("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
                   "line 6: a face names point -1, but there are 3, counted from 0");
    expect_refusal("half.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n", "line 6: '1.5' where the index of a point was expected");
    expect_refusal("huge.off", "OFF\n3 999999999 0\n0 0 0\n0 0 1\n0 1 0\n",
                   "line 6: the file ends where the number of corners of a face was expected");
    expect_refusal("long face.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n999999999999 0 1 2\n",
                   "line 6: the line ends where the index of a point was expected");
}

TEST_F(MeshFormats, ObjInAllItsForms) {
    const auto plain = [](int i) { return std::to_string(i + 1); };
    expect_cube("plain.obj", "# made by\nmtllib a b.mtl\no cube\ng sides\ns off\nusemtl red\n" + obj_points() + "vt 0 0\nvn 0 0 1\nvp 0\n" +
                                 obj_faces(plain) + "l 1 2\np 1\ncurv 0 1 1 2\n");
    expect_cube("slashes.obj", obj_points() + obj_faces([](int i) { return std::to_string(i + 1) + "/1/1"; }));
    expect_cube("normals.obj", obj_points(" 1.0") + obj_faces([](int i) { return std::to_string(i + 1) + "//1"; }));
    expect_cube("textures.obj", obj_points(" 0.5 0.5 0.5") + obj_faces([](int i) { return std::to_string(i + 1) + "/1"; }));
    expect_cube("negative.obj", obj_points() + obj_faces([](int i) { return std::to_string(i - 8) + "/-1"; }));
    expect_cube("faces first.obj", obj_faces(plain) + obj_points());
    expect_cube("backslashes.obj", "mtllib c:\\\no a\\\n" + obj_points() + "g b\\\nusemtl c\\\n" + obj_faces(plain));
    std::string windows = obj_points() + obj_faces(plain);
    for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 3) windows.replace(at, 1, " \r\n");
    expect_cube("windows.obj", windows);
}

TEST_F(MeshFormats, ObjThatCannotBeRead) {
    expect_refusal("word.obj", "v 0 0 0\nv 0 x 0\n", "line 2: 'x' where a coordinate was expected");
    expect_refusal("short.obj", "v 0 0\nv 0 0 0\n", "line 1: the line ends where a coordinate was expected");
    expect_refusal("zero.obj", "v 0 0 0\nf 0 1 2\n", "line 2: a face names point 0, but there are 1, counted from 1");
    expect_refusal("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 \\\n9\nv 0 0 1\nf 1 2 5\n",
                   "line 6: a face names point 9, but there are 4, counted from 1");
    expect_refusal("back.obj", "v 0 0 0\nf -1 -1 -2\n", "line 2: a face names point -2, but there are 1, counted from 1");
    expect_refusal("slash.obj", "v 0 0 0\nf 1 /1 1\n", "line 2: '/1' where the index of a point was expected");
    expect_refusal("text.obj", "these are words\n", "holds no faces; export it as a surface mesh");
}

TEST_F(MeshFormats, StlInAllItsForms) {
    expect_cube("plain.stl", "solid\n" + stl_facets("\n") + "endsolid\n");
    expect_cube("windows.stl", "solid a cube\r\n\r\n" + stl_facets("\r\n") + "endsolid a cube\r\n\x1A");
    expect_cube("nan.stl", "\n solid facet\n" + stl_facets("\n", "-nan(ind) 1,5 0") + "color 1 0 0\nendsolid\n\ntrailing \x80 garbage\n");
    expect_cube("no solid.stl", stl_facets("\n"));
    expect_cube("one line.stl", "solid\n" + stl_facets(" ") + "endsolid");
    expect_cube("binary.stl", binary_stl("COLOR="));
    expect_cube("solid.stl", binary_stl("solid facet normal"));
    expect_cube("garbage.stl", binary_stl("solid ") + "trailing garbage\n");
}

TEST_F(MeshFormats, StlThatCannotBeRead) {
    expect_refusal("vertex.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertx 0 0 1\n",
                   "line 5: 'vertx' where 'vertex' or 'endloop' was expected");
    expect_refusal("number.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\nvertex 0 0 1\n",
                   "line 5: 'vertex' where a coordinate was expected");
    expect_refusal("facets.stl", "solid\nfacet normal 0 0 1\nouter loop\nendloop\nendfacet\nfacette\n",
                   "line 6: 'facette' where 'facet' or 'endsolid' was expected");
    const std::string text = "solid\n" + stl_facets("\n");
    expect_refusal("cut.stl", text.substr(0, text.size() - 10), "line 84: the file ends where 'endfacet' was expected");
    const std::string binary = binary_stl("");
    expect_refusal("cut binary.stl", binary.substr(0, 384),
                   "byte 384: the file ends in triangle 7 of 12; it is cut off, or not an STL file: export the mesh again");
    expect_refusal("short.stl", "abc",
                   "neither text, which begins with 'solid', nor binary, which has a header of 84 bytes: the file ends after 3");
    expect_refusal("more.stl", binary + binary,
                   "684 bytes follow the 12 triangles that the header announces; export the mesh again, as one solid");
    std::string none = binary;
    none[80] = 0;
    expect_refusal("none.stl", none, "600 bytes follow the 0 triangles that the header announces; export the mesh again, as one solid");
    std::string infinite = binary;
    infinite.replace(84 + 50 + 12 + 4, 4, "\x00\x00\x80\x7F"s);
    expect_refusal("infinite.stl", infinite, "byte 150: inf where a coordinate was expected");
}

TEST_F(MeshFormats, PlyInAllItsTypes) {
    constexpr auto kLittle = std::endian::little;
    constexpr auto kBig = std::endian::big;
    expect_cube("a.ply", binary_ply<float, std::uint8_t, std::int32_t>(kLittle, "float", "uchar", "int"));
    expect_cube("b.ply", binary_ply<double, std::int8_t, std::uint8_t>(kBig, "float64", "int8", "uint8"));
    expect_cube("c.ply", binary_ply<std::int16_t, std::uint16_t, std::int8_t>(kBig, "short", "ushort", "char"));
    expect_cube("d.ply", binary_ply<std::uint8_t, std::int16_t, std::uint16_t>(kLittle, "uchar", "int16", "uint16"));
    expect_cube("e.ply", binary_ply<std::int32_t, std::uint32_t, std::uint32_t>(kBig, "int", "uint32", "uint"));
    expect_cube("f.ply", binary_ply<std::uint32_t, std::int32_t, std::int16_t>(kLittle, "uint", "int32", "int16"));
    // Lines that end with CR only, and data that begins with an LF.
    std::string returns = binary_ply<float, std::uint8_t, std::int32_t>(kLittle, "float", "uchar", "int");
    const std::size_t header = returns.find("end_header") + 12;
    std::string head = returns.substr(0, header);
    std::erase(head, '\n');
    returns.replace(0, header, head);
    returns.replace(head.size(), 3, "\n0123456789"s);  // a name of ten letters
    expect_cube("returns.ply", returns);

    const std::string ascii =
        "\xEF\xBB\xBFply\nformat ascii 1.0\nobj_info x\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
    expect_cube("ascii.ply", ascii +
                                 "element face 6\nproperty list uchar int vertex_indices\nelement edge 0\nproperty int a\nend_header\n" +
                                 off_body() + "\n\n \t\n");
    expect_cube("upper.ply",
                "PLY\nFORMAT ASCII 1.0\nELEMENT VERTEX 8\nPROPERTY FLOAT X\nPROPERTY FLOAT Y\nPROPERTY FLOAT Z\n"
                "ELEMENT Face 6\nPROPERTY LIST UCHAR INT Vertex_Indices\nEND_HEADER\n" +
                    off_body());
    expect_cube("colours.ply", ascii +
                                   "property uchar red\nproperty float nx\nelement face 6\nproperty list uchar int vertex_index\n"
                                   "property uchar red\nend_header\n" +
                                   off_body(" 255 nan", " 17"));
}

TEST_F(MeshFormats, PlyThatCannotBeRead) {
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    expect_refusal("index.ply", head + faces + "3 0 1 3\n", "line 13: a face names point 3, but there are 3, counted from 0");
    expect_refusal("cut.ply", head + faces + "3 0 1\n", "line 13: the line ends where the index of a point was expected");
    expect_refusal("more.ply", head + faces + "3 0 1 2\n\n3 0 1 2\n", "line 15: '3' follows all that the header announces");
    expect_refusal("long.ply", head + faces + "3 0 1 2 1\n", "line 13: '1' where the end of the line was expected");
    expect_refusal("negative.ply", head + faces + "-3 0 1 2\n", "line 13: -3 where the length of a list was expected");
    expect_refusal("strips.ply", head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n",
                   "holds triangle strips (element tristrips), which cannot be read; export the mesh with faces");
    expect_refusal("type.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty real x\n",
                   "line 4: 'real' where a type of numbers such as 'float' or 'int' was expected");
    expect_refusal("format.ply", "ply\nformat binary 1.0\n",
                   "line 2: 'binary' where 'ascii', 'binary_little_endian' or 'binary_big_endian' was expected");
    expect_refusal("header.ply", "ply\nformat ascii 1.0\n",
                   "line 3: the file ends where 'element', 'property' or 'end_header' was expected");
    expect_refusal("no y.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float z\nend_header\n",
                   "the header names no properties x, y and z of element vertex");
    const std::string binary = binary_ply<float, std::uint8_t, std::int32_t>(std::endian::little, "float", "uchar", "int");
    expect_refusal("cut binary.ply", binary.substr(0, binary.size() - 50),
                   "byte " + std::to_string(binary.size() - 50) + ": the file ends where the index of a point was expected");
    expect_refusal("more binary.ply", binary + "\r\n1234567", "9 bytes follow all that the header announces; export the mesh again");
    std::string many = binary;
    many.replace(many.find("vertex 8"), 8, "vertex 900000000000");
    EXPECT_NE(message_of({write("many.ply", many)}).find("the file ends where a coordinate was expected"), std::string::npos);
}

TEST_F(MeshFormats, NumbersDoNotDependOnTheLocale) {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    for (const char* locale : {"de_DE.UTF-8", "fr_FR.UTF-8", "C"}) {
        if (std::setlocale(LC_ALL, locale) == nullptr) continue;
        std::string body = off_body();
        for (std::size_t at = 0; (at = body.find("20", at)) != std::string::npos; at += 4) body.replace(at, 2, "+2.e1");
        expect_cube("dots.off", "OFF\n8 6 0\n" + body);
        const std::string small = "0." + std::string(400, '0') + "1";
        expect_cube("zeros.off", "OFF\n8 6 0\n" + small + " -" + small + "e+5 0\n" + off_body().substr(off_body().find('\n') + 1));
        expect_cube("small.off", "OFF\n8 6 0\n1e-999 0 -.0\n" + off_body().substr(off_body().find('\n') + 1));
    }
    (void)std::setlocale(LC_ALL, before.c_str());
}

}  // namespace
}  // namespace palpate::mesh_formats_test
