// Creases between touches: facets that cut one off are split along it.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct SharpMesh {
    TriangleMesh mesh;                    // first the points that it was made of, then places on creases
    std::vector<std::uint32_t> facet_of;  // per triangle: the one that it is a part of
    std::vector<double> error;            // per point, mm
};

// Touches are seldom on a crease, and facets from one side of it to the other cut it off. Where the surfaces of both sides, each of its own
// touches, go on as far as they meet, the edges between are split there. `error`: as in TouchedMesh, not empty. No place is farther from
// the edge that it splits than `most` (mm) and half of its length.
[[nodiscard]] SharpMesh sharpened(const TriangleMesh& mesh, const std::vector<double>& error, const std::vector<std::uint8_t>& flat,
                                  double most);

}  // namespace palpate
