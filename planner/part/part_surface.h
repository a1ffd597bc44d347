// From S*, the surface that the ball's centre traced, to the surface of the part that the ball touched
// (planner/DESIGN.md, "From S* to the part").
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "planner/area.h"
#include "planner/geometry.h"
#include "planner/tool_shape.h"

namespace palpate {

// What a place of the part rests on.
enum class PartTag : std::uint8_t {
    tip,        // the ball touched it
    shadow,     // the shank or the holder touched what lies above: the part is somewhere behind it
    ambiguous,  // ball and shank explain the touches equally well
    fixture,    // a fixture, known without a touch
    bridged,    // an inner edge, narrower than the ball reaches
    untouched,  // between a fixture and touches, or wider than epsilon: no touch stands for it; of a point: outside
};
inline constexpr std::size_t kPartTags = 6;
[[nodiscard]] const char* name_of(PartTag tag);
// Did the ball touch the part there, or bridge it within a known gap?
[[nodiscard]] inline bool is_measured(PartTag tag) { return tag == PartTag::tip || tag == PartTag::bridged; }

struct TracedSurface {
    TriangleMesh mesh;                       // closed; its points are places of the ball's centre
    std::vector<std::uint8_t> is_fixture;    // per point: 1 on a grown fixture, known without a touch. Empty: none is
    std::vector<Vector> to_tool;             // per point: unit, to where the tool came from; zero: not known. Empty: none is
    std::vector<std::uint8_t> is_outside{};  // per point: 1 on a wall around the area that alone was probed. Empty: none is
    std::optional<Area> area{};              // that one
};

struct CompensationOptions {
    double noise = 0.0;    // mm, >= 0: how far a touch lies beside S* at most
    double epsilon = 0.0;  // mm, > 0: circumradius of the largest facet that touches stand for
};

// What one point of S* says about the part.
struct TouchedPoint {
    Point point = Point::Zero();       // where the tool touched: a radius from the centre, against the normal
    Vector normal = Vector::UnitZ();   // unit, out of the part
    double uncertainty = 0.0;          // mm: how far the part may be from `point`; infinite where it is not measured
    PartTag tag = PartTag::untouched;  // never `bridged`
};

struct PartSurface {
    TriangleMesh mesh;
    std::vector<Vector> normals;           // per point: unit, out of the part
    std::vector<double> uncertainty;       // per point, mm: as above, and how far the facets around it may be from the part
    std::vector<PartTag> tags;             // per point
    std::vector<PartTag> facet_tags;       // per triangle
    std::vector<std::uint32_t> crossings;  // triangles that pass through others, in order; their uncertainty says how far
};

struct PartReport {
    std::array<double, kPartTags> area{};  // mm², by tag
    // mm, over the measured facets by area, of the largest at their corners; 0 without any.
    double uncertainty_median = 0.0;
    double uncertainty_95 = 0.0;
    double uncertainty_maximum = 0.0;
};

struct Compensation {
    std::vector<TouchedPoint> touched;  // per point of S*
    PartSurface closed;                 // with shadows and fixtures; open where points are outside
    PartReport report;                  // of `closed`
};

// Removes the tool from S*. Linear in the number of points but for searches in trees. Throws std::invalid_argument if the mesh has no
// facets, names points that it does not have, or is not finite; if lists are not as long as the mesh's points; or if `tool` or `options`
// are out of their ranges.
[[nodiscard]] Compensation compensate(const TracedSurface& traced, const ToolShape& tool, const CompensationOptions& options);

[[nodiscard]] PartReport report_on(const PartSurface& part);

// Without shadows, what may be one, fixtures and what was not touched: a surface with boundary. Points that no facet uses go.
[[nodiscard]] PartSurface without_unmeasured(const PartSurface& closed);

// Without facets at points that are outside.
[[nodiscard]] PartSurface without_outside(const PartSurface& closed);

}  // namespace palpate
