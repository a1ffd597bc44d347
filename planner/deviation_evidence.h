// How near a curved surface through the samples is to S, as touches show (planner/DESIGN.md, "Touches where the shape needs them").
#pragma once

#include <cstdint>

namespace palpate {

// What touches of places that were foretold found.
struct DeviationEvidence {
    double tolerance = 0.0;          // mm: what was asked for
    double foretold = 0.0;           // mm: the largest deviation that is still foretold anywhere
    std::uint64_t unmet_facets = 0;  // where it is beyond the tolerance, and no touch can help: too near to samples, or no way led there
    std::uint64_t touched = 0;       // places that were foretold, audits apart
    std::uint64_t audited = 0;       // places drawn at random, with equal chances by area
    std::uint64_t beyond = 0;        // of those: S was farther off than the tolerance
    std::uint64_t barred = 0;        // drawn, but nothing was met there
    double worst = 0.0;              // mm: of those
};

}  // namespace palpate
