#include "sim/objects/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "sim/objects/errors.h"
#include "sim/objects/internal/placed_part.h"
#include "sim/objects/internal/primitive.h"

namespace palpate {
namespace {

// Far above the rounding of a distance (some 1e-16 of what goes into it), far below what a test of accuracy allows.
constexpr double kTolerance = 1e-14;

// `number` is "" for the whole, "2" or "2.1" for a part.
void append_parts(const ShapeSpec& spec, const Pose& outer, const std::string& number, std::vector<PlacedPart>& out) {
    const std::string where = number.empty() ? "shape" : fmt::format("part {}", number);
    if (!spec.at.allFinite() || !spec.rotate.allFinite()) throw ObjectError(fmt::format("{}: at and rotate must be finite numbers", where));
    const Pose pose = outer * make_pose(spec.rotate, spec.at);
    if (const auto* parts = std::get_if<std::vector<ShapeSpec>>(&spec.kind)) {
        if (parts->empty()) throw ObjectError(fmt::format("{}: a union needs at least one part", where));
        const std::string prefix = number.empty() ? "" : number + ".";
        for (std::size_t i = 0; i < parts->size(); ++i) append_parts((*parts)[i], pose, fmt::format("{}{}", prefix, i + 1), out);
        return;
    }
    PlacedPart part;
    std::visit(
        [&](const auto& s) {
            if constexpr (std::is_constructible_v<Primitive, decltype(s)>) part.primitive = s;
        },
        spec.kind);
    part.name = fmt::format("{} ({})", where, name_of(part.primitive));
    require_valid(part.primitive, part.name);
    part.pose = pose;
    part.tolerance = kTolerance * (measures(part.primitive).bounding_radius + pose.translation.norm());
    out.push_back(std::move(part));
}

double checked_gap(const PlacedPart& a, const PlacedPart& b) {
    const double gap = smallest_gap(a, b);
    if (gap <= 0.0) throw ObjectError(fmt::format("{} and {} overlap or touch; place the parts of a union apart", a.name, b.name));
    return gap;
}

// Cannot be more than the gap of the solids inside.
double gap_of_boxes(const Box& a, const Box& b) { return (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(Vector::Zero()).norm(); }

Ray ray_along(const Segment& segment) {
    const Vector way = segment.target - segment.source;
    const double length = way.norm();
    return {segment.source, length > 0.0 ? Vector(way / length) : Vector(Vector::UnitX()), length};
}

}  // namespace

Shape::~Shape() = default;
Shape::Shape(Shape&&) noexcept = default;
Shape& Shape::operator=(Shape&&) noexcept = default;

Shape::Shape(const ShapeSpec& spec) : reach_(kInfinity) {
    append_parts(spec, Pose{}, "", parts_);
    bounds_ = parts_.front().bounds();
    for (const PlacedPart& part : parts_) {
        const Measures m = measures(part.primitive);
        euler_characteristic_ += m.euler_characteristic;
        reach_ = std::min({reach_, m.reach_inside, m.reach_outside});
        const Box box = part.bounds();
        bounds_ = {bounds_.min.cwiseMin(box.min), bounds_.max.cwiseMax(box.max)};
    }
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        for (std::size_t j = i + 1; j < parts_.size(); ++j) {
            const double bound = gap_of_boxes(parts_[i].bounds(), parts_[j].bounds());
            if (bound > 0.0 && 0.5 * bound >= reach_) continue;  // cannot lower the reach
            reach_ = std::min(reach_, 0.5 * checked_gap(parts_[i], parts_[j]));
        }
    }
}

// The parts are apart, so a point inside one has that one's surface nearest: the least of the signed distances is exact on both sides.
double Shape::signed_distance(const Point& p) const {
    double least = kInfinity;
    for (const PlacedPart& part : parts_) least = std::min(least, part.nearest_to(p).distance);
    return least;
}

int Shape::components() const { return static_cast<int>(parts_.size()); }

Point Shape::closest_point(const Point& p) const {
    Nearest best{kInfinity, Vector::UnitX()};
    for (const PlacedPart& part : parts_) {
        const Nearest n = part.nearest_to(p);
        if (n.distance < best.distance) best = n;
    }
    return p - best.distance * best.outward;
}

std::optional<Point> Shape::first_hit(const Segment& segment) const {
    const Ray ray = ray_along(segment);
    std::optional<double> first;
    for (const PlacedPart& part : parts_) {
        const auto t = part.first_hit(ray);
        if (t && (!first || *t < *first)) first = t;
    }
    return first ? std::optional<Point>(ray.origin + *first * ray.direction) : std::nullopt;
}

std::vector<Point> Shape::crossings(const Segment& segment) const {
    const Ray ray = ray_along(segment);
    std::vector<double> ts;
    for (const PlacedPart& part : parts_) part.append_crossings(ray, ts);
    std::ranges::sort(ts);
    std::vector<Point> points;
    points.reserve(ts.size());
    for (double t : ts) points.emplace_back(ray.origin + t * ray.direction);
    return points;
}

}  // namespace palpate
