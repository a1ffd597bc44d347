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

bool is_in_any(std::span<const KnownSolids::Convex> solids, const Point& p, double slack) {
    return std::ranges::any_of(solids, [&](const KnownSolids::Convex& solid) {
        return std::ranges::all_of(solid, [&](const KnownSolids::Plane& plane) { return plane.height(p) < -slack; });
    });
}

}  // namespace

KnownSolids::KnownSolids(std::vector<Convex> solids, const std::vector<Plane>& floors, double slack, Outside outside)
    : solids_(std::move(solids)), has_fixtures_(solids_.size() > outside.parts.size()), slack_(slack) {
    for (const Plane& floor : floors) buried_.push_back({floor});
    barred_ = buried_;
    for (Convex& part : outside.parts) {
        buried_.push_back(part);
        part.insert(part.end(), outside.faces.begin(), outside.faces.end());
        barred_.push_back(std::move(part));
    }
}

bool KnownSolids::contains(const Point& p) const { return is_in_any(solids_, p, slack_); }

bool KnownSolids::is_buried(const Point& p) const { return is_in_any(buried_, p, slack_); }

bool KnownSolids::is_barred(const Point& p) const { return is_in_any(barred_, p, slack_); }

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
    for (const Convex& part : barred_) {
        if (const auto below = below_all(part, move, slack_)) buried = std::min(buried, below->low);
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
