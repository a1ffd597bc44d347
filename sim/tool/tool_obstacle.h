// What the reference point of a tool cannot enter: the hidden object and the fixtures, grown by the mirrored tool,
// O* = (O ∪ fixtures) ⊕ (−T). Its surface S* is what a machine with that tool probes.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "planner/fixtures.h"
#include "planner/tool_shape.h"
#include "sim/objects/hidden_object.h"
#include "sim/objects/obstacle.h"

namespace palpate {

// Fixtures are where they are given, not grown by a clearance. Const queries may run at the same time on several threads.
class ToolObstacle final : public Obstacle {
public:
    // `object` must outlive this. No tool: a point. Throws ObjectError on a tool with a body if grown triangles do not bound the object:
    // ellipsoids, tori and genus2 have no closed form with every tool. Throws std::invalid_argument on a tool without a ball, or with a
    // stylus thicker than that.
    ToolObstacle(const HiddenObject& object, const std::optional<ToolShape>& tool, const std::vector<Fixture>& fixtures);
    ~ToolObstacle() override;
    ToolObstacle(ToolObstacle&&) noexcept;
    ToolObstacle& operator=(ToolObstacle&&) noexcept;
    ToolObstacle(const ToolObstacle&) = delete;
    ToolObstacle& operator=(const ToolObstacle&) = delete;

    // From outside: the first contact, in closed form.
    [[nodiscard]] std::optional<Point> first_hit(const Segment& segment) const override;
    // Where the tool touches a triangle, a half-space or a box's face it does so from a first contact to the first contact of the way back,
    // for each of them and each part of the tool, since all are convex. All of these together, and what of the way between them lies
    // inside (contains), is O*; its ends are the crossings.
    [[nodiscard]] std::vector<Point> crossings(const Segment& segment) const override;
    // By more than kRounding of the scale: a tool that rests on S* is outside.
    [[nodiscard]] bool contains(const Point& p) const override;
    static constexpr double kRounding = 1e-11;
    // A lower bound: see ToolDepths. Exact where one part alone is in, with its axis outside.
    [[nodiscard]] double depth(const Point& p) const override;
    // Away from what the tool touches: how its gap to that grows. Without a tool, of what is nearest.
    [[nodiscard]] Vector normal(const Point& touched, const Vector& direction) const override;
    // That of the object, and the tool's length.
    [[nodiscard]] double scale() const override;

    // Of the object grown by the tool, without fixtures.
    [[nodiscard]] const Box& bounds() const;
    // The same for each part of the tool, without what is inside a fixture for the ball: below a table, behind a plane across an axis.
    // What remains is at least what a workspace contains.
    [[nodiscard]] std::vector<Box> reachable_bounds() const;

private:
    // Where the segment changes sides; `before`: the side that it comes from, if its source counts.
    [[nodiscard]] std::vector<Point> changes(const Segment& segment, std::optional<bool> before) const;

    struct Impl;
    std::unique_ptr<const Impl> impl_;
};

}  // namespace palpate
