// What the tests of sim/ share: a set of shapes, meshes.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "planner/geometry.h"
#include "sim/objects/object_spec.h"
#include "tests/random.h"

namespace palpate {

struct NamedShape {
    std::string name;
    ShapeSpec spec;
};

inline ShapeSpec placed(const ShapeSpec& spec, const Point& at, const Vector& rotate = Vector::Zero()) {
    ShapeSpec result = spec;
    result.at = at;
    result.rotate = rotate;
    return result;
}

inline std::vector<NamedShape> all_primitives() {
    return {{"sphere", {SphereSpec{1.3}}},
            {"ellipsoid", {EllipsoidSpec{{1.0, 0.5, 0.25}}}},
            {"ellipsoid of revolution", {EllipsoidSpec{{0.4, 1.2, 0.4}}}},
            {"disc-like ellipsoid", {EllipsoidSpec{{0.05, 1.0, 1.0}}}},
            {"torus", {TorusSpec{1.0, 0.4}}},
            {"torus with a small hole", {TorusSpec{1.0, 0.9}}},
            {"thin torus", {TorusSpec{1.0, 0.03}}},
            {"capsule", {CapsuleSpec{0.5, 1.5}}},
            {"rounded box", {RoundedBoxSpec{{1.0, 2.0, 0.7}, 0.15}}},
            {"fully rounded box", {RoundedBoxSpec{{1.0, 2.0, 0.7}, 0.35}}},
            {"sharp box", {RoundedBoxSpec{{1.0, 2.0, 0.7}, 0.0}}},
            {"genus2", {Genus2Spec{1.0}}},
            {"large genus2", {Genus2Spec{30.0}}}};
}

// The primitives, every one turned and moved, and unions.
inline std::vector<NamedShape> all_shapes() {
    std::vector<NamedShape> shapes;
    Random random(7);
    for (NamedShape shape : all_primitives()) {
        shape.spec = placed(shape.spec, random.in_box(Point::Constant(-5.0), Point::Constant(5.0)), 3.0 * random.direction());
        shapes.push_back(shape);
    }
    // A ring with a ball in its hole; and, nested, the pair beside a box.
    const std::vector<ShapeSpec> pair{{TorusSpec{1.0, 0.3}}, {SphereSpec{0.4}}};
    const ShapeSpec ring{pair, Point(0.3, 0.2, 0.1), Vector(0.5, 0.1, 0.9)};
    shapes.push_back({"ring and ball", ring});
    const std::vector<ShapeSpec> nested{ring, placed({RoundedBoxSpec{{1.0, 1.0, 1.0}, 0.2}}, {2.6, 0.0, 0.0}, {0.3, 0.0, 0.0})};
    shapes.push_back({"nested union", {nested, Point(-1.0, 0.0, 2.0), Vector(0.0, 1.0, 0.0)}});
    return shapes;
}

// Sphere of four-way split octahedron triangles, points on the sphere.
inline TriangleMesh sphere_mesh(double radius, int levels) {
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (double sign : {1.0, -1.0}) mesh.points.emplace_back(radius * sign * Vector::Unit(axis));
    }
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.points.size()));
            if (added) mesh.points.emplace_back(radius * (mesh.points[a] + mesh.points[b]).normalized());
            return it->second;
        };
        std::vector<std::array<std::uint32_t, 3>> split;
        for (const auto& [a, b, c] : mesh.triangles) {
            const auto ab = middle(a, b);
            const auto bc = middle(b, c);
            const auto ca = middle(c, a);
            split.insert(split.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        mesh.triangles = split;
    }
    return mesh;
}

}  // namespace palpate
