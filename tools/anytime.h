// `palpate bench --anytime`: how good a mesh is that is taken before the run ends, strategies beside what people do without a planner.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "planner/options.h"
#include "tools/simulation.h"

namespace palpate {

// A mesh after some probes.
struct AnytimePoint {
    std::string config;
    std::string method;  // a strategy, or "z-raster", "random rays" or "Gaussian process"
    std::uint64_t probes = 0;
    double displacement = 0.0;  // mm
    std::size_t facets = 0;
    double hausdorff = 0.0;      // mm, two-sided; infinite without a mesh
    double mean_distance = 0.0;  // mm; infinite without a mesh
    std::uint64_t unsafe_moves = 0;
    double p99 = 0.0;  // mm: 99 % of the object's surface are nearer to the mesh; infinite without one
    std::int64_t euler_characteristic = 0;
    std::size_t boundary_edges = 0;  // and such as more than two facets have
    double seconds = 0.0;            // of computing
};

// Runs every strategy to its end, and again with smaller and smaller budgets of probes, three for every power of ten; the
// baselines with the same budgets, a Gaussian process with at most 500. With `probing.tolerance` also what sessions with that tolerance,
// and with greater ones, end with: the curved surface. `on_point` is told of each and may be empty.
[[nodiscard]] std::vector<AnytimePoint> measure_anytime(const std::string& name, SessionConfig config, const Scene& scene,
                                                        const std::vector<Strategy>& strategies,
                                                        const std::function<void(const AnytimePoint&)>& on_point);

// Columns: config, method, probes, displacement (mm), facets, hausdorff (mm), mean_distance (mm), unsafe_moves, p99 (mm),
// euler_characteristic, boundary_edges, seconds.
[[nodiscard]] std::string anytime_csv(const std::vector<AnytimePoint>& points);
// The Hausdorff distance over probes and over displacement.
[[nodiscard]] std::string anytime_svg(const std::vector<AnytimePoint>& points);

}  // namespace palpate
