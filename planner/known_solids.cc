#include "planner/known_solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

// The part of the move that is below all planes: parameters in mm, from its start; nothing if that is not longer than the slack.
std::optional<Interval> below_all(std::span<const KnownSolids::Plane> planes, const Segment& move, double slack) {
    const double length = (move.target - move.source).norm();
    if (length == 0) return std::nullopt;
    const Vector direction = (move.target - move.source) / length;
    Interval part{0.0, length};
    for (const KnownSolids::Plane& plane : planes) {
        const double height = plane.height(move.source);
        const double rise = plane.normal.dot(direction);
        if (std::abs(rise) * length <= slack) {
            // Along the plane: on it is not below it.
            if (height >= -slack) return std::nullopt;
        } else if (rise < 0) {
            part.low = std::max(part.low, -height / rise);
        } else {
            part.high = std::min(part.high, -height / rise);
        }
    }
    if (part.high - part.low <= slack) return std::nullopt;
    return part;
}

Point point_at(const Segment& move, double at) {
    const Vector way = move.target - move.source;
    return move.source + at / way.norm() * way;
}

}  // namespace

bool KnownSolids::contains(const Point& p) const {
    return std::ranges::any_of(solids_, [&](const Convex& solid) {
        return std::ranges::all_of(solid, [&](const Plane& plane) { return plane.height(p) < -slack_; });
    });
}

bool KnownSolids::is_buried(const Point& p) const {
    return std::ranges::any_of(floors_, [&](const Plane& floor) { return floor.height(p) < -slack_; });
}

std::optional<Point> KnownSolids::first_entry(const Segment& line) const {
    double first = std::numeric_limits<double>::infinity();
    for (const Convex& solid : solids_) {
        if (const auto inside = below_all(solid, line, slack_)) first = std::min(first, inside->low);
    }
    if (!std::isfinite(first)) return std::nullopt;
    return point_at(line, first);
}

std::optional<KnownSolids::Hit> KnownSolids::first_hit(const Segment& move) const {
    double buried = std::numeric_limits<double>::infinity();
    for (const Plane& floor : floors_) {
        if (const auto below = below_all({&floor, 1}, move, slack_)) buried = std::min(buried, below->low);
    }
    const auto solid = first_entry(move);
    const double entered = solid ? (*solid - move.source).norm() : std::numeric_limits<double>::infinity();
    // On a plate's top the two are the same place.
    if (entered <= buried + slack_ && solid) return Hit{*solid, true};
    if (std::isfinite(buried)) return Hit{point_at(move, buried), false};
    return std::nullopt;
}

std::optional<Vector> KnownSolids::normal_at(const Point& p) const {
    for (const Convex& solid : solids_) {
        const Plane* on = nullptr;
        bool is_in = true;
        for (const Plane& plane : solid) {
            const double height = plane.height(p);
            is_in = is_in && height <= slack_;
            if (on == nullptr && std::abs(height) <= slack_) on = &plane;
        }
        if (is_in && on != nullptr) return on->normal;
    }
    return std::nullopt;
}

}  // namespace palpate
