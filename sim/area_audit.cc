#include "sim/area_audit.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace palpate {
namespace {

// Where the way crosses the planes of the box' faces, as shares of it.
void add_faces(std::vector<double>& shares, const Segment& move, const Box& box) {
    const Vector way = move.target - move.source;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double face : {box.min[axis], box.max[axis]}) {
            if (way[axis] != 0) shares.push_back((face - move.source[axis]) / way[axis]);
        }
    }
}

// ... and the lines through the polygon's edges, as seen along z.
void add_edges(std::vector<double>& shares, const Segment& move, const Prism& prism) {
    const Eigen::Vector2d from = move.source.head<2>();
    const Eigen::Vector2d way = (move.target - move.source).head<2>();
    for (std::size_t k = 0; k < prism.corners.size(); ++k) {
        const Eigen::Vector2d& a = prism.corners[k];
        const Eigen::Vector2d edge = prism.corners[(k + 1) % prism.corners.size()] - a;
        const double turn = way.x() * edge.y() - way.y() * edge.x();
        if (turn != 0) shares.push_back(((a - from).x() * edge.y() - (a - from).y() * edge.x()) / turn);
    }
}

}  // namespace

AreaAudit::AreaAudit(Area area, const Box& workspace, double tolerance)
    : area_(std::move(area)), workspace_(workspace), tolerance_(tolerance) {}

void AreaAudit::record(const Segment& move) {
    std::vector<double> shares{0.0, 1.0};
    add_faces(shares, move, workspace_);
    add_faces(shares, move, bounds_of(area_));
    if (const auto* prism = std::get_if<Prism>(&area_)) add_edges(shares, move, *prism);
    std::erase_if(shares, [](double share) { return !(share >= 0 && share <= 1); });
    std::ranges::sort(shares);
    // Between two of these the way is inside or outside as a whole.
    for (std::size_t k = 0; k + 1 < shares.size(); ++k) {
        const Point middle = move.source + (shares[k] + shares[k + 1]) / 2 * (move.target - move.source);
        if (workspace_.contains(middle, -tolerance_) && !is_inside(area_, middle, -tolerance_)) {
            ++moves_out_;
            return;
        }
    }
}

}  // namespace palpate
