#include "tools/formats/mesh_formats.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <iterator>

namespace palpate {
namespace {

constexpr std::size_t kStlHeader = 80;  // bytes; may not begin with "solid", by which text is told

template <typename Value>
void add_bytes(std::string& out, Value value) {
    static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");
    std::array<char, sizeof(Value)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(Value));
    out.append(bytes.data(), bytes.size());
}

void add_floats(std::string& out, const Vector& v) {
    for (int axis = 0; axis < 3; ++axis) add_bytes(out, static_cast<float>(v[axis]));
}

Vector double_area(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Point& a = mesh.points[t[0]];
    return (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a);
}

Vector unit(const Vector& v) {
    const double length = v.norm();
    return length > 0 ? Vector(v / length) : Vector::Zero();
}

void add_points(std::string& out, const char* before, const std::vector<Vector>& points) {
    for (const Point& p : points) fmt::format_to(std::back_inserter(out), "{}{} {} {}\n", before, p.x(), p.y(), p.z());
}

}  // namespace

std::vector<Vector> vertex_normals(const TriangleMesh& mesh) {
    std::vector<Vector> normals(mesh.points.size(), Vector::Zero());
    for (const auto& t : mesh.triangles) {
        for (const std::uint32_t corner : t) normals[corner] += double_area(mesh, t);
    }
    for (Vector& normal : normals) normal = unit(normal);
    return normals;
}

std::string to_stl(const TriangleMesh& mesh) {
    std::string out = "made by Palpate; millimetres";
    out.resize(kStlHeader, ' ');
    add_bytes(out, static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        add_floats(out, unit(double_area(mesh, t)));
        for (const std::uint32_t corner : t) add_floats(out, mesh.points[corner]);
        add_bytes(out, std::uint16_t{0});
    }
    return out;
}

std::string to_obj(const TriangleMesh& mesh) {
    std::string out = "# made by Palpate; millimetres\n";
    add_points(out, "v ", mesh.points);
    add_points(out, "vn ", vertex_normals(mesh));
    for (const auto& t : mesh.triangles) {
        fmt::format_to(std::back_inserter(out), "f {0}//{0} {1}//{1} {2}//{2}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    return out;
}

std::string to_off(const TriangleMesh& mesh) {
    std::string out = fmt::format("OFF\n{} {} 0\n", mesh.points.size(), mesh.triangles.size());
    add_points(out, "", mesh.points);
    for (const auto& t : mesh.triangles) fmt::format_to(std::back_inserter(out), "3 {} {} {}\n", t[0], t[1], t[2]);
    return out;
}

std::string to_vtp(const TriangleMesh& mesh) {
    std::string out = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n<PolyData>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        mesh.points.size(), mesh.triangles.size());
    const auto begin = [&](const char* type, const char* name, int components) {
        out += fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n", type, name, components);
    };
    const auto end = [&] { out += "</DataArray>\n"; };
    out += "<PointData Normals=\"Normals\">\n";
    begin("Float64", "Normals", 3);
    add_points(out, "", vertex_normals(mesh));
    end();
    out += "</PointData>\n<Points>\n";
    begin("Float64", "Points", 3);
    add_points(out, "", mesh.points);
    end();
    out += "</Points>\n<Polys>\n";
    begin("Int64", "connectivity", 1);
    for (const auto& t : mesh.triangles) fmt::format_to(std::back_inserter(out), "{} {} {}\n", t[0], t[1], t[2]);
    end();
    begin("Int64", "offsets", 1);
    for (std::size_t k = 1; k <= mesh.triangles.size(); ++k) fmt::format_to(std::back_inserter(out), "{}\n", 3 * k);
    end();
    return out + "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

std::string to_xyz(const TriangleMesh& mesh) {
    const std::vector<Vector> normals = vertex_normals(mesh);
    std::string out;
    for (std::size_t k = 0; k < mesh.points.size(); ++k) {
        const Point& p = mesh.points[k];
        const Vector& n = normals[k];
        fmt::format_to(std::back_inserter(out), "{} {} {} {} {} {}\n", p.x(), p.y(), p.z(), n.x(), n.y(), n.z());
    }
    return out;
}

}  // namespace palpate
