// What is known before anything is asked: everything outside ω is free, but where a face of ω is closed (planner/DESIGN.md, "Terms");
// inside, solids may be known (planner/DESIGN.md, "Known solids").
//
// Nobody else says so. Whoever wants to know whether a place is free without a probe, where a line leaves such space, or how to get from
// one place of its boundary to another asks here.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "planner/area.h"
#include "planner/geometry.h"
#include "planner/known_solids.h"
#include "planner/region.h"

namespace palpate {

class Surroundings {
public:
    // Nothing but the object is anywhere, and that lies in ω.
    Surroundings(const Region& region) : region_(region) {}  // NOLINT(google-explicit-constructor): ω is all that most callers know

    // A box of which only some faces can be passed, with known solids inside; by axis, the one at its min and the one at its max.
    // `reachable`: what of the box, and of ways around it, a tool may have to do with. Throws std::invalid_argument if ways over open faces
    // do not join them all. `assumes_clear`: nothing but the object stands on the known solids. `area`: what alone is to be probed, if that
    // is not all of ω; known solids stand around it.
    struct OpenFaces {
        std::array<std::array<bool, 2>, 3> is_open{{{true, true}, {true, true}, {true, true}}};
    };
    Surroundings(const Box& box, KnownSolids known, const OpenFaces& faces, const Box& reachable, bool assumes_clear,
                 std::optional<Area> area = {});

    [[nodiscard]] const Region& region() const { return region_; }  // ω
    [[nodiscard]] const KnownSolids& known() const { return known_; }
    [[nodiscard]] bool assumes_clear() const { return assumes_clear_; }
    [[nodiscard]] const std::optional<Area>& area() const { return area_; }
    [[nodiscard]] const OpenFaces& faces() const { return faces_; }

    [[nodiscard]] bool is_free(const Point& p) const { return !region_.contains(p); }
    // mm: what is nearer to ω's boundary is outside, whatever rounding says.
    [[nodiscard]] double boundary_slack() const { return 1e-6 * region_.radius(); }
    // Whether a tool can come to that point of ω's boundary from outside.
    [[nodiscard]] bool is_enterable(const Point& p) const;
    // On a straight way: what KnownSolids::first_hit says.
    [[nodiscard]] std::optional<KnownSolids::Hit> first_known(const Segment& move) const {
        return known_.empty() ? std::nullopt : known_.first_hit(move);
    }
    // Unit, outwards, of the known solid's face that the point lies on, if it lies on one.
    [[nodiscard]] std::optional<Vector> known_normal(const Point& p) const { return known_.empty() ? std::nullopt : known_.normal_at(p); }
    // The part of the line that is not known to be free, or nothing where all of it is. `direction` has unit length.
    [[nodiscard]] std::optional<Interval> unknown_part(const Point& origin, const Vector& direction) const {
        return region_.clip(origin, direction);
    }
    // Where a straight way from free space to `p`, or from there to free space, should pass ω's boundary. From inside an area one that
    // stays in it, if there is one. Throws std::invalid_argument if p is outside and faces closed faces only.
    [[nodiscard]] Point nearest_entry(const Point& p) const;

    // The points to pass, after `from` and up to and with `to`, on a short way through free space between two points of its boundary.
    // Around a ball: the polygon of tangents around the great-circle arc, so that no chord cuts ω. Around a box: straight on a face, or
    // over the edges of the faces between, open ones. Throws std::invalid_argument if one is not on an open face of the box.
    [[nodiscard]] std::vector<Point> path(const Point& from, const Point& to) const;
    // mm: its length, without building it.
    [[nodiscard]] double distance(const Point& from, const Point& to) const;
    // The least box along the axes that holds every path, and all of ω that a tool can be in.
    [[nodiscard]] Box bounds() const;

private:
    Region region_;
    KnownSolids known_;
    OpenFaces faces_;
    std::optional<Box> reachable_;
    bool assumes_clear_ = false;
    std::optional<Area> area_;
};

}  // namespace palpate
