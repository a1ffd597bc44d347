#include "sim/truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "sim/objects/crofton.h"
#include "sim/objects/errors.h"
#include "sim/objects/triangle_tree.h"

namespace palpate {
namespace {

struct OneSided {
    double max = 0.0;   // mm
    double mean = 0.0;  // mm
};

void check(const TriangleMesh& mesh) {
    const auto in_range = [&](const auto& t) { return std::ranges::all_of(t, [&](auto i) { return i < mesh.points.size(); }); };
    if (!std::ranges::all_of(mesh.triangles, in_range)) {
        throw ObjectError("result mesh: a triangle names a point that does not exist; the file or the program that made it is broken");
    }
    if (!std::ranges::all_of(mesh.points, [](const Point& p) { return p.allFinite(); })) {
        throw ObjectError("result mesh: a point is not finite; the file or the program that made it is broken");
    }
}

double area_of(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Point& a = mesh.points[t[0]];
    return 0.5 * (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).norm();
}

// Calls visit for the centroids of the n² equal triangles that abc is cut into.
template <class Visit>
void for_each_centroid(const Point& a, const Point& b, const Point& c, int n, Visit visit) {
    const Vector u = (b - a) / n;
    const Vector v = (c - a) / n;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
            const Point corner = a + i * u + j * v;
            visit(corner + (u + v) / 3.0);
            if (i + j + 1 < n) visit(corner + 2.0 * (u + v) / 3.0);
        }
    }
}

OneSided from_result(const HiddenObject& object, const TriangleMesh& mesh, std::size_t count) {
    double total = 0.0;
    for (const auto& t : mesh.triangles) total += area_of(mesh, t);
    OneSided side;
    double weighted = 0.0;
    std::vector<bool> seen(mesh.points.size(), false);
    for (const auto& t : mesh.triangles) {
        const double area = area_of(mesh, t);
        for (auto i : t) {
            if (!seen[i]) side.max = std::max(side.max, object.distance(mesh.points[i]));
            seen[i] = true;
        }
        const double share = total > 0.0 ? area / total : 0.0;
        const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(share * static_cast<double>(count)))));
        double sum = 0.0;
        for_each_centroid(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], n, [&](const Point& p) {
            const double distance = object.distance(p);
            side.max = std::max(side.max, distance);
            sum += distance;
        });
        weighted += area * sum / (static_cast<double>(n) * n);
    }
    side.mean = total > 0.0 ? weighted / total : side.max;
    return side;
}

OneSided from_surface(const std::vector<Point>& points, const TriangleMesh& mesh) {
    const TriangleTree tree(mesh);
    OneSided side;
    for (const Point& p : points) {
        const double distance = (p - tree.closest_point(p)).norm();
        side.max = std::max(side.max, distance);
        side.mean += distance / static_cast<double>(points.size());
    }
    return side;
}

}  // namespace

Truth measure_truth(const HiddenObject& object, const TriangleMesh& result, const TruthSampling& sampling, std::uint64_t seed) {
    check(result);
    std::mt19937_64 random(seed);
    const SurfaceSample sample = sample_surface(object, sampling.surface_points, random);
    Truth truth;
    truth.area = object.area().value_or(sample.area);
    truth.euler_characteristic = object.euler_characteristic();
    truth.components = object.components();
    truth.reach = object.reach();
    if (result.triangles.empty()) {
        truth.hausdorff = truth.mean_distance = std::numeric_limits<double>::infinity();
        return truth;
    }
    const OneSided mesh_side = from_result(object, result, sampling.mesh_points);
    const OneSided surface_side = from_surface(sample.points, result);
    truth.hausdorff = std::max(mesh_side.max, surface_side.max);
    truth.mean_distance = 0.5 * (mesh_side.mean + surface_side.mean);
    return truth;
}

SurfaceDistances measure_surface(const HiddenObject& object, const TriangleMesh& mesh, std::size_t points, std::uint64_t seed) {
    check(mesh);
    constexpr double kFar = std::numeric_limits<double>::infinity();
    if (mesh.triangles.empty()) return {kFar, kFar, kFar};
    std::mt19937_64 random(seed);
    const TriangleTree tree(mesh);
    std::vector<double> distances;
    for (const Point& p : sample_surface(object, points, random).points) distances.push_back((p - tree.closest_point(p)).norm());
    std::ranges::sort(distances);
    const auto share = [&](std::size_t percent) { return distances[(distances.size() - 1) * percent / 100]; };
    return {share(95), share(99), distances.back()};
}

}  // namespace palpate
