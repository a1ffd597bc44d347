// `palpate bench`: the same objects, several strategies, one table.
#pragma once

#include <string>
#include <vector>

#include "planner/options.h"
#include "tools/simulation.h"

namespace palpate {

struct BenchRow {
    std::string config;
    Strategy strategy;
    double epsilon = 0.0;
    Simulation run;
};

// Columns of the table, the CSV and the JSON are the same: config, strategy, epsilon (mm), samples, samples_per_bound,
// probes, probes_per_sample, displacement (mm), displacement_per_bound, euler_characteristic, components,
// nonmanifold_edges, hausdorff (mm), status, unsafe_moves, planner_seconds, oracle_seconds.
// The table has a row for each run; where that is wider than `columns` (0: any width will do), one for each quantity.
[[nodiscard]] std::string bench_table(const std::vector<BenchRow>& rows, int columns = 0);
[[nodiscard]] std::string bench_csv(const std::vector<BenchRow>& rows);
[[nodiscard]] std::string bench_json(const std::vector<BenchRow>& rows);

}  // namespace palpate
