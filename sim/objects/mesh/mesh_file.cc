#include "sim/objects/mesh/mesh_file.h"

#include <fmt/format.h>

#include <utility>

#include "sim/objects/errors.h"
#include "sim/objects/mesh/internal/mesh_reader.h"

namespace palpate {

TriangleMesh read_triangles(const std::filesystem::path& file) {
    PolygonSoup soup = read_mesh(file);
    TriangleMesh mesh{std::move(soup.points), {}};
    mesh.triangles.reserve(soup.polygons.size());
    for (const auto& polygon : soup.polygons) {
        if (polygon.size() != 3) {
            throw ObjectError(fmt::format("{}: a face has {} corners, and only triangles are expected", file.string(), polygon.size()));
        }
        mesh.triangles.push_back({polygon[0], polygon[1], polygon[2]});
    }
    return mesh;
}

}  // namespace palpate
