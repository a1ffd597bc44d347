// How far a result mesh is from the hidden object that it was found on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "planner/geometry.h"
#include "sim/objects/hidden_object.h"

namespace palpate {

struct TruthSampling {
    std::size_t surface_points = 100'000;  // about how many points of S to look at
    std::size_t mesh_points = 100'000;     // about how many points of the result, besides its vertices
};

struct Truth {
    double hausdorff = 0.0;        // mm, two-sided: the largest distance found; infinite if the result is empty
    double mean_distance = 0.0;    // mm: mean of the two one-sided means by area; infinite if the result is empty
    double area = 0.0;             // mm² of S: exact for a mesh, for a shape estimated (about 1 / √surface_points relative)
    int euler_characteristic = 0;  // of S
    int components = 0;            // of S
    std::optional<double> reach;   // mm, of S; nothing for a mesh
};

// Samples both sides.
//
// Result → S: all vertices of the result, and in every triangle the centroids of n² equal parts, with n so that all triangles together have
// about `mesh_points` of them, by area, and each at least one. Distances to S are exact.
//
// S → result: by Cauchy and Crofton, the points where uniformly distributed random lines through a ball cross S are uniformly distributed
// on S by area, and their mean number per line is 2 area(S) / area(ball's sphere), which is also the estimate of S's area. So no
// parametrisation of S is needed. Lines are drawn until `surface_points` points are found. Distances to the result are exact.
//
// Every sampled distance is a true one, so `hausdorff` is a lower bound; it misses a defect that is smaller than the sample spacing,
// √(area / points). The same seed gives the same result. Throws ObjectError if a triangle of the result names a point that it does not
// have, or a point is not finite.
[[nodiscard]] Truth measure_truth(const HiddenObject& object, const TriangleMesh& result, const TruthSampling& sampling,
                                  std::uint64_t seed);

// mm: how far places of S are from a mesh, uniformly by area.
struct SurfaceDistances {
    double p95 = 0.0;  // of 95 in 100 at most that
    double p99 = 0.0;
    double max = 0.0;
};

// Of about `points` places, as measure_truth draws them. Infinite if the mesh is empty. Throws as that does.
[[nodiscard]] SurfaceDistances measure_surface(const HiddenObject& object, const TriangleMesh& mesh, std::size_t points,
                                               std::uint64_t seed);

}  // namespace palpate
