#include "planner/part/internal/facet_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

namespace palpate {
namespace {

FacetPlace place_at(const Corners& triangle, const Vector& share, const Point& from) {
    const Point point = share.x() * triangle[0] + share.y() * triangle[1] + share.z() * triangle[2];
    return {0, share, point, (point - from).norm()};
}

// mm²: from the box to `p`.
double squared_distance(const Box& box, const Point& p) { return (p - p.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm(); }

// The places, as parameters in [0, 1], where two segments are nearest (Ericson, 5.1.9).
std::pair<double, double> nearest_of(const Segment& one, const Segment& other) {
    const Vector u = one.target - one.source;
    const Vector v = other.target - other.source;
    const Vector w = one.source - other.source;
    const double a = u.squaredNorm();
    const double e = v.squaredNorm();
    const double f = v.dot(w);
    const double c = u.dot(w);
    const auto clamped = [](double numerator, double denominator) {
        return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
    };
    if (!(a > 0)) return {0.0, clamped(f, e)};
    if (!(e > 0)) return {clamped(-c, a), 0.0};
    const double b = u.dot(v);
    const double s = clamped(b * f - c * e, a * e - b * b);
    const double t = (b * s + f) / e;
    if (t < 0) return {clamped(-c, a), 0.0};
    if (t > 1) return {clamped(b - c, a), 1.0};
    return {s, t};
}

}  // namespace

FacetPlace nearest_on_triangle(const Corners& triangle, const Point& p) {
    const auto& [a, b, c] = triangle;
    const Vector ab = b - a;
    const Vector ac = c - a;
    const double d1 = ab.dot(p - a);
    const double d2 = ac.dot(p - a);
    if (d1 <= 0 && d2 <= 0) return place_at(triangle, {1, 0, 0}, p);
    const double d3 = ab.dot(p - b);
    const double d4 = ac.dot(p - b);
    if (d3 >= 0 && d4 <= d3) return place_at(triangle, {0, 1, 0}, p);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return place_at(triangle, {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0}, p);
    const double d5 = ab.dot(p - c);
    const double d6 = ac.dot(p - c);
    if (d6 >= 0 && d5 <= d6) return place_at(triangle, {0, 0, 1}, p);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return place_at(triangle, {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)}, p);
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return place_at(triangle, {0, 1 - w, w}, p);
    }
    return place_at(triangle, Vector(va, vb, vc) / (va + vb + vc), p);
}

FacetPlace nearest_on_triangle(const Corners& triangle, const Segment& segment) {
    // Where the segment passes through the triangle.
    const Vector ab = triangle[1] - triangle[0];
    const Vector ac = triangle[2] - triangle[0];
    const Vector way = segment.target - segment.source;
    const Vector normal = ab.cross(ac);
    const double slope = normal.dot(way);
    if (slope != 0) {
        const double t = normal.dot(triangle[0] - segment.source) / slope;
        if (t >= 0 && t <= 1) {
            FacetPlace place = nearest_on_triangle(triangle, segment.source + t * way);
            if (place.distance <= 1e-12 * (ab.norm() + ac.norm())) return place;
        }
    }
    FacetPlace best = nearest_on_triangle(triangle, segment.source);
    const FacetPlace other_end = nearest_on_triangle(triangle, segment.target);
    if (other_end.distance < best.distance) best = other_end;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const auto [s, t] = nearest_of(segment, {triangle[k], triangle[next]});
        Vector share = Vector::Zero();
        share[static_cast<Eigen::Index>(k)] = 1 - t;
        share[static_cast<Eigen::Index>(next)] = t;
        const FacetPlace place = place_at(triangle, share, segment.source + s * way);
        if (place.distance < best.distance) best = place;
    }
    return best;
}

FacetTree::FacetTree(const TriangleMesh& mesh) : mesh_(&mesh), order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    std::vector<Point> middles;
    middles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) middles.emplace_back((mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3);
    nodes_.reserve(2 * mesh.triangles.size() / kLeaf + 2);
    if (!order_.empty()) split(0, static_cast<std::uint32_t>(order_.size()), middles);
}

void FacetTree::split(std::uint32_t first, std::uint32_t count, const std::vector<Point>& middles) {
    const std::size_t at = nodes_.size();
    Node node{{Point::Constant(std::numeric_limits<double>::infinity()), Point::Constant(-std::numeric_limits<double>::infinity())},
              first,
              count,
              0};
    for (std::uint32_t k = first; k < first + count; ++k) {
        for (const std::uint32_t v : mesh_->triangles[order_[k]]) {
            node.box.min = node.box.min.cwiseMin(mesh_->points[v]);
            node.box.max = node.box.max.cwiseMax(mesh_->points[v]);
        }
    }
    nodes_.push_back(node);
    if (count <= kLeaf) return;
    Eigen::Index axis = 0;
    (node.box.max - node.box.min).maxCoeff(&axis);
    const std::uint32_t half = count / 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + half, begin + count,
                     [&](std::uint32_t f, std::uint32_t g) { return std::pair(middles[f][axis], f) < std::pair(middles[g][axis], g); });
    split(first, half, middles);
    nodes_[at].second = static_cast<std::uint32_t>(nodes_.size());
    split(first + half, count - half, middles);
}

FacetPlace FacetTree::nearest(const Point& p) const {
    FacetPlace best;
    // The nearer child first.
    std::array<std::uint32_t, 64> open{};
    std::size_t count = 1;
    while (count > 0) {
        const std::uint32_t at = open[--count];
        const Node& node = nodes_[at];
        if (squared_distance(node.box, p) >= best.distance * best.distance) continue;
        if (node.second == 0) {
            for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
                FacetPlace place = nearest_on_triangle(corners(order_[k]), p);
                if (!(place.distance < best.distance)) continue;
                place.facet = order_[k];
                best = place;
            }
            continue;
        }
        std::uint32_t near = at + 1;
        std::uint32_t far = node.second;
        if (squared_distance(nodes_[far].box, p) < squared_distance(nodes_[near].box, p)) std::swap(near, far);
        open[count++] = far;
        open[count++] = near;
    }
    return best;
}

}  // namespace palpate
