// `object:` of a configuration: a mesh, or a shape.
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "config/internal/kinds.h"
#include "sim/objects/object_spec.h"

namespace palpate::yaml {

template <class Archive>
void describe(Archive& keys, SphereSpec& sphere) {
    keys.value({"radius", "radius", Need::required, kMillimetres}, sphere.radius, Number{kLength});
}

template <class Archive>
void describe(Archive& keys, EllipsoidSpec& ellipsoid) {
    keys.value({"semi_axes", "half the extent along x, y and z", Need::required, kMillimetres}, ellipsoid.semi_axes,
               Triple{Number{kLength}});
}

template <class Archive>
void describe(Archive& keys, TorusSpec& torus) {
    keys.value({"major", "radius of the circle around z that the tube's centre runs on", Need::required, kMillimetres}, torus.major,
               Number{kLength});
    keys.value({"minor", "radius of the tube; less than `major`", Need::required, kMillimetres}, torus.minor, Number{kLength});
    keys.require(torus.minor < torus.major, "minor", "is not less than major; allowed: greater than 0, less than major (mm)");
}

template <class Archive>
void describe(Archive& keys, CapsuleSpec& capsule) {
    keys.value({"radius", "radius of the caps and of the cylinder between them", Need::required, kMillimetres}, capsule.radius,
               Number{kLength});
    keys.value({"length", "between the centres of the caps, along z", Need::required, kMillimetres}, capsule.length, Number{kLengthOrZero});
}

template <class Archive>
void describe(Archive& keys, RoundedBoxSpec& box) {
    keys.value({"size", "whole extent along x, y and z", Need::required, kMillimetres}, box.size, Triple{Number{kLength}});
    keys.value({"fillet", "radius of the edges, 0 for sharp ones; at most half the smallest side", Need::required, kMillimetres},
               box.fillet, Number{kLengthOrZero});
    keys.require(2.0 * box.fillet <= box.size.minCoeff(), "fillet",
                 "is more than half the smallest side; allowed: from 0 to half the smallest side (mm)");
}

template <class Archive>
void describe(Archive& keys, Genus2Spec& plate) {
    keys.value({"scale", "factor to the size at 1, which is 2.8 × 1.6 × 0.4 mm", Need::required}, plate.scale, Number{kLength});
}

// A union.
template <class Archive>
void describe(Archive& keys, std::vector<ShapeSpec>& parts) {
    list(keys, {"parts", "shapes that do not touch each other; each has the keys of `object.shape`", Need::required, "", "", Layout::block},
         {.least = 1, .is_recursive = true}, parts);
}

// Where a shape or a mesh is put.
template <class Archive, class Spec>
void describe_place(Archive& keys, std::string_view meaning_of_at, std::string_view meaning_of_rotate, Spec& spec) {
    keys.value({"at", meaning_of_at, Need::optional, kMillimetres}, spec.at, Triple{Number{kCoordinate}});
    keys.value({"rotate", meaning_of_rotate, Need::optional, kDegrees}, spec.rotate, Triple{Angle{}});
}

template <class Archive>
void describe(Archive& keys, ShapeSpec& shape) {
    alternative<SphereSpec>(keys, {"sphere", "a sphere"}, shape.kind);
    alternative<EllipsoidSpec>(keys, {"ellipsoid", "an ellipsoid"}, shape.kind);
    alternative<TorusSpec>(keys, {"torus", "a torus around z"}, shape.kind);
    alternative<CapsuleSpec>(keys, {"capsule", "a cylinder along z with half spheres at its ends"}, shape.kind);
    alternative<RoundedBoxSpec>(keys, {"rounded_box", "a box with rounded edges"}, shape.kind);
    alternative<Genus2Spec>(keys, {"genus2", "a smooth plate with two holes"}, shape.kind);
    alternative<std::vector<ShapeSpec>>(keys, {.name = "union", .meaning = "several shapes as one object", .layout = Layout::block},
                                        shape.kind);
    describe_place(keys, "where the centre of the shape is put", "turns about x, then y, then z of the fixed frame, before `at` is added",
                   shape);
    keys.require_one_alternative();
}

template <class Archive>
void describe(Archive& keys, MeshSpec& mesh) {
    keys.value({"mesh", "OFF, PLY, OBJ or STL file, relative to the config file", Need::alternative}, mesh.file, File{});
    keys.value({"scale", "factor to the mesh's coordinates; only with `mesh`"}, mesh.scale, Number{kPositive});
    describe_place(keys, "where the origin of the mesh is put; only with `mesh`",
                   "turns the scaled mesh about x, then y, then z of the fixed frame, before `at` is added; only with `mesh`", mesh);
    keys.value({"repair", "whether defects of the mesh are mended, with a warning, or refused (see sim/README.md); only with `mesh`"},
               mesh.repair, kFlag);
}

// An object that is to be read is a mesh until it turns out to be a shape.
template <class Archive>
void describe(Archive& keys, ObjectSpec& object) {
    if (auto* const mesh = std::get_if<MeshSpec>(&object)) describe(keys, *mesh);
    alternative<ShapeSpec>(keys, {.name = "shape", .meaning = "a solid in closed form", .layout = Layout::block}, object);
    keys.require_one_alternative();
    if (std::holds_alternative<ShapeSpec>(object)) {
        keys.require(!keys.has("scale"), "scale", "goes with mesh only; allowed: the measures of the shape");
        keys.require(!keys.has("at"), "at", "goes with mesh only; allowed: at of the shape");
        keys.require(!keys.has("rotate"), "rotate", "goes with mesh only; allowed: rotate of the shape");
        keys.require(!keys.has("repair"), "repair", "goes with mesh only; allowed: nothing, a shape needs none");
    }
}

}  // namespace palpate::yaml
