#include "sim/region_fit.h"

#include <random>
#include <vector>

#include "sim/objects/crofton.h"

namespace palpate {
namespace {

constexpr double kSpare = 1.05;
constexpr double kFarAway = 1000;  // times the distance from the workspace's centre
constexpr std::size_t kSurfacePoints = 50'000;
constexpr std::uint64_t kSeed = 1;  // the answer must not depend on a session's seed

}  // namespace

Region fitting_workspace(const HiddenObject& object) { return fitting_workspace(object.bounds()); }

Region fitting_workspace(const Box& bounds) { return Region(Ball{bounds.center(), kSpare * bounds.diagonal() / 2}); }

std::optional<Point> point_outside(const HiddenObject& object, const Region& workspace) {
    const double clearance = kClearance * workspace.radius();
    const auto is_inside = [&](const Point& p) { return workspace.contains(p) && (workspace.nearest_boundary(p) - p).norm() > clearance; };
    const Box& bounds = object.bounds();
    std::vector<Point> candidates;
    bool corners_inside = true;
    for (int corner = 0; corner < 8; ++corner) {
        Point p = bounds.min;
        for (int axis = 0; axis < 3; ++axis) {
            if ((corner >> axis) & 1) p[axis] = bounds.max[axis];
        }
        corners_inside &= is_inside(p);
        candidates.push_back(p);
    }
    if (corners_inside) return std::nullopt;
    std::mt19937_64 random(kSeed);
    Point outermost = bounds.center();
    for (const Point& p : sample_surface(object, kSurfacePoints, random).points) {
        if (!is_inside(p)) return p;
        if ((p - workspace.center()).norm() > (outermost - workspace.center()).norm()) outermost = p;
    }
    candidates.push_back(outermost);
    // The point of S nearest to a far place is the outermost in that direction.
    for (const Point& p : candidates) {
        const Point tip = object.closest_point(workspace.center() + kFarAway * (p - workspace.center()));
        if (!is_inside(tip)) return tip;
    }
    return std::nullopt;
}

}  // namespace palpate
