#include "sim/objects/hidden_object.h"

#include <algorithm>
#include <cmath>

#include "sim/objects/internal/grown_shape.h"

namespace palpate {
namespace {

using Object = std::variant<Shape, MeshObject>;

Object made(const ObjectSpec& spec) {
    if (const auto* shape = std::get_if<ShapeSpec>(&spec)) return Object(std::in_place_type<Shape>, *shape);
    return Object(std::in_place_type<MeshObject>, std::get<MeshSpec>(spec));
}

}  // namespace

HiddenObject::HiddenObject(const ObjectSpec& spec) : object_(made(spec)) {
    if (const auto* shape = std::get_if<ShapeSpec>(&spec)) grown_ = grown_triangles_of(*shape);
}

std::vector<GrownTriangles> HiddenObject::grown_triangles() const {
    if (const auto* mesh = std::get_if<MeshObject>(&object_)) return {{mesh->mesh(), 0.0}};
    return grown_;
}

std::optional<Point> HiddenObject::first_hit(const Segment& segment) const {
    return std::visit([&](const auto& o) { return o.first_hit(segment); }, object_);
}

std::vector<Point> HiddenObject::crossings(const Segment& segment) const {
    return std::visit([&](const auto& o) { return o.crossings(segment); }, object_);
}

bool HiddenObject::contains(const Point& p) const {
    return std::visit([&](const auto& o) { return o.contains(p); }, object_);
}

Vector HiddenObject::normal(const Point& touched, const Vector& direction) const {
    const Point before = touched - kStandoff * scale() * direction;
    const Vector out = before - closest_point(before);
    return contains(before) || out.isZero(0) ? Vector(-direction) : out.normalized();
}

double HiddenObject::distance(const Point& p) const {
    if (const auto* shape = std::get_if<Shape>(&object_)) return std::abs(shape->signed_distance(p));
    return std::get<MeshObject>(object_).distance(p);
}

Point HiddenObject::closest_point(const Point& p) const {
    return std::visit([&](const auto& o) { return o.closest_point(p); }, object_);
}

const Box& HiddenObject::bounds() const {
    return std::visit([](const auto& o) -> const Box& { return o.bounds(); }, object_);
}

double HiddenObject::scale() const {
    const Box& box = bounds();
    return std::max(box.diagonal(), box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm());
}

int HiddenObject::euler_characteristic() const {
    return std::visit([](const auto& o) { return o.euler_characteristic(); }, object_);
}

int HiddenObject::components() const {
    return std::visit([](const auto& o) { return o.components(); }, object_);
}

std::optional<double> HiddenObject::reach() const {
    if (const auto* shape = std::get_if<Shape>(&object_)) return shape->reach();
    return std::nullopt;
}

std::optional<double> HiddenObject::area() const {
    if (const auto* mesh = std::get_if<MeshObject>(&object_)) return mesh->area();
    return std::nullopt;
}

std::vector<std::string> HiddenObject::warnings() const {
    if (const auto* mesh = std::get_if<MeshObject>(&object_)) return mesh->warnings();
    return {};
}

}  // namespace palpate
