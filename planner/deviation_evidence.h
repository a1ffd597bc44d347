// How near a curved surface through the samples is to S, as touches show (planner/DESIGN.md, "Touches where the shape needs them").
#pragma once

#include <array>
#include <cstdint>

namespace palpate {

// Touches of places of which about as much was stated: how often S was within that.
struct StatedDeviation {
    double least = 0.0;  // mm: more than that was stated ...
    double most = 0.0;   // mm: ... and so much at most
    std::uint64_t touched = 0;
    std::uint64_t within = 0;  // of these, up to the touch error; 95 % if what is stated is right
    double worst = 0.0;        // mm
};

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
    double scale = 1.0;              // of what the curved surface states by itself, as touches showed
    // By what was stated, audits among them: up to a quarter of the tolerance, half of it, it, twice, more.
    std::array<StatedDeviation, 5> stated{};
};

}  // namespace palpate
