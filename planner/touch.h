// One contact with the surface.
#pragma once

#include <cstdint>
#include <optional>

#include "planner/geometry.h"

namespace palpate {

// One contact with S, or a place where a known solid bounds it, in the order of the run.
struct Touch {
    enum class Role {
        crossing,    // on a Voronoi edge; not a sample
        seed,        // a first touch
        seed_facet,  // a vertex of a persistent facet, nearer than ε to its fellows
        refinement,  // a sample: the centre of a ball larger than ε
        repair,      // a sample: the centre of a smaller ball at a defect of Ŝ (planner/DESIGN.md, "Repair")
        check,       // a known place, touched again to see whether the probe works; not a sample
        earlier,     // touched by an earlier run
    };
    Point position = Point::Zero();
    Point from = Point::Zero();  // where the probe that found it started
    Role role = Role::crossing;
    std::optional<std::uint32_t> sample;  // its index among the samples
    bool is_known = false;                // on a known solid: nothing was touched
};

}  // namespace palpate
