// Which triangles of a mesh pass through others.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Pairs, in order; exact. Triangles that share a corner or an edge cross if they meet anywhere else.
[[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing_pairs(const TriangleMesh& mesh);
// Of these the pairs that one of `changed` is in.
[[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing_pairs(const TriangleMesh& mesh,
                                                                                  const std::vector<std::uint32_t>& changed);

}  // namespace palpate
