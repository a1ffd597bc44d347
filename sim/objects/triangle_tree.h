// Distance and line queries on a soup of triangles; nothing is asked of how they are joined.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "planner/geometry.h"
#include "sim/objects/capsule_contact.h"
#include "sim/objects/cover.h"
#include "sim/objects/parallelogram.h"

namespace palpate {

// Const queries may run at the same time on several threads.
class TriangleTree {
public:
    // At least one triangle, indices in range, finite points (asserted).
    explicit TriangleTree(const TriangleMesh& mesh);
    ~TriangleTree();
    TriangleTree(TriangleTree&&) noexcept;
    TriangleTree& operator=(TriangleTree&&) noexcept;

    // First point on the segment, from its source, that is on a triangle. Which triangles are met is decided exactly, so no segment slips
    // through an edge or a vertex; where they are met is exact to rounding. A source on a triangle is itself the hit.
    [[nodiscard]] std::optional<Point> first_hit(const Segment& segment) const;

    // All points where the segment meets triangles, in order; those equal to rounding (an edge or a vertex met) are one. Of a triangle in
    // whose plane the segment lies, only an end of the segment inside it counts: where the segment enters and leaves it, neighbours do.
    [[nodiscard]] std::vector<Point> crossings(const Segment& segment) const;

    // Parameter in [0, 1] along the move at which the capsule first touches a triangle, as capsule_contact.h has it.
    [[nodiscard]] std::optional<double> first_contact(const Capsule& capsule, const Segment& move) const;

    // Adds where along the move, in [0, 1], the capsule touches a triangle: all such places, from first contacts both ways. What only
    // grazes may be missing.
    void add_contacts(const Capsule& capsule, const Segment& move, Cover& cover) const;

    [[nodiscard]] Point closest_point(const Point& p) const;
    // mm: to the nearest triangle; nothing if that is farther than `within`. Independent of first_contact.
    [[nodiscard]] std::optional<double> distance(const Parallelogram& swept, double within) const;

private:
    struct Impl;
    std::unique_ptr<const Impl> impl_;
};

}  // namespace palpate
