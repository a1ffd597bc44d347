// Solids that are known beforehand, as the tool's reference point meets them: fixtures, grown by the tool
// (planner/DESIGN.md, "Known solids").
//
// The planner wants a closed S. So a table is a plate that ends inside ω, in faces that no tool will ever see; the space around it below
// its top is taken to be free and never entered. What a tool must not enter is kept apart: whole half-spaces.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

class KnownSolids {
public:
    // Of ε: a crossing on a face is told as so wide a gap around it, above and below.
    static constexpr double kGap = 1e-6;

    struct Plane {
        Vector normal = Vector::UnitZ();  // unit, out of the solid
        double offset = 0.0;              // mm

        [[nodiscard]] double height(const Point& p) const { return normal.dot(p) - offset; }  // mm
    };
    // What lies below all of these.
    using Convex = std::vector<Plane>;

    KnownSolids() = default;
    // Where nothing is to be probed: no tool goes there between faces of ω that lead to it.
    struct Outside {
        std::vector<Convex> parts;
        Convex faces;  // below all of these
    };
    // `floors`: nothing moves below these; every solid's faces that a tool can see are above them or on them. `slack` (mm): what is nearer
    // to a face than that lies on it. For each part of what is outside one of the solids ends there.
    KnownSolids(std::vector<Convex> solids, const std::vector<Plane>& floors, double slack, Outside outside = {});

    [[nodiscard]] bool empty() const { return solids_.empty(); }
    // Are there others than one for each part of what is outside?
    [[nodiscard]] bool has_fixtures() const { return has_fixtures_; }
    // In a solid, and not on its boundary.
    [[nodiscard]] bool contains(const Point& p) const;
    // Below a floor, or where nothing is to be probed: no place for a tool, whether it is in a solid or not.
    [[nodiscard]] bool is_buried(const Point& p) const;
    // The same, but not beyond the faces of ω that lead out: what first_hit() calls entered.
    [[nodiscard]] bool is_barred(const Point& p) const;

    struct Hit {
        Point at = Point::Zero();
        // On a solid; else the way goes to a barred place beside all solids there.
        bool is_solid = true;
    };
    // Where a straight move first enters what no tool may: at its start if it begins on a boundary and leads into it. Nothing where it only
    // touches it.
    [[nodiscard]] std::optional<Hit> first_hit(const Segment& move) const;
    // Where a line through space that no tool need go first enters a solid.
    [[nodiscard]] std::optional<Point> first_entry(const Segment& line) const;
    // Outward unit normal of a solid's face that the point lies on: of the first, where several meet.
    [[nodiscard]] std::optional<Vector> normal_at(const Point& p) const;

private:
    std::vector<Convex> solids_;
    std::vector<Convex> buried_;
    std::vector<Convex> barred_;
    bool has_fixtures_ = false;
    double slack_ = 0.0;
};

}  // namespace palpate
