#include "sim/facet_places.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace palpate {
namespace {

double area_of(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Point& a = mesh.points[t[0]];
    return 0.5 * (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).norm();
}

// Adds the centroids of the n² equal triangles that abc is cut into.
void add_centroids(const Point& a, const Point& b, const Point& c, int n, std::vector<Point>& places) {
    const Vector u = (b - a) / n;
    const Vector v = (c - a) / n;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
            const Point corner = a + i * u + j * v;
            places.emplace_back(corner + (u + v) / 3.0);
            if (i + j + 1 < n) places.emplace_back(corner + 2.0 * (u + v) / 3.0);
        }
    }
}

}  // namespace

void for_each_facet(const TriangleMesh& mesh, std::size_t count, const std::function<void(const FacetPlaces&)>& visit) {
    double total = 0.0;
    for (const auto& t : mesh.triangles) total += area_of(mesh, t);
    std::vector<Point> places;
    for (const auto& t : mesh.triangles) {
        const double area = area_of(mesh, t);
        const double share = total > 0.0 ? area / total : 0.0;
        const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(share * static_cast<double>(count)))));
        places.clear();
        add_centroids(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], n, places);
        visit({t, area, places});
    }
}

}  // namespace palpate
