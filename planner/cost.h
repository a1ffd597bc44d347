// What a run cost, exactly: what was asked, how often it was touched, how far the tool went (planner/DESIGN.md, "What a run may cost").
#pragma once

#include <cstdint>

namespace palpate {

struct Cost {
    std::uint64_t contact = 0;            // guarded moves that asked for an answer and met S
    std::uint64_t clear = 0;              // the same, and reached their target
    std::uint64_t failed = 0;             // the same, without an answer that can be used
    std::uint64_t grazes = 0;             // contacts that a later probe of the same edge took back
    std::uint64_t checks = 0;             // of contact and clear: asked only to see whether the probe works, or asked again
    std::uint64_t seed = 0;               // of contact and clear: before the triangulation
    std::uint64_t inferred_contact = 0;   // facets of the mesh whose crossing is proven without a touch
    std::uint64_t plausible_contact = 0;  // facets of the mesh that no touch and no proof put there
    std::uint64_t inferred_clear = 0;     // edges known to be free without a probe
    std::uint64_t known_contact = 0;      // places on known solids that became part of the sample, or were looked at: no touch
    double travel = 0.0;                  // mm: motion between probes
    double probing = 0.0;                 // mm: motion of probes, to where they stopped
    double home = 0.0;                    // mm: after the last touch, to where the tool began

    [[nodiscard]] std::uint64_t probes() const { return contact + clear; }
    [[nodiscard]] double displacement() const { return travel + probing + home; }
};

}  // namespace palpate
