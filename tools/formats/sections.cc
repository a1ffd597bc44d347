#include "tools/formats/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

namespace palpate {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the lower point first

struct Step {
    Edge from;
    Edge to;
};

Edge edge(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

// From where the outline goes down to where it comes up again: so the inside is to the left.
std::vector<Step> steps_at(const TriangleMesh& mesh, double z) {
    const auto is_above = [&](std::uint32_t v) { return mesh.points[v].z() > z; };
    std::vector<Step> steps;
    for (const auto& t : mesh.triangles) {
        Step step;
        bool crosses = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t.at(k);
            const std::uint32_t b = t.at((k + 1) % 3);
            if (is_above(a) == is_above(b)) continue;
            (is_above(a) ? step.from : step.to) = edge(a, b);
            crosses = true;
        }
        if (crosses) steps.push_back(step);
    }
    return steps;
}

std::array<double, 2> crossing(const TriangleMesh& mesh, const Edge& e, double z) {
    const Point& a = mesh.points[e.first];
    const Point& b = mesh.points[e.second];
    const double share = (z - a.z()) / (b.z() - a.z());
    return {a.x() + share * (b.x() - a.x()), a.y() + share * (b.y() - a.y())};
}

}  // namespace

std::vector<Polyline> section(const TriangleMesh& mesh, double z) {
    const std::vector<Step> steps = steps_at(mesh, z);
    std::multimap<Edge, std::size_t> by_start;
    std::map<Edge, int> ends;
    for (std::size_t k = 0; k < steps.size(); ++k) {
        by_start.emplace(steps[k].from, k);
        ++ends[steps[k].to];
    }
    std::vector<bool> used(steps.size(), false);
    std::vector<Polyline> lines;
    const auto follow = [&](std::size_t first) {
        Polyline line;
        line.points.push_back(crossing(mesh, steps[first].from, z));
        for (std::size_t at = first;;) {
            used[at] = true;
            const Edge& end = steps[at].to;
            line.is_closed = end == steps[first].from;
            if (line.is_closed) break;
            line.points.push_back(crossing(mesh, end, z));
            const auto [low, high] = by_start.equal_range(end);
            const auto next = std::find_if(low, high, [&](const auto& entry) { return !used[entry.second]; });
            if (next == high) break;
            at = next->second;
        }
        lines.push_back(std::move(line));
    };
    // First what begins at a boundary of the mesh.
    for (std::size_t k = 0; k < steps.size(); ++k) {
        if (!used[k] && !ends.contains(steps[k].from)) follow(k);
    }
    for (std::size_t k = 0; k < steps.size(); ++k) {
        if (!used[k]) follow(k);
    }
    return lines;
}

std::string to_dxf(const TriangleMesh& mesh, std::span<const double> heights) {
    std::string out =
        "999\nmade by Palpate; millimetres\n0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
    for (const double z : heights) {
        const std::string layer = fmt::format("Z{}", z);
        for (const Polyline& line : section(mesh, z)) {
            fmt::format_to(std::back_inserter(out), "0\nPOLYLINE\n8\n{}\n66\n1\n10\n0\n20\n0\n30\n{}\n70\n{}\n", layer, z,
                           line.is_closed ? 1 : 0);
            for (const auto& [x, y] : line.points) {
                fmt::format_to(std::back_inserter(out), "0\nVERTEX\n8\n{}\n10\n{}\n20\n{}\n30\n{}\n", layer, x, y, z);
            }
            fmt::format_to(std::back_inserter(out), "0\nSEQEND\n8\n{}\n", layer);
        }
    }
    return out + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace palpate
