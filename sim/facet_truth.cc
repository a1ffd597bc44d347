#include "sim/facet_truth.h"

namespace palpate {
namespace {

constexpr double kRounding = 1e-9;

FacetVerdict judge(const HiddenObject& object, const Point& corner, const Segment& dual_edge, double epsilon) {
    if (dual_edge.source == dual_edge.target) return FacetVerdict::wrong;
    const Vector beyond = kFlip * epsilon * (dual_edge.target - dual_edge.source).normalized();
    FacetVerdict verdict = FacetVerdict::wrong;
    for (const Point& met : object.crossings({dual_edge.source - beyond, dual_edge.target + beyond})) {
        if ((met - corner).norm() > (1 + kRounding) * epsilon) continue;
        if (distance_to(dual_edge, met) <= kRounding * epsilon) return FacetVerdict::right;
        verdict = FacetVerdict::flip;
    }
    return verdict;
}

}  // namespace

std::vector<FacetVerdict> judge_facets(const HiddenObject& object, const TriangleMesh& mesh, std::span<const Segment> dual_edges,
                                       double epsilon) {
    std::vector<FacetVerdict> verdicts;
    verdicts.reserve(dual_edges.size());
    for (std::size_t t = 0; t < dual_edges.size(); ++t)
        verdicts.push_back(judge(object, mesh.points[mesh.triangles[t][0]], dual_edges[t], epsilon));
    return verdicts;
}

}  // namespace palpate
