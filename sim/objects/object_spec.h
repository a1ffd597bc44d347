// Which object is hidden: what `object:` of a configuration says, as values.
#pragma once

#include <filesystem>
#include <variant>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct SphereSpec {
    double radius = 1.0;  // mm
};
struct EllipsoidSpec {
    Vector semi_axes = Vector::Ones();  // mm
};
// Around the z axis.
struct TorusSpec {
    double major = 1.0;  // mm: circle that the tube's centre runs on
    double minor = 0.4;  // mm: radius of the tube, < major
};
// Along the z axis: all points within `radius` of a segment of `length`.
struct CapsuleSpec {
    double radius = 0.5;  // mm
    double length = 1.0;  // mm: between the centres of the caps
};
// All points within `fillet` of a smaller box, `size` in all.
struct RoundedBoxSpec {
    Vector size = Vector::Ones();  // mm
    double fillet = 0.1;           // mm, 0 (sharp) to half the smallest side
};
// A plate with two round holes and a fully rounded rim; see sim/objects/shapes.h for its measures at scale 1.
struct Genus2Spec {
    double scale = 1.0;
};

struct ShapeSpec {
    std::variant<SphereSpec, EllipsoidSpec, TorusSpec, CapsuleSpec, RoundedBoxSpec, Genus2Spec, std::vector<ShapeSpec>> kind;
    Point at = Point::Zero();        // mm
    Vector rotate = Vector::Zero();  // radians: about x, then y, then z of the fixed frame, before `at` is added
};

struct MeshSpec {
    std::filesystem::path file;      // OFF, PLY, OBJ or STL
    double scale = 1.0;              // mm per unit of the file
    Point at = Point::Zero();        // mm: where the file's origin is put
    Vector rotate = Vector::Zero();  // radians, as of a shape: about the file's origin
    bool repair = true;              // mend what can be mended (sim/README.md), or refuse it
};

using ObjectSpec = std::variant<MeshSpec, ShapeSpec>;

}  // namespace palpate
