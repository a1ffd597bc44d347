// Solids in closed form, and meshes of what a tool's ball traces around them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "planner/geometry.h"
#include "planner/part/part_surface.h"
#include "planner/tool_shape.h"

namespace palpate {

// mm: signed distance to a solid's surface, negative inside; exact outside, and inside near what tests look at.
using Distance = std::function<double(const Point&)>;

[[nodiscard]] Distance ball_distance(const Point& centre, double radius);
// Around the z axis; a point of its tube's middle line is `major` from it.
[[nodiscard]] Distance torus_distance(const Point& centre, double major, double minor);
// What lies below a torus and in it: swept down by `length`.
[[nodiscard]] Distance swept_torus_distance(const Point& centre, double major, double minor, double length);
[[nodiscard]] Distance capsule_distance(const Segment& segment, double radius);
[[nodiscard]] Distance box_distance(const Box& box);
// A polygon in x and z, counter-clockwise, from y = -half to half.
[[nodiscard]] Distance prism_distance(std::vector<Eigen::Vector2d> polygon, double half);

struct TracedSolid {
    Distance part;
    Distance swept;              // the part moved along the shank against its axis; empty: the tool has no shank that meets it
    std::optional<Box> fixture;  // grown
    Ball bound;                  // around all, its centre inside
};

// What the ball's centre traces.
struct Trace {
    TracedSurface surface;
    double epsilon = 0.0;                 // mm: the largest circumradius
    std::vector<std::uint8_t> is_shadow;  // per point: the shank's touch, by more than rounding
};

// A restricted Delaunay triangulation with points on S* and balls of at most `epsilon`, as probing leaves it; creases are cut.
[[nodiscard]] Trace trace(const TracedSolid& solid, const ToolShape& tool, double epsilon);
// With touches that are off by up to `noise` in any direction.
[[nodiscard]] Trace shaken(Trace trace, double noise, std::uint64_t seed);

}  // namespace palpate
