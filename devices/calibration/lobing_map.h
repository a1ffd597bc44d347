// How a probe's pre-travel depends on the direction that it touches in: its lobes.
#pragma once

#include <array>
#include <cstddef>

#include "planner/geometry.h"

namespace palpate {

// What touched centres of the ball are off by along the surface's outward normal, beside the effective radius: real spherical harmonics of
// degrees 2 and 3 in the machine's axes, normalised so that each has a root mean square of 1 over the whole sphere. Degree 0 belongs to the
// radius, degree 1 cannot be told from the sphere's centre.
struct LobingMap {
    static constexpr std::size_t kCoefficients = 12;

    // mm: degree 2, orders -2 to 2; then degree 3, orders -3 to 3. All 0: a probe without lobes.
    std::array<double, kCoefficients> coefficients_mm{};
    Vector axis = Vector::UnitZ();  // unit: from the ball to the holder, as ToolShape::axis

    // mm along the outward unit normal: how far outside of the ideal centre the touched one lies; negative: the probe triggers later than
    // it does on average. A normal that points away from the holder, below the equator, counts like the nearest one on the equator: nothing
    // was touched there that the map could know of.
    [[nodiscard]] double pretravel(const Vector& normal) const;
    // The ball's centre, if the probe had no lobes, for one that was touched: on a surface with that outward unit normal.
    [[nodiscard]] Point corrected(const Point& touched, const Vector& normal) const;

    friend bool operator==(const LobingMap&, const LobingMap&) = default;
};

// The harmonics of the map's coefficients, in their order, at a unit vector.
[[nodiscard]] std::array<double, LobingMap::kCoefficients> lobing_harmonics(const Vector& unit);

}  // namespace palpate
