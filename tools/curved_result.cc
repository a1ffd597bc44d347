#include "tools/curved_result.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <concepts>
#include <iterator>
#include <utility>

#include "planner/part/traced_surface.h"

namespace palpate {
namespace {

void append_bytes(std::string& text, std::unsigned_integral auto bits) {
    for (std::size_t k = 0; k < sizeof bits; ++k) text += static_cast<char>(static_cast<unsigned char>(bits >> (8 * k)));
}
void append_bytes(std::string& text, double x) { append_bytes(text, std::bit_cast<std::uint64_t>(x)); }
void append_bytes(std::string& text, float x) { append_bytes(text, std::bit_cast<std::uint32_t>(x)); }

// Surprises tell how good what it states is.
CurvedSurface stated_as_touched(CurvedSurface surface, const Result& result) {
    if (!result.deviation) return surface;
    for (double& uncertainty : surface.uncertainty) uncertainty *= result.deviation->scale;
    return surface;
}

}  // namespace

std::optional<CurvedSurface> curved_of(const Result& result, const std::optional<PartResult>& part, const SessionConfig& config) {
    if (!config.results.surface || result.mesh.triangles.empty() || result.certificate.status == Certificate::Status::incomplete)
        return std::nullopt;
    CurvedOptions options;
    options.epsilon = config.probing.epsilon;
    if (!part) {
        const double error = config.traits().touch_error;
        TriangleMesh mesh = mesh_within_area(result);
        const std::vector<double> errors(mesh.points.size(), error);
        return stated_as_touched(curve({std::move(mesh), errors, {}}, options), result);
    }
    TouchedMesh touched{part->surface.mesh, part->surface.uncertainty, {}};
    for (const PartTag tag : part->surface.facet_tags) touched.is_flat.push_back(tag == PartTag::tip ? 0 : 1);
    return stated_as_touched(curve(touched, options), result);
}

std::string to_ply(const CurvedSurface& surface, const std::vector<std::string>& comments) {
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    const auto out = std::back_inserter(text);
    for (const std::string& comment : comments) fmt::format_to(out, "comment {}\n", comment);
    fmt::format_to(out,
                   "comment tag 0: smooth\ncomment tag 1: crease\ncomment tag 2: corner\ncomment tag 3: flat\n"
                   "element vertex {}\n"
                   "property double x\nproperty double y\nproperty double z\n"
                   "property float nx\nproperty float ny\nproperty float nz\n"
                   "property float curvature_max\nproperty float curvature_min\n"
                   "property float uncertainty\n"
                   "property uchar tag\n"
                   "element face {}\n"
                   "property list uchar int vertex_indices\n"
                   "property uint facet\n"
                   "end_header\n",
                   surface.mesh.points.size(), surface.mesh.triangles.size());
    for (std::size_t v = 0; v < surface.mesh.points.size(); ++v) {
        for (const double x : surface.mesh.points[v]) append_bytes(text, x);
        for (const double x : surface.normals[v]) append_bytes(text, static_cast<float>(x));
        for (const double x : surface.curvature[v]) append_bytes(text, static_cast<float>(x));
        append_bytes(text, static_cast<float>(std::isfinite(surface.uncertainty[v]) ? surface.uncertainty[v] : -1.0));
        append_bytes(text, static_cast<std::uint8_t>(surface.tags[v]));
    }
    for (std::size_t f = 0; f < surface.mesh.triangles.size(); ++f) {
        append_bytes(text, std::uint8_t{3});
        for (const std::uint32_t v : surface.mesh.triangles[f]) append_bytes(text, v);
        append_bytes(text, surface.facet_of[f]);
    }
    return text;
}

}  // namespace palpate
