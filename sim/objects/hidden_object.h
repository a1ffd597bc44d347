// The unknown solid O of a simulation and its surface S, exact shape or mesh.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/objects/grown_triangles.h"
#include "sim/objects/mesh/mesh_object.h"
#include "sim/objects/object_spec.h"
#include "sim/objects/obstacle.h"
#include "sim/objects/shapes.h"

namespace palpate {

// As an obstacle: to a tool that is a point. Movable, not copyable. Const queries may run at the same time on several threads.
class HiddenObject final : public Obstacle {
public:
    // Throws ObjectError (sim/objects/errors.h) if the spec describes no solid; see Shape and MeshObject.
    explicit HiddenObject(const ObjectSpec& spec);

    [[nodiscard]] std::optional<Point> first_hit(const Segment& segment) const override;
    [[nodiscard]] std::vector<Point> crossings(const Segment& segment) const override;
    [[nodiscard]] bool contains(const Point& p) const override;
    [[nodiscard]] double depth(const Point& p) const override { return contains(p) ? distance(p) : 0.0; }  // exact
    // That of the nearest point of S, from kStandoff of the scale before the place.
    [[nodiscard]] Vector normal(const Point& touched, const Vector& direction) const override;
    static constexpr double kStandoff = 1e-6;
    [[nodiscard]] double distance(const Point& p) const;      // mm to S, never negative
    [[nodiscard]] Point closest_point(const Point& p) const;  // of S

    [[nodiscard]] const Box& bounds() const;
    // Diagonal of the bounds or distance of their farthest corner from the origin, whichever is larger.
    [[nodiscard]] double scale() const override;
    // What bounds it exactly, without what they enclose; those that are not grown are counter-clockwise seen from outside. Empty where
    // there is no such description: of an ellipsoid, a torus, genus2.
    [[nodiscard]] std::vector<GrownTriangles> grown_triangles() const;
    [[nodiscard]] int euler_characteristic() const;
    [[nodiscard]] int components() const;
    [[nodiscard]] std::optional<double> reach() const;  // mm; nothing for a mesh
    [[nodiscard]] std::optional<double> area() const;   // mm²; nothing for a shape (sim/truth.h estimates it)
    [[nodiscard]] std::vector<std::string> warnings() const;

private:
    std::variant<Shape, MeshObject> object_;
    std::vector<GrownTriangles> grown_;  // of a shape
};

}  // namespace palpate
