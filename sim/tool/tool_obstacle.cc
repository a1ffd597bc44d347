#include "sim/tool/tool_obstacle.h"

#include <algorithm>
#include <cmath>

#include "sim/objects/errors.h"
#include "sim/tool/internal/fixture_kinds.h"
#include "sim/tool/internal/tool_parts.h"
#include "sim/tool/tool_contact.h"
#include "sim/tool/tool_depth.h"

namespace palpate {
namespace {

// Where the line is in a box or a half-space, within [0, 1].
std::optional<Interval> passage_of(const Segment& s, const HalfSpace& half) {
    const double height = half.normal.dot(s.source - half.point);
    const double rise = half.normal.dot(s.target - s.source);
    if (rise == 0.0) return height < 0.0 ? std::optional(Interval{0.0, 1.0}) : std::nullopt;
    const Interval within = rise < 0.0 ? Interval{std::max(0.0, -height / rise), 1.0} : Interval{0.0, std::min(1.0, -height / rise)};
    return within.low < within.high ? std::optional(within) : std::nullopt;
}

std::optional<Interval> passage_of(const Segment& s, const Box& box) {
    Interval within{0.0, 1.0};
    for (int i = 0; i < 3; ++i) {
        for (const auto& [sign, face] : {std::pair(1.0, box.max), std::pair(-1.0, box.min)}) {
            const auto one = passage_of(s, HalfSpace{face, sign * Vector::Unit(i)});
            if (!one) return std::nullopt;
            within = {std::max(within.low, one->low), std::min(within.high, one->high)};
        }
    }
    return within.low < within.high ? std::optional(within) : std::nullopt;
}

// Where the part's position is if it meets the box.
Box grown(const Box& box, const ToolPart& part) {
    const Vector radius = Vector::Constant(part.capsule.radius);
    return {box.min - part.offset - part.capsule.core.cwiseMax(0.0) - radius,
            box.max - part.offset - part.capsule.core.cwiseMin(0.0) + radius};
}

ToolDepths depths_of(const HiddenObject& object, const std::optional<ToolShape>& tool, const std::vector<Fixture>& fixtures) {
    if (tool && object.grown_triangles().empty()) {
        throw ObjectError(
            "object: with a tool that has a body, meshes, spheres, capsules, rounded boxes and unions of these are simulated, and this "
            "shape "
            "is, or contains, an ellipsoid, a torus or a genus2; give one of those, or leave out tool");
    }
    return {object, tool, fixtures};
}

}  // namespace

struct ToolObstacle::Impl {
    const HiddenObject& object;
    std::optional<ToolShape> tool;
    std::vector<HalfSpace> half_spaces;
    std::vector<Box> boxes;
    ToolDepths depths;
    std::optional<ToolWorld> world{};  // with a tool
    Box bounds{};
    double scale = 0.0;

    // Of what a point touches: the object, or a plane of a fixture.
    [[nodiscard]] Vector normal_of_nearest(const Point& p, const Vector& direction) const {
        Vector normal = object.normal(p, direction);
        double nearest = object.distance(p);
        const auto consider = [&](const Vector& out, double gap) {
            if (gap >= nearest) return;
            nearest = gap;
            normal = out;
        };
        for (const HalfSpace& half : half_spaces) consider(half.normal, std::abs(half.normal.dot(p - half.point)));
        for (const Box& box : boxes) {
            const double beside = (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm();
            for (int i = 0; i < 3; ++i) {
                consider(Vector::Unit(i), beside + std::abs(p[i] - box.max[i]));
                consider(-Vector::Unit(i), beside + std::abs(p[i] - box.min[i]));
            }
        }
        return normal;
    }

    // Where something begins or ends along the segment, in [0, 1], in order. All changes are there; not all are changes.
    [[nodiscard]] std::vector<double> ends(const Segment& segment) const {
        std::vector<double> ends;
        const auto add = [&](const std::optional<Interval>& passage) {
            if (passage) ends.insert(ends.end(), {passage->low, passage->high});
        };
        if (world) {
            for (const Interval& contact : world->contacts(*tool, segment)) add(contact);
        } else {
            const Vector way = segment.target - segment.source;
            for (const Point& p : object.crossings(segment)) ends.push_back((p - segment.source).dot(way) / way.squaredNorm());
            for (const HalfSpace& half : half_spaces) add(passage_of(segment, half));
            for (const Box& box : boxes) add(passage_of(segment, box));
        }
        std::ranges::sort(ends);
        return ends;
    }
};

ToolObstacle::ToolObstacle(const HiddenObject& object, const std::optional<ToolShape>& tool, const std::vector<Fixture>& fixtures) {
    auto impl = std::make_unique<Impl>(Impl{object,
                                            tool,
                                            half_spaces_of(fixtures),
                                            boxes_of(fixtures),
                                            depths_of(object, tool, fixtures),
                                            {},
                                            object.bounds(),
                                            object.scale()});
    if (tool) {
        impl->world.emplace(object.grown_triangles(), impl->half_spaces, impl->boxes);
        for (const ToolPart& part : parts_of(*tool)) {
            const Box box = grown(object.bounds(), part);
            impl->bounds = {impl->bounds.min.cwiseMin(box.min), impl->bounds.max.cwiseMax(box.max)};
        }
        impl->scale += impl->bounds.diagonal() - object.bounds().diagonal();
    }
    impl_ = std::move(impl);
}

ToolObstacle::~ToolObstacle() = default;
ToolObstacle::ToolObstacle(ToolObstacle&&) noexcept = default;
ToolObstacle& ToolObstacle::operator=(ToolObstacle&&) noexcept = default;

std::optional<Point> ToolObstacle::first_hit(const Segment& segment) const {
    const bool inside = contains(segment.source);
    if (!impl_->world || inside) {
        const std::vector<Point> all = changes(segment, inside);
        return all.empty() ? std::nullopt : std::optional(all.front());
    }
    const auto contact = impl_->world->first_contact(*impl_->tool, segment);
    if (!contact) return std::nullopt;
    return segment.source + contact->at * (segment.target - segment.source);
}

std::vector<Point> ToolObstacle::crossings(const Segment& segment) const { return changes(segment, std::nullopt); }

std::vector<Point> ToolObstacle::changes(const Segment& segment, std::optional<bool> before) const {
    const Vector way = segment.target - segment.source;
    std::vector<Point> points;
    if (way.isZero(0)) return points;
    std::vector<double> ends = impl_->ends(segment);
    ends.push_back(1.0);
    double last = 0.0;
    for (const double end : ends) {
        if (end <= last) continue;
        const bool inside = contains(segment.source + 0.5 * (last + end) * way);
        if (before && *before != inside) points.emplace_back(segment.source + last * way);
        before = inside;
        last = end;
    }
    return points;
}

bool ToolObstacle::contains(const Point& p) const { return depth(p) > kRounding * impl_->scale; }

double ToolObstacle::depth(const Point& p) const { return impl_->depths.at(p).deepest(); }

Vector ToolObstacle::normal(const Point& touched, const Vector& direction) const {
    if (!impl_->world) return impl_->normal_of_nearest(touched, direction);
    // Exact at planes; elsewhere off by the square of that share.
    constexpr double kStep = 1e-4;  // of the ball's radius
    const double step = kStep * impl_->tool->ball_diameter / 2;
    const auto gap = [&](const Point& p) { return *impl_->depths.gap(p, 2 * step); };
    Vector rise;
    for (int i = 0; i < 3; ++i) rise[i] = gap(touched + step * Vector::Unit(i)) - gap(touched - step * Vector::Unit(i));
    // Touched from before and behind at once, it has none.
    return rise.norm() > step ? rise.normalized() : Vector(-direction);
}

double ToolObstacle::scale() const { return impl_->scale; }

const Box& ToolObstacle::bounds() const { return impl_->bounds; }

std::vector<Box> ToolObstacle::reachable_bounds() const {
    std::vector<Box> reachable;
    const double ball = impl_->tool ? impl_->tool->ball_diameter / 2 : 0.0;
    for (const ToolPart& part : impl_->tool ? parts_of(*impl_->tool) : std::vector<ToolPart>{ToolPart{}}) {
        Box box = grown(impl_->object.bounds(), part);
        for (const HalfSpace& half : impl_->half_spaces) {
            const double height = half.normal.dot(half.point) + ball;
            for (int i = 0; i < 3; ++i) {
                if (half.normal[i] == 1.0) box.min[i] = std::max(box.min[i], height);
                if (half.normal[i] == -1.0) box.max[i] = std::min(box.max[i], -height);
            }
        }
        if ((box.min.array() < box.max.array()).all()) reachable.push_back(box);
    }
    return reachable;
}

}  // namespace palpate
