#include "sim/tool/tool_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/objects/box_mesh.h"
#include "sim/objects/triangle_tree.h"
#include "sim/tool/internal/fixture_kinds.h"
#include "sim/tool/internal/tool_parts.h"

namespace palpate {
namespace {

constexpr int kPlaces = static_cast<int>(1 / ToolDepths::kSpacing);

struct GrownTree {
    TriangleTree tree;
    double by;  // mm
};

// What an axis is measured against. No trees: nothing but points is asked for.
struct ObjectSolid {
    const HiddenObject& object;
    std::vector<GrownTree> trees;

    // Below 0: as deep as the axis is at least.
    [[nodiscard]] std::optional<double> distance(const Parallelogram& swept, double within) const {
        std::optional<double> nearest;
        for (const auto& [tree, by] : trees) {
            if (const auto gap = tree.distance(swept, within + by)) nearest = std::min(nearest.value_or(within), *gap - by);
        }
        if (!trees.empty()) return nearest;
        // A point on its way along v.
        if (swept.v.isZero(0)) return std::nullopt;
        return object.crossings({swept.corner, swept.corner + swept.v}).empty() ? std::nullopt : std::optional(0.0);
    }
    [[nodiscard]] double inner(const Point& p) const { return object.depth(p); }
};

struct BoxSolid {
    Box box;
    std::vector<std::array<Point, 3>> faces;

    explicit BoxSolid(const Box& b) : box(b) {
        TriangleMesh mesh;
        append_box(mesh, box);
        for (const auto& [i, j, k] : mesh.triangles) faces.push_back({mesh.points[i], mesh.points[j], mesh.points[k]});
    }
    [[nodiscard]] std::optional<double> distance(const Parallelogram& swept, double within) const {
        double nearest = within;
        bool is_within = false;
        for (const auto& face : faces) {
            const double gap = palpate::distance(swept, face);
            if (gap > nearest) continue;
            nearest = gap;
            is_within = true;
        }
        return is_within ? std::optional(nearest) : std::nullopt;
    }
    [[nodiscard]] double inner(const Point& p) const { return std::max(0.0, std::min((p - box.min).minCoeff(), (box.max - p).minCoeff())); }
};

Parallelogram axis_at(const ToolPart& part, const Point& p) { return {p + part.offset, part.capsule.core, Vector::Zero()}; }

// Of a part at a place.
template <typename Solid>
double depth_at(const ToolPart& part, const Solid& solid, const Point& p) {
    const Parallelogram axis = axis_at(part, p);
    const double radius = part.capsule.radius;
    const std::optional<double> gap = solid.distance(axis, radius);
    double depth = gap ? radius - *gap : 0.0;
    const bool enters = gap && *gap <= 0.0;
    if (!enters && solid.inner(axis.corner) == 0.0) return depth;  // all of the axis is outside
    const int places = axis.u.isZero(0) ? 0 : kPlaces;
    for (int k = 0; k <= places; ++k) {
        const double inner = solid.inner(axis.at(places == 0 ? 0.0 : static_cast<double>(k) / places, 0));
        if (inner > 0) depth = std::max(depth, radius + inner);
    }
    return depth;
}

template <typename Solid>
double depth_along(const ToolPart& part, const Solid& solid, const Segment& move) {
    const Parallelogram swept{move.source + part.offset, part.capsule.core, move.target - move.source};
    const double radius = part.capsule.radius;
    const std::optional<double> gap = solid.distance(swept, radius);
    const bool enters = gap && *gap <= 0.0;
    if (!enters && solid.inner(swept.corner) == 0.0) return gap ? radius - *gap : 0.0;
    double depth = gap ? radius - *gap : 0.0;
    for (int k = 0; k <= kPlaces; ++k) {
        depth = std::max(depth, depth_at(part, solid, move.source + static_cast<double>(k) / kPlaces * (move.target - move.source)));
    }
    return depth;
}

double depth_in_half_space(const ToolPart& part, const HalfSpace& half, const Segment& move) {
    const double offset = half.normal.dot(part.offset - half.point) + std::min(0.0, half.normal.dot(part.capsule.core));
    const double lowest = std::min(half.normal.dot(move.source), half.normal.dot(move.target)) + offset;
    return std::max(0.0, part.capsule.radius - lowest);
}

}  // namespace

struct ToolDepths::Impl {
    ObjectSolid object;
    std::vector<BoxSolid> boxes;
    std::vector<HalfSpace> half_spaces;
    std::vector<ToolPart> parts;
    bool is_point = false;

    template <typename DepthIn>
    [[nodiscard]] static ToolDepth deepest(const std::vector<ToolPart>& parts, const DepthIn& depth_in) {
        ToolDepth depth;
        for (const ToolPart& part : parts) {
            const ToolDepth one = depth_in(part);
            depth = {std::max(depth.object, one.object), std::max(depth.fixture, one.fixture)};
        }
        return depth;
    }
    [[nodiscard]] ToolDepth along(const ToolPart& part, const Segment& move) const {
        ToolDepth depth{depth_along(part, object, move), 0.0};
        for (const BoxSolid& box : boxes) depth.fixture = std::max(depth.fixture, depth_along(part, box, move));
        for (const HalfSpace& half : half_spaces) depth.fixture = std::max(depth.fixture, depth_in_half_space(part, half, move));
        return depth;
    }
    [[nodiscard]] ToolDepth at(const ToolPart& part, const Point& p) const {
        ToolDepth depth{depth_at(part, object, p), 0.0};
        for (const BoxSolid& box : boxes) depth.fixture = std::max(depth.fixture, depth_at(part, box, p));
        for (const HalfSpace& half : half_spaces) depth.fixture = std::max(depth.fixture, depth_in_half_space(part, half, {p, p}));
        return depth;
    }
};

ToolDepths::ToolDepths(const HiddenObject& object, const std::optional<ToolShape>& tool, const std::vector<Fixture>& fixtures) {
    auto impl = std::make_unique<Impl>(Impl{{object, {}}, {}, half_spaces_of(fixtures), {}, !tool});
    if (tool) {
        for (const GrownTriangles& part : object.grown_triangles()) impl->object.trees.push_back({TriangleTree(part.triangles), part.by});
        if (impl->object.trees.empty()) throw std::invalid_argument("a tool with a body needs an object that grown triangles bound");
    }
    for (const Box& box : boxes_of(fixtures)) impl->boxes.emplace_back(box);
    impl->parts = tool ? parts_of(*tool) : std::vector<ToolPart>{ToolPart{}};
    impl_ = std::move(impl);
}

ToolDepths::~ToolDepths() = default;
ToolDepths::ToolDepths(ToolDepths&&) noexcept = default;
ToolDepths& ToolDepths::operator=(ToolDepths&&) noexcept = default;

ToolDepth ToolDepths::at(const Point& p) const {
    return Impl::deepest(impl_->parts, [&](const ToolPart& part) { return impl_->at(part, p); });
}

ToolDepth ToolDepths::along(const Segment& move) const {
    return Impl::deepest(impl_->parts, [&](const ToolPart& part) { return impl_->along(part, move); });
}

std::optional<double> ToolDepths::gap(const Point& p, double within) const {
    if (impl_->is_point) return std::nullopt;
    const auto depth_in = [&](ToolPart part) {
        part.capsule.radius += within;
        return impl_->at(part, p);
    };
    return within - Impl::deepest(impl_->parts, depth_in).deepest();
}

std::optional<ToolContact> ToolDepths::touching(const Point& p, double within) const {
    if (impl_->is_point) return std::nullopt;
    std::optional<ToolContact> touching;
    double deepest = 0.0;
    for (ToolPart part : impl_->parts) {
        part.capsule.radius += within;
        const ToolDepth depth = impl_->at(part, p);
        for (const auto& [met, deep] :
             {std::pair(ToolContact::Met::object, depth.object), std::pair(ToolContact::Met::fixture, depth.fixture)}) {
            if (deep <= deepest) continue;
            deepest = deep;
            touching = ToolContact{0.0, part.part, met};
        }
    }
    return touching;
}

}  // namespace palpate
