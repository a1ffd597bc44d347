#include "planner/part/internal/bridges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "planner/part/internal/facet_fans.h"
#include "planner/part/internal/surface_fit.h"

namespace palpate {
namespace {

// Rounding, and no more: circumradii are compared with the bound that was kept.
constexpr double kSlack = 1 + 1e-6;
// A wider turn would say that the ball lies in a slot.
constexpr double kMostTurn = 0.95 * std::numbers::pi;

PartTag tag_of(const TracedSurface& traced, const std::vector<TouchedPoint>& touched, std::size_t facet, double epsilon) {
    const auto& corners = traced.mesh.triangles[facet];
    const auto count = [&](PartTag tag) { return std::ranges::count_if(corners, [&](auto v) { return touched[v].tag == tag; }); };
    if (count(PartTag::untouched) > 0) return PartTag::untouched;
    const auto fixtures = count(PartTag::fixture);
    if (fixtures > 0) return fixtures == 3 ? PartTag::fixture : PartTag::untouched;
    if (count(PartTag::shadow) > 0) return PartTag::shadow;
    if (count(PartTag::ambiguous) > 0) return PartTag::ambiguous;
    const auto& points = traced.mesh.points;
    if (circumradius(points[corners[0]], points[corners[1]], points[corners[2]]) > epsilon * kSlack) return PartTag::untouched;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = corners[k];
        const std::uint32_t b = corners[(k + 1) % 3];
        if (is_creased(points[a], touched[a].normal, points[b], touched[b].normal)) return PartTag::bridged;
    }
    return PartTag::tip;
}

// Where the tangent planes at a and b meet, nearest to the middle of both; nothing if that is far off.
std::optional<Point> crease_between(const Point& a, const Vector& normal_a, const Point& b, const Vector& normal_b) {
    const Point middle = (a + b) / 2;
    const double cosine = normal_a.dot(normal_b);
    const double sine_squared = 1 - cosine * cosine;
    const double height_a = normal_a.dot(a - middle);
    const double height_b = normal_b.dot(b - middle);
    const Vector to = ((height_a - cosine * height_b) * normal_a + (height_b - cosine * height_a) * normal_b) / sine_squared;
    if (!(to.norm() <= (b - a).norm())) return std::nullopt;
    return middle + to;
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the smaller first
Edge edge_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

// The facet with points on some of its edges: `middles[k]` on the one from corner k to the next.
std::vector<std::array<std::uint32_t, 3>> pieces_of(const std::array<std::uint32_t, 3>& corners,
                                                    const std::array<std::optional<std::uint32_t>, 3>& middles) {
    const auto splits = std::ranges::count_if(middles, [](const auto& m) { return m.has_value(); });
    std::size_t k = 0;
    // Turned so that the first edge is split, and the last one is not if two are.
    while (splits > 0 && !(middles[k] && (splits != 2 || !middles[(k + 2) % 3]))) ++k;
    const auto [a, b, c] = std::array{corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]};
    if (splits == 0) return {corners};
    const std::uint32_t ab = *middles[k];
    if (splits == 1) return {{a, ab, c}, {ab, b, c}};
    const std::uint32_t bc = *middles[(k + 1) % 3];
    if (splits == 2) return {{a, ab, c}, {ab, bc, c}, {ab, b, bc}};
    const std::uint32_t ca = *middles[(k + 2) % 3];
    return {{a, ab, ca}, {ab, b, bc}, {bc, c, ca}, {ab, bc, ca}};
}

}  // namespace

double bridge_gap(double radius, double turn) { return radius * (1 / std::cos(std::min(turn, kMostTurn) / 2) - 1); }

PartSurface assemble(const TracedSurface& traced, const std::vector<TouchedPoint>& touched, double epsilon) {
    PartSurface part;
    part.mesh.triangles = traced.mesh.triangles;
    for (const TouchedPoint& point : touched) {
        part.mesh.points.push_back(point.point);
        part.normals.push_back(point.normal);
        part.uncertainty.push_back(point.uncertainty);
        part.tags.push_back(point.tag);
    }
    for (std::size_t f = 0; f < part.mesh.triangles.size(); ++f) part.facet_tags.push_back(tag_of(traced, touched, f, epsilon));
    return part;
}

void split_bridges(PartSurface& part, const TracedSurface& traced, double radius) {
    std::map<Edge, std::uint32_t> middles;
    const auto split = [&](std::uint32_t a, std::uint32_t b) {
        const auto [found, is_new] = middles.try_emplace(edge_of(a, b), static_cast<std::uint32_t>(part.mesh.points.size()));
        if (!is_new) return;
        const Point& at_a = traced.mesh.points[a];
        const Point& at_b = traced.mesh.points[b];
        const Vector normal = (part.normals[a] + part.normals[b]).normalized();
        const Point crease = crease_between(at_a, part.normals[a], at_b, part.normals[b]).value_or((at_a + at_b) / 2);
        const double gap = bridge_gap(radius, angle_between(part.normals[a], part.normals[b]));
        part.mesh.points.emplace_back(crease - radius * normal);
        part.normals.push_back(normal);
        part.uncertainty.push_back(std::max(part.uncertainty[a], part.uncertainty[b]) + gap);
        part.tags.push_back(PartTag::bridged);
    };
    const std::size_t points = traced.mesh.points.size();
    for (std::size_t f = 0; f < traced.mesh.triangles.size(); ++f) {
        if (part.facet_tags[f] != PartTag::bridged) continue;
        const auto& corners = traced.mesh.triangles[f];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = corners[k];
            const std::uint32_t b = corners[(k + 1) % 3];
            const double turn = angle_between(part.normals[a], part.normals[b]);
            if (is_creased(traced.mesh.points[a], part.normals[a], traced.mesh.points[b], part.normals[b]) && turn < kMostTurn) split(a, b);
        }
    }
    if (part.mesh.points.size() == points) return;
    TriangleMesh mesh{std::move(part.mesh.points), {}};
    std::vector<PartTag> tags;
    for (std::size_t f = 0; f < part.mesh.triangles.size(); ++f) {
        const auto& corners = part.mesh.triangles[f];
        std::array<std::optional<std::uint32_t>, 3> on_edges;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = middles.find(edge_of(corners[k], corners[(k + 1) % 3]));
            if (found != middles.end()) on_edges[k] = found->second;
        }
        for (const auto& piece : pieces_of(corners, on_edges)) {
            mesh.triangles.push_back(piece);
            tags.push_back(part.facet_tags[f]);
        }
    }
    part.mesh = std::move(mesh);
    part.facet_tags = std::move(tags);
}

}  // namespace palpate
