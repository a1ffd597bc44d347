#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "planner/part/part_surface.h"

namespace palpate {

const char* name_of(PartTag tag) {
    switch (tag) {
        case PartTag::tip:
            return "tip";
        case PartTag::shadow:
            return "shadow";
        case PartTag::ambiguous:
            return "ambiguous";
        case PartTag::fixture:
            return "fixture";
        case PartTag::bridged:
            return "bridged";
        case PartTag::untouched:
            return "untouched";
    }
    return "";
}

PartReport report_on(const PartSurface& part) {
    PartReport report;
    std::vector<std::pair<double, double>> measured;  // uncertainty, area
    double total = 0;
    for (std::size_t f = 0; f < part.mesh.triangles.size(); ++f) {
        const auto& [a, b, c] = part.mesh.triangles[f];
        const auto& points = part.mesh.points;
        const double area = (points[b] - points[a]).cross(points[c] - points[a]).norm() / 2;
        report.area[static_cast<std::size_t>(part.facet_tags[f])] += area;
        if (!is_measured(part.facet_tags[f])) continue;
        measured.emplace_back(std::max({part.uncertainty[a], part.uncertainty[b], part.uncertainty[c]}), area);
        total += area;
    }
    if (measured.empty()) return report;
    std::ranges::sort(measured);
    const auto quantile = [&](double share) {
        double sum = 0;
        for (const auto& [uncertainty, area] : measured) {
            sum += area;
            if (sum >= share * total) return uncertainty;
        }
        return measured.back().first;
    };
    report.uncertainty_median = quantile(0.5);
    report.uncertainty_95 = quantile(0.95);
    report.uncertainty_maximum = measured.back().first;
    return report;
}

namespace {

// Of the facets that stay. Points that none of them uses go.
template <class Stays>
PartSurface only(const PartSurface& closed, Stays stays) {
    constexpr auto kNone = static_cast<std::uint32_t>(-1);
    PartSurface open;
    std::vector<std::uint32_t> number(closed.mesh.points.size(), kNone);
    auto crossing = closed.crossings.begin();
    for (std::size_t f = 0; f < closed.mesh.triangles.size(); ++f) {
        const bool is_crossing = crossing != closed.crossings.end() && *crossing == f;
        if (is_crossing) ++crossing;
        if (!stays(f)) continue;
        if (is_crossing) open.crossings.push_back(static_cast<std::uint32_t>(open.mesh.triangles.size()));
        std::array<std::uint32_t, 3> corners = closed.mesh.triangles[f];
        for (std::uint32_t& v : corners) {
            if (number[v] == kNone) {
                number[v] = static_cast<std::uint32_t>(open.mesh.points.size());
                open.mesh.points.push_back(closed.mesh.points[v]);
                open.normals.push_back(closed.normals[v]);
                open.uncertainty.push_back(closed.uncertainty[v]);
                open.tags.push_back(closed.tags[v]);
            }
            v = number[v];
        }
        open.mesh.triangles.push_back(corners);
        open.facet_tags.push_back(closed.facet_tags[f]);
    }
    return open;
}

}  // namespace

PartSurface without_unmeasured(const PartSurface& closed) {
    return only(closed, [&](std::size_t facet) { return is_measured(closed.facet_tags[facet]); });
}

PartSurface without_outside(const PartSurface& closed) {
    return only(closed, [&](std::size_t facet) {
        return std::ranges::none_of(closed.mesh.triangles[facet], [&](std::uint32_t v) { return closed.tags[v] == PartTag::untouched; });
    });
}

}  // namespace palpate
