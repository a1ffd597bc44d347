// First touches, and a persistent facet per component, so that no component can vanish from Ŝ (planner/DESIGN.md, "Seeding").
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "planner/errors.h"
#include "planner/motion/probe_head.h"
#include "planner/motion/probed_space.h"
#include "planner/options.h"

namespace palpate {

// Three touches within ε/3 of each other, as indices of samples, and the way that the tool came.
struct SeedFacet {
    std::array<std::uint32_t, 3> samples{};
    Vector approach = Vector::Zero();  // unit
};

// Touches seeds and initialises `state` with them: the user's, or one by rays towards the centre of ω, and a few more
// first touches. Then gives every seed its facet, where that succeeds: the facets come back. Throws SeedError.
std::vector<SeedFacet> touch_seeds(const Options& options, ProbedSpace& space, ProbeHead& head);

// Touches twice more beside a first touch (a sample, reached by a straight way from outside ω in direction `approach`),
// inserts these samples, and touches the facet's dual edge, from outside ω along the edge's line. Nothing if the surface
// around the sample does not allow it. No later sample removes the facet, because a sample is farther than ε from all
// others and the facet's ball is smaller than ε/2 (thesis 4.2.1).
std::optional<SeedFacet> touch_seed_facet(const Options& options, ProbedSpace& space, ProbeHead& head, std::uint32_t sample,
                                          const Vector& approach);

// The k-th of an endless sequence of unit vectors whose every beginning is well spread over the sphere.
[[nodiscard]] Vector spread_direction(int k);

}  // namespace palpate
