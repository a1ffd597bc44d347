// What people do who have no planner, to compare with: it sees no more than the planner does.
#pragma once

#include <cstdint>

#include "planner/cost.h"
#include "planner/geometry.h"
#include "planner/surface_oracle.h"
#include "planner/surroundings.h"

namespace palpate {

struct BaselineResult {
    TriangleMesh mesh;  // of rasters and rays oriented nowhere in particular; empty if too little was touched
    Cost cost;
};

// Downwards along z, line by line over a square grid of at most that many rays that meet ω, and up again. The mesh joins
// neighbours that both touched something. Throws what the oracle throws.
[[nodiscard]] BaselineResult probe_raster(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes);

// Along lines through ω, uniform over all lines that meet the ball around it: from where one enters ω, and back there. The mesh
// is CGAL's advancing front through all touches. Throws what the oracle throws.
[[nodiscard]] BaselineResult probe_random_rays(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes,
                                               std::uint64_t seed);

// Active exploration by a Gaussian process implicit surface, the peer of tactile robotics: the next touch is where the estimated surface is
// least certain, along its normal, from where that line enters ω, and back there. The mesh is of the process' zero. Nothing rules out that
// it has holes or parts that the object does not have. CGAL's mesher goes by addresses, so facets differ a little from run to run; probes
// do not. Takes time as the cube of the probes. Throws what the oracle throws.
[[nodiscard]] BaselineResult probe_gaussian_process(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes,
                                                    std::uint64_t seed);

}  // namespace palpate
