// The exact account of a run: what was asked, what was touched, how far the tool went (DESIGN section 9).
#pragma once

#include <cstdint>
#include <optional>

#include "planner/geometry.h"

namespace palpate {

struct Account {
    // Guarded moves that asked for an answer; contact + clear is their total.
    std::uint64_t contact = 0;
    std::uint64_t clear = 0;
    std::uint64_t failed = 0;            // besides: asked, without an answer that can be used
    std::uint64_t grazes = 0;            // contacts that a later probe of the same edge took back
    std::uint64_t checks = 0;            // of contact and clear: asked only to see whether the probe works, or asked again
    std::uint64_t seed = 0;              // of them, before the triangulation
    std::uint64_t inferred_contact = 0;  // facets of the mesh whose crossing is known without a touch
    std::uint64_t inferred_clear = 0;    // edges known to be free without a probe
    double travel = 0.0;                 // mm: motion between probes
    double probing = 0.0;                // mm: motion of probes, to where they stopped
    double home = 0.0;                   // mm: after the last touch, to where the tool began

    [[nodiscard]] std::uint64_t probes() const { return contact + clear; }
    [[nodiscard]] double displacement() const { return travel + probing + home; }
};

// One contact with S, in the order of the run.
struct Touch {
    enum class Role {
        crossing,    // on a Voronoi edge; not a sample
        seed,        // a first touch
        seed_facet,  // a vertex of a persistent facet, nearer than ε to its fellows
        refinement,  // a sample: the centre of a ball larger than ε
        repair,      // a sample: the centre of a smaller ball at a defect of Ŝ (DESIGN section 4)
        check,       // a known place, touched again to see whether the probe works; not a sample
    };
    Point position = Point::Zero();
    Point from = Point::Zero();  // where the probe that found it started
    Role role = Role::crossing;
    std::optional<std::uint32_t> sample;  // its index among the samples
};

}  // namespace palpate
