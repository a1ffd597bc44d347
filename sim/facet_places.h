// Places of a mesh's facets, evenly by area: what its distances to something are measured at.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "planner/geometry.h"

namespace palpate {

struct FacetPlaces {
    const std::array<std::uint32_t, 3>& corners;
    double area;                    // mm²
    std::span<const Point> places;  // the centroids of n² equal parts; valid during the visit
};

// Every triangle in turn, with n so that all of them together have about `count` places, by area, and each at least one.
void for_each_facet(const TriangleMesh& mesh, std::size_t count, const std::function<void(const FacetPlaces&)>& visit);

}  // namespace palpate
