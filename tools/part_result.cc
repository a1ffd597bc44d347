#include "tools/part_result.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numeric>

#include "planner/part/traced_surface.h"
#include "tools/session_files.h"

namespace palpate {
namespace {

constexpr std::array<PartTag, kPartTags> kTags{PartTag::tip,     PartTag::shadow,  PartTag::ambiguous,
                                               PartTag::fixture, PartTag::bridged, PartTag::untouched};

// A touch is farther off than so many RMS of what a calibration leaves once in 370 times.
constexpr double kOfRms = 3.0;

// A line of the PLY file's header.
std::string tag_comment(PartTag tag) { return fmt::format("comment tag {}: {}\n", static_cast<int>(tag), name_of(tag)); }

}  // namespace

std::optional<PartResult> part_of(const Result& result, const SessionConfig& config) {
    if (!config.tool || result.mesh.triangles.empty()) return std::nullopt;
    PartResult part;
    part.point_of_touch = points_of_touches(result);
    TracedSurface traced = traced_surface(result, part.point_of_touch);
    ToolShape tool = *config.tool;
    CompensationOptions options{config.traits().touch_error, config.probing.epsilon};
    Compensation found = compensate(traced, tool, options);
    if (const auto& calibration = config.probe_calibration) {
        // Lobes depend on the normal, which is known now.
        for (std::size_t v = 0; v < traced.mesh.points.size(); ++v) {
            if (traced.is_fixture[v] != 0) continue;
            traced.mesh.points[v] = calibration->lobing.corrected(traced.mesh.points[v], found.touched[v].normal);
        }
        tool.ball_diameter = 2 * calibration->effective_radius_mm;
        options.noise = std::min(options.noise, kOfRms * calibration->rms_mm);
        found = compensate(traced, tool, options);
    }
    part.touched = std::move(found.touched);
    part.report = found.report;
    part.surface = config.results.part == ResultSpec::Part::open ? without_unmeasured(found.closed) : std::move(found.closed);
    part.topology = analyse_topology(part.surface.mesh);
    return part;
}

TagColour colour_of(PartTag tag) {
    switch (tag) {
        case PartTag::tip:
            return {150, 172, 205};
        case PartTag::shadow:
            return {95, 95, 105};
        case PartTag::ambiguous:
            return {225, 195, 80};
        case PartTag::fixture:
            return {205, 190, 165};
        case PartTag::bridged:
            return {225, 135, 60};
        case PartTag::untouched:
            return {190, 70, 65};
    }
    return {};
}

std::vector<LegendEntry> legend_of(const TriangleMesh& mesh, const std::vector<PartTag>& facet_tags) {
    std::array<double, kPartTags> area{};
    for (std::size_t k = 0; k < facet_tags.size(); ++k) {
        const auto& [a, b, c] = mesh.triangles[k];
        const Point& p = mesh.points[a];
        area.at(static_cast<std::size_t>(facet_tags[k])) += 0.5 * (mesh.points[b] - p).cross(mesh.points[c] - p).norm();
    }
    const double of_part = std::accumulate(area.begin(), area.end(), 0.0) - area.at(static_cast<std::size_t>(PartTag::fixture));
    std::vector<LegendEntry> legend;
    for (const PartTag tag : kTags) {
        const double own = area.at(static_cast<std::size_t>(tag));
        if (!(own > 0)) continue;
        const double percent = 100 * own / of_part;
        const std::string share = percent < 1 ? "< 1" : fmt::format("{:.0f}", percent);
        legend.push_back({colour_of(tag), tag == PartTag::fixture ? name_of(tag) : fmt::format("{} {} %", name_of(tag), share)});
    }
    return legend;
}

std::string to_ply(const PartSurface& part, const std::vector<std::string>& comments) {
    std::string text = "ply\nformat ascii 1.0\n";
    const auto out = std::back_inserter(text);
    for (const std::string& comment : comments) fmt::format_to(out, "comment {}\n", comment);
    for (const PartTag tag : kTags) text += tag_comment(tag);
    fmt::format_to(out,
                   "element vertex {}\n"
                   "property double x\nproperty double y\nproperty double z\n"
                   "property double nx\nproperty double ny\nproperty double nz\n"
                   "property double uncertainty\n"
                   "property uchar tag\n"
                   "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                   "element face {}\n"
                   "property list uchar int vertex_indices\n"
                   "property uchar tag\n"
                   "end_header\n",
                   part.mesh.points.size(), part.mesh.triangles.size());
    for (std::size_t k = 0; k < part.mesh.points.size(); ++k) {
        const Point& p = part.mesh.points[k];
        const Vector& n = part.normals[k];
        const double uncertainty = std::isfinite(part.uncertainty[k]) ? part.uncertainty[k] : -1.0;
        const auto [red, green, blue] = colour_of(part.tags[k]);
        fmt::format_to(out, "{} {} {} {} {} {} {} {} {} {} {}\n", p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), uncertainty,
                       static_cast<int>(part.tags[k]), red, green, blue);
    }
    for (std::size_t k = 0; k < part.mesh.triangles.size(); ++k) {
        const auto& [a, b, c] = part.mesh.triangles[k];
        fmt::format_to(out, "3 {} {} {} {}\n", a, b, c, static_cast<int>(part.facet_tags[k]));
    }
    return text;
}

std::vector<PartTag> facet_tags_in(const std::string& ply) {
    const std::string end = "end_header\n";
    const std::size_t header = ply.find(end);
    if (header == std::string::npos || ply.find(fmt::format("\n{}", tag_comment(PartTag::tip))) > header) return {};
    // Tags are the last numbers of the last lines, one for each triangle.
    const std::string counted = "\nelement face ";
    const std::size_t count = ply.find(counted);
    if (count > header) return {};
    const unsigned long facets = std::strtoul(ply.c_str() + count + counted.size(), nullptr, 10);
    if (facets > ply.size()) return {};
    std::vector<PartTag> tags(facets);
    std::size_t line_end = ply.size();
    for (std::size_t k = facets; k-- > 0;) {
        const std::size_t space = ply.rfind(' ', line_end);
        if (space == std::string::npos || space < header) return {};
        const unsigned long number = std::strtoul(ply.c_str() + space, nullptr, 10);
        if (number >= kPartTags) return {};
        tags[k] = static_cast<PartTag>(number);
        line_end = ply.rfind('\n', space);
    }
    return tags;
}

std::string to_csv(const std::vector<Touch>& touches, const PartResult& part) {
    const std::string plain = to_csv(touches);
    std::string text;
    const auto out = std::back_inserter(text);
    std::size_t begin = 0;
    for (std::size_t line = 0; begin < plain.size(); ++line) {
        const std::size_t end = plain.find('\n', begin);
        text.append(plain, begin, end - begin);
        begin = end + 1;
        if (line == 0) {
            text += ",tag,part_x,part_y,part_z,uncertainty\n";
            continue;
        }
        const std::uint32_t point = part.point_of_touch[line - 1];
        if (point == kNoPoint) {
            fmt::format_to(out, ",{},,,,\n", touches[line - 1].is_known ? name_of(PartTag::fixture) : "");
            continue;
        }
        const TouchedPoint& touched = part.touched[point];
        const std::string uncertainty = std::isfinite(touched.uncertainty) ? fmt::format("{}", touched.uncertainty) : "";
        fmt::format_to(out, ",{},{},{},{},{}\n", name_of(touched.tag), touched.point.x(), touched.point.y(), touched.point.z(),
                       uncertainty);
    }
    return text;
}

std::string describe(const PartReport& report) {
    std::string areas;
    for (const PartTag tag : kTags) {
        const double area = report.area.at(static_cast<std::size_t>(tag));
        if (area > 0) areas += fmt::format("{}{:.4g} mm² {}", areas.empty() ? "" : ", ", area, name_of(tag));
    }
    return fmt::format("{}; uncertainty of what was measured {:.3g} mm in the median, {:.3g} for 95 %, at most {:.3g}", areas,
                       report.uncertainty_median, report.uncertainty_95, report.uncertainty_maximum);
}

}  // namespace palpate
