// `palpate bench --reliability`: whether plausible facets are as often right as they are said to be.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/bench.h"

namespace palpate {

// Plausible facets that are about as likely wrong.
struct ReliabilityBin {
    double from = 0.0;  // chance of error
    double to = 0.0;
    std::uint64_t facets = 0;
    double stated = 0.0;      // mean chance of error
    std::uint64_t wrong = 0;  // flips apart
    std::uint64_t flips = 0;
};

// Of the meshes of all runs together; bins without a facet are left out. Facets that touches or proofs put there do not count.
[[nodiscard]] std::vector<ReliabilityBin> measure_reliability(std::span<const BenchRow> rows);

[[nodiscard]] std::string reliability_table(const std::vector<ReliabilityBin>& bins);
// Columns: from, to, facets, stated, wrong, flips.
[[nodiscard]] std::string reliability_csv(const std::vector<ReliabilityBin>& bins);
// Found over stated, beside the diagonal.
[[nodiscard]] std::string reliability_svg(const std::vector<ReliabilityBin>& bins);

}  // namespace palpate
