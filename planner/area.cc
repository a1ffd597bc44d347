#include "planner/area.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Partition_traits_2.h>
#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/partition_2.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Flat = Kernel::Point_2;
using Eigen::Vector2d;

std::vector<Flat> to_cgal(const std::vector<Vector2d>& corners) {
    std::vector<Flat> points;
    points.reserve(corners.size());
    for (const Vector2d& corner : corners) points.emplace_back(corner.x(), corner.y());
    return points;
}

std::string text(const Vector2d& p) { return fmt::format("({:.6g}, {:.6g})", p.x(), p.y()); }

// Counter-clockwise, without corners that lie on the way between their neighbours.
std::vector<Flat> outline_of(const std::vector<Vector2d>& corners) {
    std::vector<Flat> all = to_cgal(corners);
    if (CGAL::orientation_2(all.begin(), all.end()) == CGAL::CLOCKWISE) std::ranges::reverse(all);
    std::vector<Flat> outline;
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (!CGAL::collinear(all[(k + all.size() - 1) % all.size()], all[k], all[(k + 1) % all.size()])) outline.push_back(all[k]);
    }
    return outline;
}

// Vertical, through a and b, with the solid to the right of the way from a to b; moved so far to the left.
KnownSolids::Plane right_of(const Flat& a, const Flat& b, double moved) {
    const Vector normal = Vector(a.y() - b.y(), b.x() - a.x(), 0).normalized();
    return {normal, normal.dot(Point(a.x(), a.y(), 0)) + moved};
}

// Convex pieces of what the outline's hull has besides it, beyond a chain of the outline's edges.
void add_pocket(std::vector<KnownSolids::Convex>& outside, const std::vector<Flat>& chain, double overlap) {
    // The chain goes around what is inside; around the pocket it goes the other way.
    const std::vector<Flat> pocket(chain.rbegin(), chain.rend());
    std::map<Flat, std::size_t> number;
    for (std::size_t k = 0; k < pocket.size(); ++k) number[pocket[k]] = k;
    using Traits = CGAL::Partition_traits_2<Kernel>;
    std::vector<Traits::Polygon_2> pieces;
    CGAL::approx_convex_partition_2(pocket.begin(), pocket.end(), std::back_inserter(pieces), Traits());
    for (const auto& piece : pieces) {
        const std::vector<Flat> corners(piece.vertices_begin(), piece.vertices_end());
        KnownSolids::Convex solid;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const Flat& a = corners[k];
            const Flat& b = corners[(k + 1) % corners.size()];
            // Counter-clockwise around the piece, so that it lies to the left.
            const bool is_wall = number.at(b) == number.at(a) + 1;
            solid.push_back(right_of(b, a, is_wall ? 0.0 : overlap));
        }
        outside.push_back(std::move(solid));
    }
}

std::vector<KnownSolids::Convex> outside_of(const std::vector<Vector2d>& corners, double overlap) {
    const std::vector<Flat> outline = outline_of(corners);
    std::vector<Flat> hull;
    CGAL::convex_hull_2(outline.begin(), outline.end(), std::back_inserter(hull));
    const auto is_on_hull = [&](const Flat& p) {
        for (std::size_t k = 0; k < hull.size(); ++k) {
            if (CGAL::collinear(hull[k], hull[(k + 1) % hull.size()], p)) return true;
        }
        return false;
    };
    std::vector<KnownSolids::Convex> outside;
    for (std::size_t k = 0; k < hull.size(); ++k) outside.push_back({right_of(hull[k], hull[(k + 1) % hull.size()], 0)});
    const auto first = static_cast<std::size_t>(std::ranges::find_if(outline, is_on_hull) - outline.begin());
    std::vector<Flat> chain{outline[first]};
    for (std::size_t k = 1; k <= outline.size(); ++k) {
        const Flat& p = outline[(first + k) % outline.size()];
        chain.push_back(p);
        if (!is_on_hull(p)) continue;
        if (chain.size() > 2) add_pocket(outside, chain, overlap);
        chain = {p};
    }
    return outside;
}

double distance_to_edges(const std::vector<Vector2d>& corners, const Vector2d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vector2d& a = corners[k];
        const Vector2d way = corners[(k + 1) % corners.size()] - a;
        const double share = std::clamp((p - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (a + share * way - p).norm());
    }
    return nearest;
}

// By the number of edges to the right of p.
bool surrounds(const std::vector<Vector2d>& corners, const Vector2d& p) {
    bool is_in = false;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vector2d& a = corners[k];
        const Vector2d& b = corners[(k + 1) % corners.size()];
        if ((a.y() > p.y()) == (b.y() > p.y())) continue;
        if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) is_in = !is_in;
    }
    return is_in;
}

}  // namespace

std::string problem_of(const std::vector<Vector2d>& corners) {
    constexpr const char* kAllowed = "; allowed: at least 3 corners, in order around the area, with edges that do not meet elsewhere (mm)";
    if (corners.size() < 3) return fmt::format("has {} corner(s){}", corners.size(), kAllowed);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::size_t j = i + 1; j < corners.size(); ++j) {
            if (corners[i] == corners[j]) return fmt::format("has the corner {} twice{}", text(corners[i]), kAllowed);
        }
    }
    const std::vector<Flat> points = to_cgal(corners);
    if (!CGAL::is_simple_2(points.begin(), points.end())) return fmt::format("crosses itself, or goes back along itself{}", kAllowed);
    if (outline_of(corners).size() < 3) return fmt::format("has all its corners on one line{}", kAllowed);
    return {};
}

Box bounds_of(const Area& area) {
    if (const auto* box = std::get_if<Box>(&area)) return *box;
    const auto& prism = std::get<Prism>(area);
    Vector2d min = prism.corners.front();
    Vector2d max = min;
    for (const Vector2d& corner : prism.corners) {
        min = min.cwiseMin(corner);
        max = max.cwiseMax(corner);
    }
    return {{min.x(), min.y(), prism.z[0]}, {max.x(), max.y(), prism.z[1]}};
}

double size_of(const Area& area) {
    if (const auto* box = std::get_if<Box>(&area)) return (box->max.x() - box->min.x()) * (box->max.y() - box->min.y());
    const auto& corners = std::get<Prism>(area).corners;
    double twice = 0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vector2d a = corners[k] - corners[0];
        const Vector2d b = corners[(k + 1) % corners.size()] - corners[0];
        twice += a.x() * b.y() - a.y() * b.x();
    }
    return std::abs(twice) / 2;
}

bool is_inside(const Area& area, const Point& p, double depth) {
    if (const auto* box = std::get_if<Box>(&area)) return box->contains(p, -depth);
    const auto& [corners, z] = std::get<Prism>(area);
    if (p.z() < z[0] + depth || p.z() > z[1] - depth) return false;
    const Vector2d flat = p.head<2>();
    const double distance = distance_to_edges(corners, flat);
    return surrounds(corners, flat) ? distance >= depth : distance <= -depth;
}

std::vector<KnownSolids::Convex> outside_of(const Area& area, double overlap) {
    const Box bounds = bounds_of(area);
    std::vector<KnownSolids::Convex> outside;
    const auto add_face = [&](int axis) {
        outside.push_back({{Vector::Unit(axis), bounds.min[axis]}});
        outside.push_back({{-Vector::Unit(axis), -bounds.max[axis]}});
    };
    if (const auto* prism = std::get_if<Prism>(&area)) {
        outside = outside_of(prism->corners, overlap);
    } else {
        add_face(0);
        add_face(1);
    }
    add_face(2);
    return outside;
}

}  // namespace palpate
