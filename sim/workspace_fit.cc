#include "sim/workspace_fit.h"

#include <random>

#include "sim/internal/crofton.h"

namespace palpate {
namespace {

constexpr double kSpare = 1.05;
constexpr std::size_t kSurfacePoints = 50'000;
constexpr std::uint64_t kSeed = 1;  // the answer must not depend on a session's seed

}  // namespace

Workspace fitting_workspace(const HiddenObject& object) {
    return Workspace(Ball{object.bounds().center(), kSpare * object.bounds().diagonal() / 2});
}

std::optional<Point> point_outside(const HiddenObject& object, const Workspace& workspace) {
    const Bounds& bounds = object.bounds();
    bool corners_inside = true;
    for (int corner = 0; corner < 8; ++corner) {
        Point p = bounds.min;
        for (int axis = 0; axis < 3; ++axis) {
            if ((corner >> axis) & 1) p[axis] = bounds.max[axis];
        }
        corners_inside &= workspace.contains(p);
    }
    if (corners_inside) return std::nullopt;
    std::mt19937_64 random(kSeed);
    for (const Point& p : sample_surface(object, kSurfacePoints, random).points) {
        if (!workspace.contains(p)) return p;
    }
    return std::nullopt;
}

}  // namespace palpate
