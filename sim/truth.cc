#include "sim/truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "sim/facet_places.h"
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

OneSided from_result(const HiddenObject& object, const TriangleMesh& mesh, std::size_t count) {
    OneSided side;
    double total = 0.0;
    double weighted = 0.0;
    std::vector<bool> seen(mesh.points.size(), false);
    for_each_facet(mesh, count, [&](const FacetPlaces& facet) {
        for (const std::uint32_t i : facet.corners) {
            if (!seen[i]) side.max = std::max(side.max, object.distance(mesh.points[i]));
            seen[i] = true;
        }
        double sum = 0.0;
        for (const Point& p : facet.places) {
            const double distance = object.distance(p);
            side.max = std::max(side.max, distance);
            sum += distance;
        }
        total += facet.area;
        weighted += facet.area * sum / static_cast<double>(facet.places.size());
    });
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
