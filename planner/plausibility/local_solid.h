// The solid that a few tangent planes bound near the samples that they touch: creases and corners as the samples show them.
//
// Two planes are joined by how each lies to the other's sample. Where each sample is below the other's plane, the solid is below both (a
// convex crease); where each is above, it is below either (a concave one). Of three or more, those pairs make a graph; it is taken apart
// into what is joined in one way only (the multi-level partition of unity of Ohtake et al. 2003 joins the pieces of a corner so).
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "planner/geometry.h"

namespace palpate {

class LocalSolid {
public:
    static constexpr std::size_t kMost = 4;

    // REQUIRES: fewer than kMost so far; `normal` is a unit vector, out of the solid.
    void add(const Point& sample, const Vector& normal);

    // mm: of x above the solid's boundary as the plane that decides there has it; negative within. Nothing if the pairs contradict each
    // other, or it depends on a pair whose planes are too alike in height to tell how they are joined.
    [[nodiscard]] std::optional<double> height(const Point& x) const;
    // The parameter of the line at which it passes the boundary, the one nearest to 0 if there are several. Pairs that may be joined either
    // way are taken as they look.
    struct Crossing {
        double at = 0.0;
        double slope = 0.0;  // the cosine between `direction` and the plane's normal
    };
    [[nodiscard]] std::optional<Crossing> crossing(const Point& origin, const Vector& direction) const;

private:
    using Pairs = std::array<std::array<bool, kMost>, kMost>;

    using Heights = std::array<double, kMost>;

    // Of x above each plane.
    [[nodiscard]] Heights heights_at(const Point& x) const;
    [[nodiscard]] double height_by(const Pairs& convex, const Heights& heights, unsigned members, bool& clear) const;

    std::array<Point, kMost> samples_{};
    std::array<Vector, kMost> normals_{};
    std::size_t count_ = 0;
    Pairs convex_{};
    std::array<std::pair<std::size_t, std::size_t>, kMost*(kMost - 1) / 2> unsure_{};  // pairs that may be joined either way
    std::size_t unsure_count_ = 0;
};

}  // namespace palpate
