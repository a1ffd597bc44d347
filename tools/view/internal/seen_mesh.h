// The mesh through the camera: its triangles on the screen, and its surface under a place there.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "planner/geometry.h"
#include "tools/view/internal/camera.h"
#include "tools/view/internal/screen.h"

namespace palpate {

struct SurfacePoint {
    Point position = Point::Zero();
    Vector normal = Vector::Zero();  // unit, on the viewer's side
};

class SeenMesh {
public:
    // Both have to outlive it.
    SeenMesh(const TriangleMesh& mesh, const Camera& camera);

    [[nodiscard]] std::array<Screen, 3> corners(std::size_t t) const;
    // Where triangle `t` is under a place on the screen, or at its border if it is not there.
    [[nodiscard]] SurfacePoint surface(std::size_t t, double x, double y) const;
    // From a place in or near triangle `t` to the nearest line through an edge of it, in samples.
    [[nodiscard]] double edge_distance(std::size_t t, double x, double y) const;
    [[nodiscard]] double nearness(std::size_t t) const;  // of its middle

private:
    const TriangleMesh& mesh_;
    const Camera& camera_;
    std::vector<std::array<Vector, 3>> normals_;  // per triangle and corner
    std::vector<Screen> places_;                  // of the mesh's points
    std::vector<Eigen::Matrix3d> edge_lines_;     // per triangle
};

// mm; the mesh has triangles.
[[nodiscard]] double median_edge(const TriangleMesh& mesh);

}  // namespace palpate
