#include "sim/facet_truth.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kRounding = 1e-9;

}  // namespace

std::vector<FacetVerdict> judge_facets(const HiddenObject& object, const TriangleMesh& mesh, std::span<const Segment> dual_edges,
                                       double epsilon) {
    std::vector<FacetVerdict> verdicts;
    verdicts.reserve(dual_edges.size());
    for (std::size_t t = 0; t < dual_edges.size(); ++t) {
        const Point& corner = mesh.points[mesh.triangles[t][0]];
        const auto& [source, target] = dual_edges[t];
        if (source == target) {
            verdicts.push_back(FacetVerdict::wrong);
            continue;
        }
        const Vector beyond = kFlip * epsilon * (target - source).normalized();
        const std::vector<Point> met = object.crossings({source - beyond, target + beyond});
        FacetVerdict verdict = FacetVerdict::wrong;
        for (const Point& at : met) {
            if ((at - corner).norm() > (1 + kRounding) * epsilon) continue;
            verdict = FacetVerdict::flip;
            if (distance_to(dual_edges[t], at) <= kRounding * epsilon) {
                verdict = FacetVerdict::right;
                break;
            }
        }
        verdicts.push_back(verdict);
    }
    return verdicts;
}

}  // namespace palpate
