// The part, out of what the centre of its ball traced: what a session with a tool leaves besides (planner/DESIGN.md, "Session folder").
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "planner/part/part_surface.h"
#include "planner/probe_surface.h"
#include "planner/topology.h"
#include "tools/view/picture.h"

namespace palpate {

struct PartResult {
    PartSurface surface;  // closed or open, as results.part says
    PartReport report;
    Topology topology;                          // of the surface
    std::vector<TouchedPoint> touched;          // by point of Ŝ
    std::vector<std::uint32_t> point_of_touch;  // by touch: the point of Ŝ that it became, or kNoPoint (planner/part/traced_surface.h)
};

// Nothing without a tool, or without a mesh.
[[nodiscard]] std::optional<PartResult> part_of(const Result& result, const SessionConfig& config);

// sRGB, as pictures and PLY files show a tag.
using TagColour = std::array<std::uint8_t, 3>;
[[nodiscard]] TagColour colour_of(PartTag tag);
// The tags that there are, each with its share of the area that does not lie on fixtures.
[[nodiscard]] std::vector<LegendEntry> legend_of(const TriangleMesh& mesh, const std::vector<PartTag>& facet_tags);

// ASCII PLY: points with normal, uncertainty (mm, -1: not known), tag and colour; triangles with tag.
[[nodiscard]] std::string to_ply(const PartSurface& part, const std::vector<std::string>& comments);

// By triangle, of what to_ply() wrote of a part; empty if the text is of something else.
[[nodiscard]] std::vector<PartTag> facet_tags_in(const std::string& ply);

// As to_csv(touches), with what every touch says of the part.
[[nodiscard]] std::string to_csv(const std::vector<Touch>& touches, const PartResult& part);

// For people: areas by tag, and how sure the measured ones are.
[[nodiscard]] std::string describe(const PartReport& report);

}  // namespace palpate
