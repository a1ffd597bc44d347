// A solid whose surface is a closed triangle mesh, read from a file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/objects/object_spec.h"

namespace palpate {

// Const queries may run at the same time on several threads.
class MeshObject {
public:
    // Reads OFF, PLY, OBJ or STL (by extension), joins equal points, cuts polygons into triangles, mends what can be mended (sim/README.md)
    // with a warning for each kind of repair, and multiplies by the scale, rotates and moves. Throws ObjectError, naming the file, if it
    // cannot be read (with the line or byte), is not the surface of a solid (with all its problems and their counts), or would need a
    // repair that the spec forbids.
    explicit MeshObject(const MeshSpec& spec);
    ~MeshObject();
    MeshObject(MeshObject&&) noexcept;
    MeshObject& operator=(MeshObject&&) noexcept;

    // First point of S on the segment from its source, which may be inside or outside; exact to rounding. A source exactly on S is the
    // hit. A source that rounding has put on one side of S is on that side.
    [[nodiscard]] std::optional<Point> first_hit(const Segment& segment) const;
    // All points where the segment meets S, in order, each once. Where it touches an edge or a vertex without passing to the other
    // side counts too.
    [[nodiscard]] std::vector<Point> crossings(const Segment& segment) const;

    [[nodiscard]] bool contains(const Point& p) const;  // exact; points on S are not inside
    [[nodiscard]] Point closest_point(const Point& p) const;
    [[nodiscard]] double distance(const Point& p) const;  // mm to S, never negative

    [[nodiscard]] const TriangleMesh& mesh() const;
    [[nodiscard]] const Box& bounds() const;
    [[nodiscard]] double area() const;  // mm²
    [[nodiscard]] int euler_characteristic() const;
    [[nodiscard]] int components() const;
    [[nodiscard]] const std::vector<std::string>& warnings() const;

private:
    struct Impl;
    std::unique_ptr<const Impl> impl_;
};

}  // namespace palpate
