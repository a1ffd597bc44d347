#include "planner/part/traced_surface.h"

#include <algorithm>

namespace palpate {

std::vector<std::uint32_t> points_of_touches(const Result& result) {
    std::vector<std::uint32_t> point_of_sample(result.samples, kNoPoint);
    for (std::size_t k = 0; k < result.sample_of.size(); ++k) point_of_sample[result.sample_of[k]] = static_cast<std::uint32_t>(k);
    std::vector<std::uint32_t> points;
    points.reserve(result.touches.size());
    for (const Touch& touch : result.touches) points.push_back(touch.sample ? point_of_sample[*touch.sample] : kNoPoint);
    return points;
}

TracedSurface traced_surface(const Result& result, const std::vector<std::uint32_t>& point_of_touch) {
    TracedSurface traced{result.mesh, std::vector<std::uint8_t>(result.mesh.points.size()),
                         std::vector<Vector>(result.mesh.points.size(), Vector::Zero()), result.is_outside, result.area};
    for (std::size_t k = 0; k < result.touches.size(); ++k) {
        const std::uint32_t point = point_of_touch[k];
        if (point == kNoPoint) continue;
        const Touch& touch = result.touches[k];
        traced.is_fixture[point] = touch.is_known ? 1 : 0;
        const Vector back = touch.from - touch.position;
        if (back.norm() > 0) traced.to_tool[point] = back.normalized();
    }
    return traced;
}

TriangleMesh mesh_within_area(const Result& result) {
    if (result.is_outside.empty()) return result.mesh;
    TriangleMesh open;
    std::vector<std::uint32_t> number(result.mesh.points.size(), kNoPoint);
    for (std::array<std::uint32_t, 3> corners : result.mesh.triangles) {
        if (std::ranges::any_of(corners, [&](std::uint32_t v) { return result.is_outside[v] != 0; })) continue;
        for (std::uint32_t& v : corners) {
            if (number[v] == kNoPoint) {
                number[v] = static_cast<std::uint32_t>(open.points.size());
                open.points.push_back(result.mesh.points[v]);
            }
            v = number[v];
        }
        open.triangles.push_back(corners);
    }
    return open;
}

}  // namespace palpate
