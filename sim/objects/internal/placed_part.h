// A primitive with its place in the world.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/objects/internal/line_trace.h"
#include "sim/objects/internal/primitive.h"
#include "sim/objects/pose.h"

namespace palpate {

struct PlacedPart {
    Primitive primitive;
    Pose pose;
    std::string name;        // for messages, such as "part 2.1 (torus)"
    double tolerance = 0.0;  // mm: what is this close to S is on S

    [[nodiscard]] Nearest nearest_to(const Point& p) const;
    [[nodiscard]] Box bounds() const;
    [[nodiscard]] std::optional<double> first_hit(const Ray& ray) const;
    void append_crossings(const Ray& ray, std::vector<double>& out) const;

private:
    [[nodiscard]] Ray to_local(const Ray& ray) const;
};

// Smallest distance in mm between two solids that are apart; 0 or less if they overlap or touch.
//
// Alternating projection: x the nearest point of the one surface to y, y the nearest point of the other to x; every step shortens
// |x - y|, and it ends in a local minimum. Solids with holes have several, so it starts from many points spread over the one solid: a cubic
// lattice through its bounding box, projected to its surface (which reaches the insides of holes) and, of these, the best few are polished
// to convergence. Accurate to about 1e-9 of the parts' size while gap and least radius of curvature differ by less than 1e4; a smaller gap
// is overestimated by at most that 1e-9. A minimum narrower than the lattice (1/12 of the box) could be missed.
[[nodiscard]] double smallest_gap(const PlacedPart& a, const PlacedPart& b);

}  // namespace palpate
