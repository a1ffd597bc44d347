#include "sim/internal/mesh_reader.h"

// Polygons are triangulated by a constrained Delaunay triangulation; what triangulate_faces.h brings besides, for holes, is not
// used here and takes as long to compile as all the rest.
#define CGAL_HOLE_FILLING_DO_NOT_USE_DT3
#define CGAL_HOLE_FILLING_DO_NOT_USE_CDT2

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <vector>

#include "sim/errors.h"

namespace palpate {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polygon = std::vector<std::size_t>;

struct Soup {
    std::vector<Kernel::Point_3> points;
    std::vector<Polygon> polygons;
};

[[noreturn]] void refuse(const MeshSpec& spec, const std::string& what) { throw ObjectError(spec.file.string() + ": " + what); }

std::string extension_of(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

bool parse(const std::string& extension, const std::string& file, Soup& soup) {
    if (extension == ".off") return CGAL::IO::read_OFF(file, soup.points, soup.polygons);
    if (extension == ".obj") return CGAL::IO::read_OBJ(file, soup.points, soup.polygons);
    if (extension == ".stl") return CGAL::IO::read_STL(file, soup.points, soup.polygons);
    return CGAL::IO::read_PLY(file, soup.points, soup.polygons);
}

// CGAL's reader believes the counts that a header claims, and would fill the memory before it finds that they are not true.
void check_off_header(const MeshSpec& spec) {
    std::ifstream file(spec.file);
    std::string word;
    std::array<std::uintmax_t, 2> counts{};  // of points, of faces
    for (std::size_t found = 0; found < counts.size() && file >> word;) {
        if (word.front() == '#') {
            std::getline(file, word);
        } else if (std::isdigit(static_cast<unsigned char>(word.front())) != 0) {
            counts.at(found++) = std::strtoull(word.c_str(), nullptr, 10);
        }
    }
    constexpr std::uintmax_t kBytesPerElement = 6;  // "0 0 0" and the end of its line
    if (std::max(counts[0], counts[1]) > std::filesystem::file_size(spec.file) / kBytesPerElement + 1) {
        refuse(spec, "names more points or faces than the file can hold; it is damaged or cut off: export the mesh again");
    }
}

Soup read_soup(const MeshSpec& spec) {
    const std::string extension = extension_of(spec.file);
    constexpr std::array kKnown{".off", ".ply", ".obj", ".stl"};
    if (std::ranges::find(kKnown, extension) == kKnown.end()) refuse(spec, "unknown mesh format; use .off, .ply, .obj or .stl");
    std::error_code error;
    if (!std::filesystem::is_regular_file(spec.file, error)) refuse(spec, "no such file; check the path (it is taken as written)");
    if (std::filesystem::file_size(spec.file, error) == 0) refuse(spec, "the file is empty; export the mesh again");
    if (extension == ".off") check_off_header(spec);
    Soup soup;
    bool parsed = false;
    try {
        parsed = parse(extension, spec.file.string(), soup);
    } catch (const std::exception&) {  // some of CGAL's readers throw on bad input instead of returning false
        parsed = false;
    }
    if (!parsed) refuse(spec, "cannot be read as " + extension.substr(1) + "; check that it is complete and of that format");
    if (soup.polygons.empty()) refuse(spec, "holds no faces; export it as a surface mesh");
    return soup;
}

void check_numbers(const MeshSpec& spec, const Soup& soup) {
    const auto finite = [](const Kernel::Point_3& p) { return std::isfinite(p.x()) && std::isfinite(p.y()) && std::isfinite(p.z()); };
    const auto bad = soup.points.size() - static_cast<std::size_t>(std::ranges::count_if(soup.points, finite));
    if (bad > 0) refuse(spec, std::to_string(bad) + " points have coordinates that are not finite numbers; export the mesh again");
    const auto out_of_range = std::ranges::count_if(
        soup.polygons, [&](const Polygon& p) { return std::ranges::any_of(p, [&](std::size_t i) { return i >= soup.points.size(); }); });
    if (out_of_range > 0) refuse(spec, std::to_string(out_of_range) + " faces name points that do not exist; export the mesh again");
    if (soup.points.size() > std::numeric_limits<std::uint32_t>::max()) refuse(spec, "has more than 2^32 points; simplify it");
}

// Polygons with more than three corners become triangles; each is a mesh of its own, so how they are joined does not matter. One that
// CGAL cannot project to a plane is cut into a fan; if that is wrong, the checks for self-intersection find it.
void append_triangulated(const Soup& soup, const Polygon& polygon, TriangleMesh& out) {
    const auto index = [](std::size_t i) { return static_cast<std::uint32_t>(i); };
    CGAL::Surface_mesh<Kernel::Point_3> mesh;
    std::vector<CGAL::Surface_mesh<Kernel::Point_3>::Vertex_index> corners;
    for (std::size_t i : polygon) corners.push_back(mesh.add_vertex(soup.points[i]));
    const auto face = mesh.add_face(corners);
    if (face != mesh.null_face() && PMP::triangulate_face(face, mesh)) {
        for (const auto f : mesh.faces()) {
            std::array<std::uint32_t, 3> triangle{};
            std::size_t i = 0;
            for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) triangle.at(i++) = index(polygon[v.idx()]);
            out.triangles.push_back(triangle);
        }
        return;
    }
    for (std::size_t i = 2; i < polygon.size(); ++i) out.triangles.push_back({index(polygon[0]), index(polygon[i - 1]), index(polygon[i])});
}

}  // namespace

TriangleMesh read_mesh(const MeshSpec& spec) {
    if (!std::isfinite(spec.scale) || spec.scale <= 0.0) {
        refuse(spec, "scale must be a positive number, but it is " + std::to_string(spec.scale));
    }
    Soup soup = read_soup(spec);
    check_numbers(spec, soup);
    PMP::merge_duplicate_points_in_polygon_soup(soup.points, soup.polygons);
    PMP::remove_isolated_points_in_polygon_soup(soup.points, soup.polygons);
    TriangleMesh mesh;
    mesh.points.reserve(soup.points.size());
    for (const auto& p : soup.points) mesh.points.emplace_back(spec.scale * Point(p.x(), p.y(), p.z()));
    for (const Polygon& polygon : soup.polygons) {
        if (polygon.size() < 3) refuse(spec, "a face has fewer than three corners; export the mesh again");
        if (polygon.size() == 3) {
            mesh.triangles.push_back(
                {static_cast<std::uint32_t>(polygon[0]), static_cast<std::uint32_t>(polygon[1]), static_cast<std::uint32_t>(polygon[2])});
        } else {
            append_triangulated(soup, polygon, mesh);
        }
    }
    return mesh;
}

}  // namespace palpate
