// Objects, tools and fixtures that the tests of sim/tool/ share.
#pragma once

#include <optional>
#include <vector>

#include "planner/fixtures.h"
#include "planner/tool_shape.h"
#include "sim/objects/hidden_object.h"
#include "tests/random.h"

namespace palpate {

// A sharp box as a shape.
inline ShapeSpec solid_box(const Point& min, const Point& max) { return {RoundedBoxSpec{max - min, 0.0}, 0.5 * (min + max)}; }

// A block from -1 to 1 in x and y, its top at z = 0; above it, from x = 0.5 on, a roof from z = 2 to 3.
inline ShapeSpec block_with_roof() {
    return {std::vector<ShapeSpec>{solid_box({-1, -1, -1}, {1, 1, 0}), solid_box({0.5, -1, 2}, {1, 1, 3})}};
}

// A ball of radius 0.2 on a stylus of 0.1, 5 long, in a holder of radius 1.
inline ToolShape slim_probe() {
    ToolShape tool;
    tool.ball_diameter = 0.4;
    tool.stylus = ToolShape::Shaft{0.2, 5};
    tool.holder = ToolShape::Shaft{2, 10};
    return tool;
}

inline ToolShape random_tool(Random& random, double size) {
    ToolShape tool;
    tool.ball_diameter = random.uniform(0.05, 0.4) * size;
    if (random.chance(0.8)) tool.stylus = ToolShape::Shaft{random.uniform(0.2, 1) * tool.ball_diameter, random.uniform(0.1, 2) * size};
    if (tool.stylus && random.chance(0.6)) tool.holder = ToolShape::Shaft{random.uniform(0.1, 1) * size, random.uniform(0.2, 2) * size};
    if (random.chance(0.5)) tool.axis = random.direction();
    return tool;
}

// Up to four boxes that do not touch, as columns side by side.
inline ShapeSpec random_columns(Random& random) {
    std::vector<ShapeSpec> parts;
    for (int k = -1; k <= static_cast<int>(random.below(3)); ++k) {
        const Point low(2.0 * k + random.uniform(0, 0.5), random.uniform(-1, 0), random.uniform(-2, 0));
        parts.push_back(solid_box(low, low + Vector(random.uniform(0.1, 1.4), random.uniform(0.1, 2), random.uniform(0.1, 3))));
    }
    return {parts, Point(random.uniform(-1, 1), 0, 0), random.chance(0.5) ? Vector(3 * random.direction()) : Vector::Zero()};
}

// The same of spheres, capsules and rounded boxes.
inline ShapeSpec random_round_shapes(Random& random) {
    std::vector<ShapeSpec> parts;
    for (int k = -1; k <= static_cast<int>(random.below(2)); ++k) {
        const Point middle(2.0 * k + 0.5, random.uniform(-1, 1), random.uniform(-1, 1));
        const double radius = random.uniform(0.1, 0.8);
        ShapeSpec part{SphereSpec{radius}, middle};
        if (random.chance(0.4)) {
            part = {CapsuleSpec{0.5 * radius, radius}, middle, Vector(3 * random.direction())};
        } else if (random.chance(0.5)) {
            const Vector size(random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1));
            const double fillet = random.chance(0.2) ? 0.5 : random.uniform(0, 0.5);
            part = {RoundedBoxSpec{size, fillet * size.minCoeff()}, middle, Vector(3 * random.direction())};
        }
        parts.push_back(part);
    }
    return {parts, Point(random.uniform(-1, 1), 0, 0), random.chance(0.5) ? Vector(3 * random.direction()) : Vector::Zero()};
}

inline std::vector<Fixture> random_fixtures(Random& random) {
    std::vector<Fixture> fixtures;
    if (random.chance(0.6)) fixtures.emplace_back(Table{random.uniform(-4, -1)});
    if (random.chance(0.4)) {
        const Point low = random.in_box(Point::Constant(-5), Point::Constant(3));
        fixtures.emplace_back(Box{low, low + random.in_box(Point::Constant(0.1), Point::Constant(2))});
    }
    if (random.chance(0.3)) {
        const Vector normal = random.direction();
        fixtures.emplace_back(HalfSpace{-6 * normal, normal});
    }
    return fixtures;
}

}  // namespace palpate
