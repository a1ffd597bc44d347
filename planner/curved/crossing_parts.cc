#include "planner/curved/internal/crossing_parts.h"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = Kernel::Point_3;
using Triangle = std::array<std::uint32_t, 3>;

bool has(const Triangle& t, std::uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

class Crossings {
public:
    explicit Crossings(const TriangleMesh& mesh) : mesh_(mesh) {
        points_.reserve(mesh.points.size());
        for (const Point& p : mesh.points) points_.emplace_back(p.x(), p.y(), p.z());
    }

    [[nodiscard]] bool cross(std::uint32_t f, std::uint32_t g) const {
        const Triangle& s = mesh_.triangles[f];
        const Triangle& t = mesh_.triangles[g];
        const auto shared = static_cast<std::size_t>(std::ranges::count_if(s, [&](std::uint32_t v) { return has(t, v); }));
        if (shared == 0) return do_meet(s, t);
        if (shared == 1) return reaches_into(s, t) || reaches_into(t, s);
        return shared == 2 && is_folded(s, t);
    }

private:
    [[nodiscard]] const CgalPoint& at(std::uint32_t v) const { return points_[v]; }
    [[nodiscard]] bool is_degenerate(const Triangle& t) const { return CGAL::collinear(at(t[0]), at(t[1]), at(t[2])); }
    [[nodiscard]] Kernel::Triangle_3 triangle(const Triangle& t) const { return {at(t[0]), at(t[1]), at(t[2])}; }
    [[nodiscard]] bool do_meet(const Triangle& s, const Triangle& t) const {
        if (is_degenerate(s) || is_degenerate(t)) return false;
        return CGAL::do_intersect(triangle(s), triangle(t));
    }
    // Does the edge of s that is opposite to the corner that both have meet t?
    [[nodiscard]] bool reaches_into(const Triangle& s, const Triangle& t) const {
        if (is_degenerate(t)) return false;
        for (std::size_t k = 0; k < 3; ++k) {
            if (!has(t, s[k])) continue;
            const CgalPoint& a = at(s[(k + 1) % 3]);
            const CgalPoint& b = at(s[(k + 2) % 3]);
            return a != b && CGAL::do_intersect(triangle(t), Kernel::Segment_3(a, b));
        }
        return false;
    }
    // Two that share an edge cross if they lie in one plane, on the same side of it.
    [[nodiscard]] bool is_folded(const Triangle& s, const Triangle& t) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (has(t, s[k])) continue;
            const auto apex = std::ranges::find_if(t, [&](std::uint32_t v) { return !has(s, v); });
            const CgalPoint& a = at(s[(k + 1) % 3]);
            const CgalPoint& b = at(s[(k + 2) % 3]);
            if (!CGAL::coplanar(a, b, at(s[k]), at(*apex)) || CGAL::collinear(a, b, at(s[k])) || CGAL::collinear(a, b, at(*apex)))
                return false;
            return CGAL::coplanar_orientation(a, b, at(s[k]), at(*apex)) == CGAL::POSITIVE;
        }
        return false;
    }

    const TriangleMesh& mesh_;
    std::vector<CgalPoint> points_;
};

using PartBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

PartBox box_of(const TriangleMesh& mesh, std::uint32_t f) {
    const auto& [a, b, c] = mesh.triangles[f];
    const Point low = mesh.points[a].cwiseMin(mesh.points[b]).cwiseMin(mesh.points[c]);
    const Point high = mesh.points[a].cwiseMax(mesh.points[b]).cwiseMax(mesh.points[c]);
    return {CGAL::Bbox_3(low.x(), low.y(), low.z(), high.x(), high.y(), high.z()), f};
}
// What is sorted in place: pointers are moved faster than boxes.
std::vector<const PartBox*> pointers_to(const std::vector<PartBox>& boxes) {
    std::vector<const PartBox*> pointers;
    pointers.reserve(boxes.size());
    for (const PartBox& box : boxes) pointers.push_back(&box);
    return pointers;
}

}  // namespace

Pairs crossing_pairs(const TriangleMesh& mesh) {
    const Crossings crossings(mesh);
    std::vector<PartBox> boxes;
    boxes.reserve(mesh.triangles.size());
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) boxes.push_back(box_of(mesh, f));
    std::vector<const PartBox*> all = pointers_to(boxes);
    Pairs pairs;
    CGAL::box_self_intersection_d(all.begin(), all.end(), [&](const PartBox* one, const PartBox* other) {
        const auto [f, g] = std::minmax({one->info(), other->info()});
        if (crossings.cross(f, g)) pairs.emplace_back(f, g);
    });
    std::ranges::sort(pairs);
    return pairs;
}

Pairs crossing_pairs(const TriangleMesh& mesh, const std::vector<std::uint32_t>& changed) {
    if (changed.empty()) return {};
    const Crossings crossings(mesh);
    std::vector<PartBox> some;
    some.reserve(changed.size());
    for (const std::uint32_t f : changed) some.push_back(box_of(mesh, f));
    std::vector<PartBox> boxes;
    boxes.reserve(mesh.triangles.size());
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) boxes.push_back(box_of(mesh, f));
    std::vector<const PartBox*> few = pointers_to(some);
    std::vector<const PartBox*> all = pointers_to(boxes);
    Pairs pairs;
    CGAL::box_intersection_d(few.begin(), few.end(), all.begin(), all.end(), [&](const PartBox* one, const PartBox* other) {
        const auto [f, g] = std::minmax({one->info(), other->info()});
        if (f != g && crossings.cross(f, g)) pairs.emplace_back(f, g);
    });
    std::ranges::sort(pairs);
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
}

}  // namespace palpate
