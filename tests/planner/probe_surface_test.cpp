#include "planner/probe_surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::probe_surface_test {
namespace {

TEST(LowerBound, IsTheHexagonalLattice) {
    // A hexagonal lattice whose triangles have circumradius 1 has edges of √3, so 3√3/2 of area per point.
    EXPECT_NEAR(lower_bound_samples(3 * std::sqrt(3.0) / 2, 1.0), 1.0, 1e-15);
    EXPECT_NEAR(lower_bound_samples(10.0, 0.1) / lower_bound_samples(10.0, 0.2), 4.0, 1e-12);
}

}  // namespace
}  // namespace palpate::probe_surface_test
