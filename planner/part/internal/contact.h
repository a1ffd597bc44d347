// Where the ball touched the part, from what the rest of S* leaves free.
#pragma once

#include <vector>

#include "planner/geometry.h"
#include "planner/part/internal/facet_fans.h"
#include "planner/part/internal/facet_tree.h"
#include "planner/part/internal/surface_fit.h"

namespace palpate {

// mm: how far the surface bulges above the chord from a to b, whose normals are given, at `share` of it if it is a parabola; negative
// where it is concave. A quarter is the middle.
[[nodiscard]] inline double bulge(const Point& a, const Vector& normal_a, const Point& b, const Vector& normal_b) {
    return (normal_b - normal_a).dot(b - a) / 2;
}
// mm: how far the surface between may lie beside the chord: where the tangent planes meet. No bound if they do not.
[[nodiscard]] double chord_error(const Point& a, const Vector& normal_a, const Point& b, const Vector& normal_b);

struct Contact {
    Point point = Point::Zero();
    Vector normal = Vector::UnitZ();  // unit, from there to the centre
    double angle = 0.0;               // rad: how far off the normal may be
    double disagreement = 0.0;        // rad, as that of the fit
    double uncertainty = 0.0;         // mm: how far the part may be
    bool is_creased = false;          // S* has a concave crease here
};

// S* as far as the ball's centre may come: no place of O is nearer to a touched point than the radius.
//
// Notation. c: a touched point, n: the normal there, so that x = c − r n was touched. c_j: others, D e = c_j − c with a unit e. |x − c_j| ≥
// r is n·e ≥ −D/2r: a cone of normals like that of a bound on the reach (planner/inference/normal_cone.h), of its inner half, which holds
// for any part. Errors ν of both points leave 2ν/D besides.
class TracedField {
public:
    // REQUIRES: all outlive this.
    TracedField(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<SurfaceFit>& fits, double radius, double noise);

    // Of the ball around point `v` of S*, whose normal is the fit's as far as the others allow.
    [[nodiscard]] Contact contact(std::uint32_t v) const;

    struct Distance {
        double distance = 0.0;          // mm
        Point nearest = Point::Zero();  // on the curved facet
        double trust = 0.0;             // mm: how far off that may be
    };
    // From S* with its facets curved as the normals at their corners say.
    [[nodiscard]] Distance distance(const Point& p) const;

private:
    struct Limit {
        Vector direction;    // e
        double least = 0.0;  // n·e
    };
    [[nodiscard]] std::vector<Limit> limits(std::uint32_t v) const;

    const TriangleMesh& mesh_;
    const FacetFans& fans_;
    const std::vector<SurfaceFit>& fits_;
    double radius_;
    double noise_;
    FacetTree tree_;
};

// The contact at each point of S*.
[[nodiscard]] std::vector<Contact> touch_points(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<SurfaceFit>& fits,
                                                double radius, double noise);

}  // namespace palpate
