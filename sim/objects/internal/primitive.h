// One exact solid in its own frame: centred at the origin, not rotated.
//
// Notation: S is the solid's surface; K its core, where S is the offset of K at distance r: a point (sphere), a circle
// (torus), a segment (capsule), a box (rounded box), a plate (genus2). Only the ellipsoid is no offset.
#pragma once

#include <limits>
#include <string>
#include <variant>

#include "sim/objects/object_spec.h"

namespace palpate {

using Primitive = std::variant<SphereSpec, EllipsoidSpec, TorusSpec, CapsuleSpec, RoundedBoxSpec, Genus2Spec>;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Measures of genus2 at scale 1 (sim/objects/shapes.h).
inline constexpr double kGenus2HalfLength = 0.6;   // mm: half the plate's middle segment, and where its holes are centred
inline constexpr double kGenus2PlateRadius = 0.6;  // mm: half the plate's width
inline constexpr double kGenus2HoleRadius = 0.4;   // mm: holes in the plate
inline constexpr double kGenus2Offset = 0.2;       // mm: S around the plate

// The point of S that is nearest to a query point p is p - distance * outward.
struct Nearest {
    double distance = 0.0;             // mm, exact to rounding; negative inside
    Vector outward = Vector::UnitX();  // unit normal of S there, away from the solid; any of them where several are nearest
};

[[nodiscard]] Nearest nearest(const SphereSpec& s, const Point& p);
[[nodiscard]] Nearest nearest(const EllipsoidSpec& s, const Point& p);
[[nodiscard]] Nearest nearest(const TorusSpec& s, const Point& p);
[[nodiscard]] Nearest nearest(const CapsuleSpec& s, const Point& p);
[[nodiscard]] Nearest nearest(const RoundedBoxSpec& s, const Point& p);
[[nodiscard]] Nearest nearest(const Genus2Spec& s, const Point& p);

struct Measures {
    bool convex = true;
    int euler_characteristic = 2;
    double bounding_radius = 0.0;  // mm: of a ball around the origin that contains the solid
    double reach_inside = 0.0;     // mm: least distance from S to the part of its medial axis inside the solid
    double reach_outside = 0.0;    // mm: the same outside; infinite for a convex solid
};
[[nodiscard]] Measures measures(const Primitive& primitive);

// Largest ⟨x, direction⟩ over all x in the solid, in mm for a unit direction.
[[nodiscard]] double support(const Primitive& primitive, const Vector& direction);

// The word that a configuration uses: "sphere", "ellipsoid", ...
[[nodiscard]] std::string name_of(const Primitive& primitive);

// Throws ObjectError if the parameters describe no solid; `where` opens the message.
void require_valid(const Primitive& primitive, const std::string& where);

}  // namespace palpate
