// The tangent plane and curvature of a surface at the points of its mesh, one side of a concave crease at a time.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "planner/geometry.h"
#include "planner/part/internal/facet_fans.h"

namespace palpate {

struct SurfaceFit {
    Vector normal = Vector::UnitZ();  // unit
    double angle = 0.0;               // rad: how far off it may be
    bool is_creased = false;          // a concave crease cuts the fan
    // The surface near it, over the tangent plane with the axes u, w: z(x, y) = q0 + q1 x + q2 y + q3 x²/2 + q4 xy + q5 y²/2, in mm.
    Vector u = Vector::UnitX();
    Vector w = Vector::UnitY();
    Eigen::Matrix<double, 6, 1> quadric = Eigen::Matrix<double, 6, 1>::Zero();
    // mm: points around are so near to the plane, which all of them may be on; infinite if they are not.
    double flatness = std::numeric_limits<double>::infinity();
    // rad: how far neighbours' fits, going on to here, have another normal, and this one there.
    double disagreement = 0.0;
};

// S* is smooth but for creases that are concave, as a ball sweeps it: convex bends are at most 1/r. A crease cannot be told from a bend
// whose radius is some three times the facets' size, and is taken for one where facets turn by more than that.
inline constexpr double kCreaseAngle = 0.35;  // rad

// S* is what several solids, each smooth, leave together: what the ball swept, what the shank swept, grown fixtures. A crease lies between.
enum class Sweep : std::uint8_t { ball, shank, fixture };

// For each point of the mesh, from those of the same sweep. `noise`: mm, of the points.
[[nodiscard]] std::vector<SurfaceFit> fit_surface(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<Sweep>& sweeps,
                                                  double noise);

// Does the surface turn concavely by more than that from a to b?
[[nodiscard]] bool is_creased(const Point& a, const Vector& normal_a, const Point& b, const Vector& normal_b, double angle = kCreaseAngle);

}  // namespace palpate
