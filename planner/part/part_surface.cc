#include "planner/part/part_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planner/part/internal/bridges.h"
#include "planner/part/internal/contact.h"
#include "planner/part/internal/facet_fans.h"
#include "planner/part/internal/shadow.h"
#include "planner/part/internal/sharp_edges.h"
#include "planner/part/internal/surface_fit.h"

namespace palpate {
namespace {

// Of ε: points of the part that are nearer to each other are one. As near as samples come by refinement (planner/DESIGN.md, "Terms":
// floor).
constexpr double kSamePlace = 1.0 / 8;

void check(const TracedSurface& traced, const ToolShape& tool, const CompensationOptions& options) {
    const auto require = [](bool holds, const char* what) {
        if (!holds) throw std::invalid_argument(what);
    };
    const std::size_t points = traced.mesh.points.size();
    require(!traced.mesh.triangles.empty(), "the traced surface has no facets");
    for (const auto& triangle : traced.mesh.triangles) {
        for (const std::uint32_t v : triangle) require(v < points, "a facet of the traced surface names a point that it does not have");
    }
    for (const Point& p : traced.mesh.points) require(p.allFinite(), "a point of the traced surface is not finite");
    require(traced.is_fixture.empty() || traced.is_fixture.size() == points, "is_fixture is not as long as the mesh's points");
    require(traced.is_outside.empty() || traced.is_outside.size() == points, "is_outside is not as long as the mesh's points");
    require(traced.to_tool.empty() || traced.to_tool.size() == points, "to_tool is not as long as the mesh's points");
    require(std::isfinite(tool.ball_diameter) && tool.ball_diameter > 0, "the ball's diameter is not positive and finite");
    require(!tool.stylus || (tool.stylus->diameter > 0 && tool.stylus->length > 0), "the stylus has no positive diameter and length");
    require(!tool.stylus || tool.stylus->diameter <= tool.ball_diameter, "the stylus is wider than the ball");
    require(!tool.holder || (tool.holder->diameter > 0 && tool.holder->length > 0), "the holder has no positive diameter and length");
    require(std::abs(tool.axis.norm() - 1) < 1e-6, "the tool's axis is no unit vector");
    require(options.noise >= 0 && std::isfinite(options.noise), "the noise is negative or not finite");
    require(options.epsilon > 0, "epsilon is not positive");
}

// A touch that comes straight from free space sees the side of the surface that it met: a normal that says otherwise is turned just so far.
void turn_to_tool(std::vector<SurfaceFit>& fits, const std::vector<Vector>& to_tool) {
    for (std::size_t v = 0; v < to_tool.size(); ++v) {
        const double towards = fits[v].normal.dot(to_tool[v]);
        if (!(towards < 0)) continue;
        const Vector turned = fits[v].normal - towards * to_tool[v];
        fits[v].angle += std::asin(std::min(1.0, -towards));
        fits[v].normal = turned.norm() > 1e-6 ? turned.normalized() : to_tool[v];
    }
}

// What the facets around a point say besides: how far the surface between corners may be from the chord.
void add_chords(PartSurface& part) {
    std::vector<double> chords(part.mesh.points.size(), 0.0);
    for (std::size_t f = 0; f < part.mesh.triangles.size(); ++f) {
        if (part.facet_tags[f] != PartTag::tip) continue;
        const auto& corners = part.mesh.triangles[f];
        double chord = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = corners[k];
            const std::uint32_t b = corners[(k + 1) % 3];
            chord = std::max(chord, chord_error(part.mesh.points[a], part.normals[a], part.mesh.points[b], part.normals[b]));
        }
        for (const std::uint32_t v : corners) chords[v] = std::max(chords[v], chord);
    }
    for (std::size_t v = 0; v < chords.size(); ++v) part.uncertainty[v] += chords[v];
}

}  // namespace

Compensation compensate(const TracedSurface& traced, const ToolShape& tool, const CompensationOptions& options) {
    check(traced, tool, options);
    const double radius = tool.ball_diameter / 2;
    const FacetFans fans(traced.mesh);
    std::vector<Sweep> sweeps(traced.mesh.points.size(), Sweep::ball);
    for (std::size_t v = 0; v < traced.is_fixture.size(); ++v) {
        if (traced.is_fixture[v] != 0) sweeps[v] = Sweep::fixture;
    }
    Compensation result;
    // What the shank swept shows once normals are known, and normals beside it once it is known.
    for (int round = 0; round < 2; ++round) {
        std::vector<SurfaceFit> fits = fit_surface(traced.mesh, fans, sweeps, options.noise);
        turn_to_tool(fits, traced.to_tool);
        result.touched =
            tell_shadows(traced, fans, touch_points(traced.mesh, fans, fits, radius, options.noise), tool, options, round == 1);
        for (std::size_t v = 0; v < sweeps.size(); ++v) {
            if (result.touched[v].tag == PartTag::shadow) sweeps[v] = Sweep::shank;
        }
    }
    for (std::size_t v = 0; v < traced.is_outside.size(); ++v) {
        if (traced.is_outside[v] != 0) result.touched[v].tag = PartTag::untouched;
    }
    result.closed = assemble(traced, result.touched, options.epsilon);
    split_bridges(result.closed, traced, radius);
    join_near_points(result.closed, kSamePlace * options.epsilon);
    if (!traced.is_outside.empty()) result.closed = without_outside(result.closed);
    add_chords(result.closed);
    find_crossings(result.closed);
    result.report = report_on(result.closed);
    return result;
}

}  // namespace palpate
