#include "sim/objects/mesh/internal/mesh_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>

#include "sim/objects/mesh/internal/flat_triangles.h"
#include "sim/objects/mesh/internal/mesh_weld.h"
#include "sim/objects/mesh/internal/message_text.h"
#include "sim/objects/mesh/internal/orientation.h"
#include "sim/objects/mesh/internal/triangulation.h"

namespace palpate {
namespace {

using Polygon = std::vector<std::uint32_t>;

Polygon sorted(Polygon polygon) {
    std::ranges::sort(polygon);
    return polygon;
}

// A corner that is named twice in a row counts once, which changes nothing; faces of less than three corners go. Returns how many.
std::size_t drop_faces_without_corners(PolygonSoup& soup) {
    for (Polygon& polygon : soup.polygons) {
        polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
        while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
    }
    return std::erase_if(soup.polygons, [](const Polygon& polygon) {
        return polygon.size() < 3 || (polygon.size() > 3 && std::set(polygon.begin(), polygon.end()).size() < 3);
    });
}

// Faces of the same corners, whichever way round: all but the first. Returns how many.
std::size_t drop_repeated_faces(PolygonSoup& soup) {
    std::set<Polygon> known;
    return std::erase_if(soup.polygons, [&](const Polygon& polygon) { return !known.insert(sorted(polygon)).second; });
}

void drop_unused_points(TriangleMesh& mesh) {
    std::vector<std::uint32_t> names(mesh.points.size(), 0);
    for (const auto& t : mesh.triangles) {
        for (const std::uint32_t i : t) names[i] = 1;
    }
    std::uint32_t used = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == 0) continue;
        mesh.points[used] = mesh.points[i];
        names[i] = used++;
    }
    mesh.points.resize(used);
    for (auto& t : mesh.triangles) {
        for (std::uint32_t& i : t) i = names[i];
    }
}

}  // namespace

RepairedMesh repaired(PolygonSoup soup, double scale) {
    RepairedMesh result;
    const auto add = [&](std::size_t n, const std::string& one, const std::string& many, const std::string& remedy) {
        if (n > 0) result.repairs.push_back({counted(n, one, many), fmt::format("{} {}", n == 1 ? "was" : "were", remedy)});
    };
    join_equal_points(soup);
    std::size_t flat = drop_faces_without_corners(soup);
    const Weld weld = weld_open_edges(soup);
    const std::size_t repeated = drop_repeated_faces(soup);
    result.mesh = triangulated(std::move(soup));
    flat += drop_flat_triangles(result.mesh);
    drop_unused_points(result.mesh);
    const std::size_t turned = orient_coherently(result.mesh);

    const std::string distance = rounded_text(scale * weld.distance);
    add(weld.corners, fmt::format("corner that differs from another by at most {} mm", distance),
        fmt::format("corners that differ from others by at most {} mm", distance), "joined");
    add(flat, "face without area", "faces without area", "dropped");
    add(repeated, "face that was there already", "faces that were there already", "dropped");
    add(turned, "triangle that faced the other way than those around it", "triangles that faced the other way than those around them",
        "turned");
    return result;
}

}  // namespace palpate
