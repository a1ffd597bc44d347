#include "tests/planner/part/traced_solids.h"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_criteria_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planner/part/internal/facet_fans.h"
#include "tests/random.h"

namespace palpate {
namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using CgalPoint = Traits::Point_3;
using Function = std::function<double(const CgalPoint&)>;

constexpr double kOnSurface = 1e-7;  // mm

TriangleMesh restricted_delaunay(const Distance& distance, const Ball& bound, double epsilon) {
    const Function function = [&](const CgalPoint& p) { return distance({p.x(), p.y(), p.z()}); };
    const Point& c = bound.center;
    const Traits::Sphere_3 sphere(CgalPoint(c.x(), c.y(), c.z()), bound.radius * bound.radius);
    const CGAL::Implicit_surface_3<Traits, Function> surface(function, sphere, 1e-10);
    const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(25, epsilon, 100 * epsilon);
    Triangulation triangulation;
    Complex complex(triangulation);
    CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_tag(), 60);
    CGAL::Surface_mesh<CgalPoint> cgal_mesh;
    CGAL::facets_in_complex_2_to_triangle_mesh(complex, cgal_mesh);
    TriangleMesh mesh;
    for (const auto v : cgal_mesh.vertices()) {
        const CgalPoint& p = cgal_mesh.point(v);
        mesh.points.emplace_back(p.x(), p.y(), p.z());
    }
    double volume = 0;
    for (const auto f : cgal_mesh.faces()) {
        const auto h = cgal_mesh.halfedge(f);
        mesh.triangles.push_back({cgal_mesh.source(h).idx(), cgal_mesh.target(h).idx(), cgal_mesh.target(cgal_mesh.next(h)).idx()});
        const auto& t = mesh.triangles.back();
        volume += (mesh.points[t[0]] - c).cross(mesh.points[t[1]] - c).dot(mesh.points[t[2]] - c);
    }
    if (volume < 0) {
        for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    }
    return mesh;
}

double over_edge(double in_plane, double along) {
    return std::min(std::max(in_plane, along), 0.0) + std::hypot(std::max(in_plane, 0.0), std::max(along, 0.0));
}

double polygon_distance(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    bool is_inside = false;
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
        const Eigen::Vector2d& a = polygon[i];
        const Eigen::Vector2d& b = polygon[j];
        const Eigen::Vector2d edge = b - a;
        const double t = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (p - a - t * edge).norm());
        if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / edge.y() * edge.x()) is_inside = !is_inside;
    }
    return is_inside ? -nearest : nearest;
}

double largest_circumradius(const TriangleMesh& mesh) {
    double largest = 0;
    for (const auto& [a, b, c] : mesh.triangles) largest = std::max(largest, circumradius(mesh.points[a], mesh.points[b], mesh.points[c]));
    return largest;
}

}  // namespace

Distance ball_distance(const Point& centre, double radius) {
    return [=](const Point& p) { return (p - centre).norm() - radius; };
}
Distance torus_distance(const Point& centre, double major, double minor) {
    return [=](const Point& p) {
        const Point q = p - centre;
        return std::hypot(q.head<2>().norm() - major, q.z()) - minor;
    };
}
Distance swept_torus_distance(const Point& centre, double major, double minor, double length) {
    return [=](const Point& p) {
        const Point q = p - centre;
        return std::hypot(q.head<2>().norm() - major, q.z() - std::clamp(q.z(), -length, 0.0)) - minor;
    };
}
Distance capsule_distance(const Segment& segment, double radius) {
    return [=](const Point& p) { return distance_to(segment, p) - radius; };
}
Distance box_distance(const Box& box) {
    return [=](const Point& p) {
        const Vector off = (p - box.center()).cwiseAbs() - (box.max - box.min) / 2;
        return off.cwiseMax(0).norm() + std::min(off.maxCoeff(), 0.0);
    };
}
Distance prism_distance(std::vector<Eigen::Vector2d> polygon, double half) {
    return [polygon = std::move(polygon), half](const Point& p) {
        return over_edge(polygon_distance(polygon, {p.x(), p.z()}), std::abs(p.y()) - half);
    };
}

Trace trace(const TracedSolid& solid, const ToolShape& tool, double epsilon) {
    const double radius = tool.ball_diameter / 2;
    const auto by_ball = [&](const Point& p) { return solid.part(p) - radius; };
    // What is below the fixture's surface is its own.
    const auto by_shank = [&](const Point& p) {
        if (!solid.swept) return std::numeric_limits<double>::infinity();
        const double height = solid.swept(p) - tool.stylus->diameter / 2;
        return solid.fixture ? std::max(height, solid.fixture->center().z() - p.z()) : height;
    };
    const auto by_fixture = [&](const Point& p) {
        return solid.fixture ? box_distance(*solid.fixture)(p) : std::numeric_limits<double>::infinity();
    };
    CGAL::get_default_random() = CGAL::Random(7);
    Trace result;
    result.surface.mesh = restricted_delaunay(
        [&](const Point& p) {
            return std::min({by_ball(p), by_shank(p), by_fixture(p)});
        },
        solid.bound, epsilon);
    for (const Point& p : result.surface.mesh.points) {
        result.is_shadow.push_back(by_ball(p) > kOnSurface && by_shank(p) < kOnSurface);
        result.surface.is_fixture.push_back(by_fixture(p) < kOnSurface);
    }
    result.epsilon = largest_circumradius(result.surface.mesh);
    return result;
}

Trace shaken(Trace trace, double noise, std::uint64_t seed) {
    Random random(seed);
    TriangleMesh& mesh = trace.surface.mesh;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        if (trace.surface.is_fixture[v] == 0) mesh.points[v] += random.uniform(0, noise) * random.direction();
    }
    trace.epsilon = largest_circumradius(mesh);
    return trace;
}

}  // namespace palpate
