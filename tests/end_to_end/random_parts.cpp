#include "tests/end_to_end/random_parts.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "planner/topology.h"
#include "tests/random.h"

namespace palpate {
namespace {

using Polygon = std::vector<std::array<double, 2>>;

constexpr double kTwoPi = 2 * std::numbers::pi;

Polygon regular(int corners, double radius, double turned = 0, double x = 0, double y = 0) {
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
        const double angle = turned + kTwoPi * k / corners;
        polygon.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
    }
    return polygon;
}

// Corners at even angles, at the distances from the origin that radius(k) says.
template <typename Radius>
Polygon around(int corners, const Radius& radius) {
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
        const double angle = kTwoPi * k / corners;
        polygon.push_back({radius(k) * std::cos(angle), radius(k) * std::sin(angle)});
    }
    return polygon;
}

// The first polygon is the outline, counter-clockwise; the others are holes.
TriangleMesh extruded(const std::vector<Polygon>& polygons, double height) {
    using K = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Vb = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, K>;
    using Cdt = CGAL::Constrained_Delaunay_triangulation_2<
        K, CGAL::Triangulation_data_structure_2<Vb, CGAL::Constrained_triangulation_face_base_2<K>>>;
    Cdt cdt;
    TriangleMesh mesh;
    std::uint32_t below = 0;
    for (const Polygon& polygon : polygons) below += static_cast<std::uint32_t>(polygon.size());
    std::vector<Cdt::Vertex_handle> vertices;
    for (const Polygon& polygon : polygons) {
        for (const auto& [x, y] : polygon) {
            vertices.push_back(cdt.insert({x, y}));
            vertices.back()->info() = static_cast<std::uint32_t>(vertices.size() - 1);
        }
    }
    for (const double z : {-height / 2, height / 2}) {
        for (const Polygon& polygon : polygons) {
            for (const auto& [x, y] : polygon) mesh.points.emplace_back(x, y, z);
        }
    }
    std::uint32_t first = 0;
    for (const Polygon& polygon : polygons) {
        const auto n = static_cast<std::uint32_t>(polygon.size());
        double doubled_area = 0;
        for (std::uint32_t k = 0; k < n; ++k) {
            const auto& p = polygon[k];
            const auto& q = polygon[(k + 1) % n];
            doubled_area += p[0] * q[1] - p[1] * q[0];
        }
        const bool flip = (doubled_area > 0) != (first == 0);  // holes run clockwise
        for (std::uint32_t k = 0; k < n; ++k) {
            std::uint32_t a = first + k;
            std::uint32_t b = first + (k + 1) % n;
            cdt.insert_constraint(vertices[a], vertices[b]);
            if (flip) std::swap(a, b);
            mesh.triangles.push_back({a, b, b + below});
            mesh.triangles.push_back({a, b + below, a + below});
        }
        first += n;
    }
    // Faces are inside by the parity of constraints between them and the infinite face.
    std::map<Cdt::Face_handle, bool> inside;
    std::vector<std::pair<Cdt::Face_handle, bool>> open{{cdt.infinite_face(), false}};
    while (!open.empty()) {
        const auto [face, is_inside] = open.back();
        open.pop_back();
        if (!inside.emplace(face, is_inside).second) continue;
        for (int k = 0; k < 3; ++k) open.emplace_back(face->neighbor(k), is_inside != face->is_constrained(k));
    }
    for (const auto face : cdt.finite_face_handles()) {
        if (!inside.at(face)) continue;
        const std::uint32_t a = face->vertex(0)->info();
        const std::uint32_t b = face->vertex(1)->info();
        const std::uint32_t c = face->vertex(2)->info();
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({a + below, b + below, c + below});
    }
    return mesh;
}

TriangleMesh cone(int corners, double radius, double height) {
    TriangleMesh mesh;
    const Polygon base = regular(corners, radius);
    for (const auto& [x, y] : base) mesh.points.emplace_back(x, y, -height / 2);
    mesh.points.emplace_back(0, 0, height / 2);
    mesh.points.emplace_back(0, 0, -height / 2);
    const auto n = static_cast<std::uint32_t>(corners);
    for (std::uint32_t k = 0; k < n; ++k) {
        mesh.triangles.push_back({k, (k + 1) % n, n});
        mesh.triangles.push_back({(k + 1) % n, k, n + 1});
    }
    return mesh;
}

TriangleMesh box(const Vector& size) {
    const double x = size.x() / 2;
    const double y = size.y() / 2;
    return extruded({{{-x, -y}, {x, -y}, {x, y}, {-x, y}}}, size.z());
}

void append(TriangleMesh& mesh, const TriangleMesh& other, const Vector& by) {
    const auto offset = static_cast<std::uint32_t>(mesh.points.size());
    for (const Point& p : other.points) mesh.points.emplace_back(p + by);
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + offset, b + offset, c + offset});
}

// The boundary of a set of cells of a grid with those planes; x, y, z.
TriangleMesh of_cells(const std::array<std::vector<double>, 3>& planes, const std::set<std::array<int, 3>>& cells) {
    TriangleMesh mesh;
    std::map<std::array<int, 3>, std::uint32_t> points;
    const auto point = [&](const std::array<int, 3>& at) {
        const auto [found, is_new] = points.try_emplace(at, static_cast<std::uint32_t>(mesh.points.size()));
        if (is_new) {
            Point p;
            for (int k = 0; k < 3; ++k)
                p[k] = planes.at(static_cast<std::size_t>(k)).at(static_cast<std::size_t>(at.at(static_cast<std::size_t>(k))));
            mesh.points.push_back(p);
        }
        return found->second;
    };
    for (const auto& cell : cells) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const int side : {0, 1}) {
                std::array<int, 3> beyond = cell;
                beyond.at(axis) += 2 * side - 1;
                if (cells.contains(beyond)) continue;
                const std::size_t u = (axis + 1) % 3;
                const std::size_t v = (axis + 2) % 3;
                const auto corner = [&](int du, int dv) {
                    std::array<int, 3> at = cell;
                    at.at(axis) += side;
                    at.at(u) += du;
                    at.at(v) += dv;
                    return point(at);
                };
                const std::array<std::uint32_t, 4> q{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
                if (side == 1) {
                    mesh.triangles.push_back({q[0], q[1], q[2]});
                    mesh.triangles.push_back({q[0], q[2], q[3]});
                } else {
                    mesh.triangles.push_back({q[0], q[2], q[1]});
                    mesh.triangles.push_back({q[0], q[3], q[2]});
                }
            }
        }
    }
    return mesh;
}

class Maker {
public:
    explicit Maker(std::uint64_t seed) : random_(seed), seed_(seed) {}

    RandomPart make() {
        static constexpr int kKinds = 11;
        part_.epsilon = uniform(0.07, 0.11);
        switch (seed_ % kKinds) {
            case 0:
                plate();
                break;
            case 1:
                tube();
                break;
            case 2:
                wedge();
                break;
            case 3:
                reflex();
                break;
            case 4:
                slot();
                break;
            case 5:
                star();
                break;
            case 6:
                gear();
                break;
            case 7:
                holes();
                break;
            case 8:
                boxes();
                break;
            case 9:
                sheets();
                break;
            default:
                spike();
                break;
        }
        if (random_.chance(0.5)) turn();
        return std::move(part_);
    }

private:
    double uniform(double low, double high) { return random_.uniform(low, high); }
    // A length about as large as epsilon.
    double thin() { return part_.feature = part_.epsilon * std::exp(uniform(std::log(0.1), std::log(3.0))); }
    int count(int low, int high) { return low + static_cast<int>(random_.below(static_cast<std::size_t>(high - low + 1))); }

    void plate() {
        part_.kind = "plate";
        part_.mesh = box({uniform(0.5, 1.0), uniform(0.5, 1.0), thin()});
    }
    void tube() {
        part_.kind = "tube";
        const double outer = uniform(0.25, 0.4);
        const int corners = count(6, 48);
        const double wall = std::min(thin(), 0.8 * outer);
        part_.feature = std::min(wall, 2 * (outer - wall) * std::cos(std::numbers::pi / corners));
        part_.mesh = extruded({regular(corners, outer), regular(corners, outer - wall)}, uniform(0.3, 0.9));
    }
    void wedge() {
        part_.kind = "wedge";
        static constexpr std::array kDegrees{60.0, 45.0, 30.0, 20.0, 10.0, 5.0, 2.0};
        const double angle = kDegrees.at(random_.below(kDegrees.size())) * std::numbers::pi / 180;
        const double length = uniform(0.5, 0.9);
        part_.feature = 0;
        part_.mesh =
            extruded({{{0, 0}, {length, -length * std::tan(angle / 2)}, {length, length * std::tan(angle / 2)}}}, uniform(0.3, 0.8));
    }
    void reflex() {
        part_.kind = "reflex corner";
        const double a = uniform(0.5, 0.9);
        const double b = uniform(0.5, 0.9);
        const double s = random_.chance(0.5) ? thin() : part_.feature = uniform(0.2, 0.4);
        const double t = uniform(0.15, 0.4);
        part_.mesh = extruded({{{0, 0}, {a, 0}, {a, s}, {t, s}, {t, b}, {0, b}}}, uniform(0.2, 0.7));
    }
    void slot() {
        part_.kind = "slot";
        const double w = thin();
        const double a = uniform(0.2, 0.35);
        const double b = uniform(0.4, 0.8);
        const double floor = uniform(0.1, 0.3);
        part_.mesh = extruded(
            {{{-w / 2 - a, 0}, {w / 2 + a, 0}, {w / 2 + a, b}, {w / 2, b}, {w / 2, floor}, {-w / 2, floor}, {-w / 2, b}, {-w / 2 - a, b}}},
            uniform(0.2, 0.6));
    }
    void star() {
        part_.kind = "star";
        const int points = count(3, 8);
        const double outer = uniform(0.35, 0.5);
        const double inner = outer * uniform(0.25, 0.7);
        part_.feature = 0;
        part_.mesh = extruded({around(2 * points, [&](int k) { return k % 2 == 0 ? outer : inner; })}, uniform(0.1, 0.5));
    }
    void gear() {
        part_.kind = "gear";
        const int teeth = count(6, 16);
        const double outer = uniform(0.35, 0.5);
        const double inner = outer * uniform(0.75, 0.9);
        part_.feature = kTwoPi * inner / (4 * teeth);
        std::vector<Polygon> polygons{around(4 * teeth, [&](int k) { return k % 4 < 2 ? outer : inner; })};
        if (random_.chance(0.5)) {
            const double bore = inner * uniform(0.2, 0.6);
            polygons.push_back(regular(24, bore));
            part_.feature = std::min({part_.feature, 2 * bore, inner - bore});
        }
        part_.mesh = extruded(polygons, uniform(0.1, 0.4));
    }
    void holes() {
        part_.kind = "plate with holes";
        const double a = uniform(0.35, 0.5);
        const double b = uniform(0.25, 0.4);
        std::vector<Polygon> polygons{{{-a, -b}, {a, -b}, {a, b}, {-a, b}}};
        const double thickness = thin();
        const int n = count(1, 3);
        for (int k = 0; k < n; ++k) {
            const double r = uniform(0.3, 0.9) * std::min(a / n, b);
            const int corners = count(3, 20);
            polygons.push_back(regular(corners, r, uniform(0, kTwoPi), a * (2.0 * k + 1 - n) / n, 0));
            // The hole, and the walls beside it.
            part_.feature = std::min({part_.feature, 2 * r * std::cos(std::numbers::pi / corners), 2 * (a / n - r), b - r});
        }
        part_.mesh = extruded(polygons, thickness);
    }
    void boxes() {
        part_.kind = "boxes";
        std::array<std::vector<double>, 3> planes;
        for (auto& axis : planes) {
            double at = 0;
            axis.push_back(at);
            for (int k = 0; k < 3; ++k) axis.push_back(at += uniform(0.1, 0.35));
        }
        part_.feature = 0.1;
        do {
            std::set<std::array<int, 3>> cells;
            std::array<int, 3> at{count(0, 2), count(0, 2), count(0, 2)};
            for (int k = 0; k < 12; ++k) {  // a walk: connected
                cells.insert(at);
                const std::size_t axis = random_.below(3);
                at.at(axis) = std::clamp(at.at(axis) + (random_.chance(0.5) ? 1 : -1), 0, 2);
            }
            part_.mesh = of_cells(planes, cells);
        } while (!analyse_topology(part_.mesh).is_closed_oriented_manifold() || analyse_topology(part_.mesh).components > 1);
    }
    void sheets() {
        part_.kind = "two sheets";
        const double gap = part_.epsilon * uniform(0.1, 1.5);
        const double t = uniform(0.1, 0.3);
        const Vector size(uniform(0.4, 0.8), uniform(0.4, 0.8), t);
        part_.mesh = box(size);
        append(part_.mesh, box(size), (gap + t) * Vector::UnitZ());
        part_.feature = gap;
        part_.seed_rays = {{{0.01, 0.02, -2}, {0.01, 0.02, 0}}, {{0.01, 0.02, 2.2}, {0.01, 0.02, gap + t}}};
    }
    void spike() {
        part_.kind = "cone";
        const bool is_needle = random_.chance(0.5);
        const double radius = is_needle ? thin() / 2 : uniform(0.15, 0.4);
        part_.feature = 0;  // at its tip
        part_.mesh = cone(count(3, 24), radius, uniform(0.5, 1.0));
    }

    void turn() {
        const Eigen::AngleAxisd by(uniform(0, kTwoPi), Vector(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized());
        const Vector at(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
        for (Point& p : part_.mesh.points) p = by * p + at;
        for (Segment& ray : part_.seed_rays) ray = {by * ray.source + at, by * ray.target + at};
    }

    Random random_;
    const std::uint64_t seed_;
    RandomPart part_;
};

}  // namespace

TriangleMesh cut_cube(double side) {
    std::set<std::array<int, 3>> cells;
    for (int k = 0; k < 7; ++k) cells.insert({k % 2, k / 2 % 2, k / 4});
    const std::vector<double> planes{0, side / 2, side};
    return of_cells({planes, planes, planes}, cells);
}

RandomPart random_part(std::uint64_t seed) { return Maker(seed).make(); }

}  // namespace palpate
