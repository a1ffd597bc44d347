// surface.ply: the curved surface of what a session touched (planner/DESIGN.md, "A curved surface").
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "planner/curved/curved_surface.h"
#include "planner/probe_surface.h"
#include "tools/part_result.h"

namespace palpate {

// Nothing where `results.surface` says so, or the mesh is incomplete. Of a part only what the ball touched is curved.
[[nodiscard]] std::optional<CurvedSurface> curved_of(const Result& result, const std::optional<PartResult>& part,
                                                     const SessionConfig& config);

// Binary PLY, little-endian: points with normal, principal curvatures (1/mm), uncertainty (mm; -1: not measured) and tag, triangles with
// the number of their facet in mesh.ply. REQUIRES: each comment is one line.
[[nodiscard]] std::string to_ply(const CurvedSurface& surface, const std::vector<std::string>& comments = {});

}  // namespace palpate
