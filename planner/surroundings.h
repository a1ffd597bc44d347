// What is known to be free before anything is asked: everything outside ω (planner/DESIGN.md, "Terms").
//
// Nobody else says so. Whoever wants to know whether a place is free without a probe, where a line leaves such space, or how to get from
// one place of its boundary to another asks here.
#pragma once

#include <optional>
#include <vector>

#include "planner/geometry.h"
#include "planner/region.h"

namespace palpate {

class Surroundings {
public:
    // Nothing but the object is anywhere, and that lies in ω.
    Surroundings(const Region& region) : region_(region) {}  // NOLINT(google-explicit-constructor): ω is all that most callers know

    [[nodiscard]] const Region& region() const { return region_; }  // ω

    [[nodiscard]] bool is_free(const Point& p) const { return !region_.contains(p); }
    // The part of the line that is not known to be free, or nothing where all of it is. `direction` has unit length.
    [[nodiscard]] std::optional<Interval> unknown_part(const Point& origin, const Vector& direction) const {
        return region_.clip(origin, direction);
    }
    // Where a straight way from free space to `p` should leave it.
    [[nodiscard]] Point nearest_entry(const Point& p) const { return region_.nearest_boundary(p); }

    // The points to pass, after `from` and up to and with `to`, on a short way through free space between two points of its boundary.
    // Around a ball: the polygon of tangents around the great-circle arc, so that no chord cuts ω. Around a box: straight on a face, or
    // over the edges of the faces between. Throws std::invalid_argument if one is not on the boundary of the box.
    [[nodiscard]] std::vector<Point> path(const Point& from, const Point& to) const;
    // mm: its length, without building it.
    [[nodiscard]] double distance(const Point& from, const Point& to) const;
    // The least box along the axes that holds ω and every path.
    [[nodiscard]] Box bounds() const;

private:
    Region region_;
};

}  // namespace palpate
