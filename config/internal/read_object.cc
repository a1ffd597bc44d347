#include "config/internal/read_object.h"

#include <optional>
#include <system_error>
#include <utility>

namespace palpate::yaml {

namespace {

constexpr std::string_view kMillimetres = "mm";
constexpr Need kRequired = Need::required;
constexpr Need kAlternative = Need::alternative;

SphereSpec read_sphere(Section& section) { return {section.number({"radius", "radius", kRequired, kMillimetres}, kPositive)}; }

EllipsoidSpec read_ellipsoid(Section& section) {
    return {section.vector({"semi_axes", "half the extent along x, y and z", kRequired, kMillimetres}, kPositive)};
}

TorusSpec read_torus(Section& section) {
    TorusSpec torus;
    torus.major =
        section.number({"major", "radius of the circle around z that the tube's centre runs on", kRequired, kMillimetres}, kPositive);
    torus.minor = section.number({"minor", "radius of the tube; less than `major`", kRequired, kMillimetres}, kPositive);
    section.require(torus.minor < torus.major, "minor", "is not less than major; allowed: greater than 0, less than major (mm)");
    return torus;
}

CapsuleSpec read_capsule(Section& section) {
    CapsuleSpec capsule;
    capsule.radius = section.number({"radius", "radius of the caps and of the cylinder between them", kRequired, kMillimetres}, kPositive);
    capsule.length = section.number({"length", "between the centres of the caps, along z", kRequired, kMillimetres}, kNotNegative);
    return capsule;
}

RoundedBoxSpec read_rounded_box(Section& section) {
    RoundedBoxSpec box;
    box.size = section.vector({"size", "whole extent along x, y and z", kRequired, kMillimetres}, kPositive);
    box.fillet = section.number(
        {"fillet", "radius of the edges, 0 for sharp ones; at most half the smallest side", kRequired, kMillimetres}, kNotNegative);
    section.require(2.0 * box.fillet <= box.size.minCoeff(), "fillet",
                    "is more than half the smallest side; allowed: from 0 to half the smallest side (mm)");
    return box;
}

Genus2Spec read_genus2(Section& section) {
    return {section.number({"scale", "factor to the size at 1, which is 2.8 × 1.6 × 0.4 mm", kRequired}, kPositive)};
}

// Reads one alternative into `kind`.
template <class Read, class Kind>
void read_kind(Section& section, std::string_view name, std::string_view meaning, const Read& read, Kind& kind) {
    section.mapping({name, meaning, kAlternative}, [&](Section& inner) { kind = read(inner); });
}

// Where a shape or a mesh is put.
template <class Spec>
void read_place(Section& section, std::string_view meaning_of_at, std::string_view meaning_of_rotate, Spec& spec) {
    spec.at = section.vector({"at", meaning_of_at, Need::optional, kMillimetres}, kAnyNumber, Vector(Vector::Zero()));
    spec.rotate = section.angles({"rotate", meaning_of_rotate});
}

ShapeSpec read_shape(Section& section);

std::vector<ShapeSpec> read_union(Section& section) {
    std::vector<ShapeSpec> parts;
    // A part is a shape, whose keys are described where shapes are.
    section.list({"parts", "shapes that do not touch each other; each has the keys of `object.shape`", kRequired}, 1, true,
                 [&](Section& part) { parts.push_back(read_shape(part)); });
    return parts;
}

ShapeSpec read_shape(Section& section) {
    ShapeSpec shape;
    read_kind(section, "sphere", "a sphere", read_sphere, shape.kind);
    read_kind(section, "ellipsoid", "an ellipsoid", read_ellipsoid, shape.kind);
    read_kind(section, "torus", "a torus around z", read_torus, shape.kind);
    read_kind(section, "capsule", "a cylinder along z with half spheres at its ends", read_capsule, shape.kind);
    read_kind(section, "rounded_box", "a box with rounded edges", read_rounded_box, shape.kind);
    read_kind(section, "genus2", "a smooth plate with two holes", read_genus2, shape.kind);
    read_kind(section, "union", "several shapes as one object", read_union, shape.kind);
    read_place(section, "where the centre of the shape is put", "turns about x, then y, then z of the fixed frame, before `at` is added",
               shape);
    section.require_one_alternative();
    return shape;
}

// Follows links in the folder, where ".." means something else behind them, but keeps the file's own name.
std::filesystem::path resolve(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::weakly_canonical(file.parent_path(), error);
    return error ? file.lexically_normal() : folder / file.filename();
}

}  // namespace

ObjectSpec read_object(Section& section, const std::filesystem::path& folder) {
    MeshSpec mesh;
    const std::filesystem::path file = section.text({"mesh", "OFF, PLY, OBJ or STL file, relative to the config file", kAlternative});
    mesh.scale = section.number({"scale", "factor to the mesh's coordinates; only with `mesh`"}, kPositive, mesh.scale);
    read_place(section, "where the origin of the mesh is put; only with `mesh`",
               "turns the scaled mesh about x, then y, then z of the fixed frame, before `at` is added; only with `mesh`", mesh);
    mesh.repair =
        section.flag({"repair", "whether defects of the mesh are mended, with a warning, or refused (see sim/README.md); only with `mesh`"},
                     mesh.repair);
    std::optional<ShapeSpec> shape;
    section.mapping({"shape", "a solid in closed form", kAlternative}, [&](Section& inner) { shape = read_shape(inner); });
    section.require_one_alternative();
    if (shape) {
        section.require(!section.has("scale"), "scale", "goes with mesh only; allowed: the measures of the shape");
        section.require(!section.has("at"), "at", "goes with mesh only; allowed: at of the shape");
        section.require(!section.has("rotate"), "rotate", "goes with mesh only; allowed: rotate of the shape");
        section.require(!section.has("repair"), "repair", "goes with mesh only; allowed: nothing, a shape needs none");
        return *std::move(shape);
    }
    mesh.file = resolve(folder / file);
    return mesh;
}

}  // namespace palpate::yaml
