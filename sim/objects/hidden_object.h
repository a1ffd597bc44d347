// The unknown solid O of a simulation and its surface S, exact shape or mesh.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/objects/mesh/mesh_object.h"
#include "sim/objects/object_spec.h"
#include "sim/objects/shapes.h"

namespace palpate {

// Movable, not copyable. Const queries may run at the same time on several threads.
class HiddenObject {
public:
    // Throws ObjectError (sim/objects/errors.h) if the spec describes no solid; see Shape and MeshObject.
    explicit HiddenObject(const ObjectSpec& spec);

    // First point of S on the segment from its source, inside or outside. A source on S, up to rounding, may be the hit itself or be
    // taken to lie on either side: a caller that starts on S decides for itself what to overlook (SimulatedDevice does).
    [[nodiscard]] std::optional<Point> first_hit(const Segment& segment) const;
    // All points where the segment passes through S, in order from its source. Points where it only touches S may be among them, and
    // near its ends those within rounding may be missing.
    [[nodiscard]] std::vector<Point> crossings(const Segment& segment) const;

    [[nodiscard]] bool contains(const Point& p) const;        // strictly inside
    [[nodiscard]] double distance(const Point& p) const;      // mm to S, never negative
    [[nodiscard]] Point closest_point(const Point& p) const;  // of S

    [[nodiscard]] const Box& bounds() const;
    // mm: diagonal of the bounds or distance of their farthest corner from the origin, whichever is larger. Positions are exact
    // to about 1e-15 of it; tolerances are shares of it.
    [[nodiscard]] double scale() const;
    [[nodiscard]] int euler_characteristic() const;
    [[nodiscard]] int components() const;
    [[nodiscard]] std::optional<double> reach() const;  // mm; nothing for a mesh
    [[nodiscard]] std::optional<double> area() const;   // mm²; nothing for a shape (sim/truth.h estimates it)
    [[nodiscard]] std::vector<std::string> warnings() const;

private:
    std::variant<Shape, MeshObject> object_;
};

}  // namespace palpate
