#include "planner/grown_fixtures.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "planner/number_text.h"

namespace palpate {
namespace {

using Plane = KnownSolids::Plane;

// Of ε: a plate is so thick that its two sides do not disturb each other ...
constexpr double kThickness = 3.0;
// ... and ends so far inside ω that its edges are seen from outside.
constexpr double kMargin = 2.0;
// Of ω's diagonal: what is nearer to a face lies on it. Far above rounding, far below any clearance.
constexpr double kSlack = 1e-10;
// ... and by so much walls that share a face overlap there: nothing runs between them.
constexpr double kOverlap = 16 * kSlack;
// Of ε: less than that of an area is no more than the neighbourhood of its walls.
constexpr double kLeastArea = 4.0;

// A ball that moves along the tool's axis: a part of the tool.
struct Shaft {
    double begin = 0.0;  // mm from the reference point
    double end = 0.0;
    double radius = 0.0;
};

std::vector<Shaft> shafts_of(const ToolShape& tool) {
    std::vector<Shaft> shafts{{0, 0, tool.ball_diameter / 2}};
    double end = 0;
    for (const auto& shaft : {tool.stylus, tool.holder}) {
        if (!shaft) continue;
        shafts.push_back({end, end + shaft->length, shaft->diameter / 2});
        end += shaft->length;
    }
    return shafts;
}

// By how much a half-space with that outward normal grows.
double growth(const ToolShape& tool, const Vector& normal) {
    double most = 0;
    for (const Shaft& shaft : shafts_of(tool)) {
        const double along = -normal.dot(tool.axis);
        most = std::max(most, shaft.radius + std::max(shaft.begin * along, shaft.end * along));
    }
    return most;
}

double support(const Box& box, const Vector& direction) { return (direction.array() > 0).select(box.max, box.min).dot(direction); }

// The box and all that lies nearer to it than that part of the tool needs: a zonotope, as its faces are, moved out by the radius. At edges
// that is more than is needed.
KnownSolids::Convex grown(const Box& box, const Shaft& shaft, const Vector& axis, double clearance) {
    KnownSolids::Convex solid;
    const auto add = [&](const Vector& normal) {
        const double along = -normal.dot(axis);
        const double swept = std::max(shaft.begin * along, shaft.end * along);
        solid.push_back({normal, support(box, normal) + swept + shaft.radius + clearance});
    };
    for (int i = 0; i < 3; ++i) {
        add(Vector::Unit(i));
        add(-Vector::Unit(i));
    }
    if (shaft.end == shaft.begin) return solid;
    for (int i = 0; i < 3; ++i) {
        const Vector normal = Vector::Unit(i).cross(axis);
        constexpr double kParallel = 1e-9;
        if (normal.norm() < kParallel || normal.cwiseAbs().maxCoeff() > (1 - kParallel) * normal.norm()) continue;  // one of those above
        add(normal.normalized());
        add(-normal.normalized());
    }
    return solid;
}

// Of a grown box, whose faces along the axes come first, max before min.
Box extent_of(const KnownSolids::Convex& solid) {
    Box extent;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis) * 2;
        extent.max[axis] = solid[at].offset;
        extent.min[axis] = -solid[at + 1].offset;
    }
    return extent;
}

std::optional<HalfSpace> half_space_of(const Fixture& fixture) {
    if (const auto* table = std::get_if<Table>(&fixture)) return HalfSpace{{0, 0, table->z}, Vector::UnitZ()};
    if (const auto* half_space = std::get_if<HalfSpace>(&fixture)) return *half_space;
    return std::nullopt;
}

// The face of a box that a direction points to most.
struct BoxFace {
    int axis = 0;
    bool at_max = false;
};

BoxFace side_towards(const Vector& direction) {
    BoxFace side;
    direction.cwiseAbs().maxCoeff(&side.axis);
    side.at_max = direction[side.axis] > 0;
    return side;
}

Point corner(const Box& box, unsigned k) {
    return {(k & 1U ? box.max : box.min).x(), (k & 2U ? box.max : box.min).y(), (k & 4U ? box.max : box.min).z()};
}

// The coordinates along the side's axis at which the plane passes the box' four edges along it: least and greatest.
Interval heights_of(const Plane& plane, const Box& box, const BoxFace& side) {
    Interval heights{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (unsigned k = 0; k < 8; ++k) {
        Point p = corner(box, k);
        p[side.axis] -= plane.height(p) / plane.normal[side.axis];
        heights.low = std::min(heights.low, p[side.axis]);
        heights.high = std::max(heights.high, p[side.axis]);
    }
    return heights;
}

void add_box(KnownSolids::Convex& solid, const Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
        solid.push_back({Vector::Unit(axis), box.max[axis]});
        solid.push_back({-Vector::Unit(axis), -box.min[axis]});
    }
}

bool meet(const Box& a, const Box& b) { return (a.min.array() < b.max.array()).all() && (a.max.array() > b.min.array()).all(); }

// What the area has of the workspace, and on which sides it ends inside.
struct Cut {
    Box box;
    std::array<std::array<bool, 2>, 3> ends_inside{};

    [[nodiscard]] bool ends_at(const BoxFace& side) const {
        return ends_inside.at(static_cast<std::size_t>(side.axis)).at(side.at_max ? 1 : 0);
    }
};

Cut cut_by(const Area& area, const Box& workspace, double epsilon) {
    const Box bounds = bounds_of(area);
    Cut cut{{workspace.min.cwiseMax(bounds.min), workspace.max.cwiseMin(bounds.max)}};
    const double slack = kSlack * workspace.diagonal();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        cut.ends_inside[axis] = {bounds.min[k] > workspace.min[k] + slack, bounds.max[k] < workspace.max[k] - slack};
    }
    const Vector size = cut.box.max - cut.box.min;
    if (size.minCoeff() <= 0) {
        throw std::invalid_argument(fmt::format("the area, {} to {}, lies outside the workspace, {} to {}: nothing can be probed",
                                                point_text(bounds.min), point_text(bounds.max), point_text(workspace.min),
                                                point_text(workspace.max)));
    }
    if (size.minCoeff() < kLeastArea * epsilon) {
        throw std::invalid_argument(
            fmt::format("the area has {:.6g} x {:.6g} x {:.6g} mm of the workspace, less than {:g} epsilon on a side: "
                        "make it larger, or epsilon smaller",
                        size.x(), size.y(), size.z(), kLeastArea));
    }
    return cut;
}

// Of the faces that lead out of ω.
KnownSolids::Convex open_faces(const Box& omega, const Surroundings::OpenFaces& faces) {
    KnownSolids::Convex planes;
    for (int axis = 0; axis < 3; ++axis) {
        const auto& [at_min, at_max] = faces.is_open.at(static_cast<std::size_t>(axis));
        if (at_max) planes.push_back({Vector::Unit(axis), omega.max[axis]});
        if (at_min) planes.push_back({-Vector::Unit(axis), -omega.min[axis]});
    }
    return planes;
}

}  // namespace

Surroundings surroundings_with(const Box& whole, const Fixtures& fixtures, const ToolShape& tool, double clearance, double epsilon,
                               const std::optional<Area>& area) {
    const Cut cut = area ? cut_by(*area, whole, epsilon) : Cut{whole};
    const Box& workspace = cut.box;
    const char* const what = area ? "area" : "workspace";
    Box omega = workspace;
    Box reachable = workspace;
    Surroundings::OpenFaces faces;
    const auto close = [&](const BoxFace& side) { faces.is_open.at(static_cast<std::size_t>(side.axis)).at(side.at_max ? 1 : 0) = false; };
    const double away = (kThickness + kMargin) * epsilon;
    std::vector<Plane> floors;
    for (const Fixture& fixture : fixtures.solids) {
        const auto half_space = half_space_of(fixture);
        if (!half_space) continue;
        const Vector normal = half_space->normal.normalized();
        const Plane plane{normal, normal.dot(half_space->point) + growth(tool, normal) + clearance};
        if (support(workspace, normal) <= plane.offset) {
            throw std::invalid_argument(fmt::format(
                "the {} lies below a table or behind a half-space, grown by the tool, as a whole: nothing can be probed", what));
        }
        const BoxFace side = side_towards(-normal);
        // Behind the area's own wall.
        if (cut.ends_at(side) && -support(workspace, -normal) >= plane.offset) continue;
        floors.push_back(plane);
        const Interval heights = heights_of(plane, workspace, side);
        // Where several bound it on one side, down to the lowest.
        const bool is_first = faces.is_open.at(static_cast<std::size_t>(side.axis)).at(side.at_max ? 1 : 0);
        close(side);
        const auto reach_to = [&](double& end, double to) { end = is_first ? to : side.at_max ? std::max(end, to) : std::min(end, to); };
        if (side.at_max) {
            reach_to(omega.max[side.axis], heights.high + away);
            reach_to(reachable.max[side.axis], heights.high);
        } else {
            reach_to(omega.min[side.axis], heights.low - away);
            reach_to(reachable.min[side.axis], heights.low);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (cut.ends_at({axis, false})) {
            close({axis, false});
            reachable.min[axis] = std::max(reachable.min[axis], workspace.min[axis]);
            omega.min[axis] = reachable.min[axis] - away;
        }
        if (cut.ends_at({axis, true})) {
            close({axis, true});
            reachable.max[axis] = std::min(reachable.max[axis], workspace.max[axis]);
            omega.max[axis] = reachable.max[axis] + away;
        }
    }
    const Vector margin = Vector::Constant(kMargin * epsilon);
    const Box inner{omega.min + margin, omega.max - margin};
    if (!inner.is_valid()) throw std::invalid_argument(fmt::format("the {} is too small for this epsilon", what));
    std::vector<KnownSolids::Convex> solids;
    for (const Plane& floor : floors) {
        solids.push_back({floor});
        add_box(solids.back(), inner);
    }
    for (const Fixture& fixture : fixtures.solids) {
        const auto* box = std::get_if<Box>(&fixture);
        if (box == nullptr) continue;
        for (const Shaft& shaft : shafts_of(tool)) {
            KnownSolids::Convex solid = grown(*box, shaft, tool.axis.normalized(), clearance);
            const Box extent = extent_of(solid);
            if (extent.contains(workspace))
                throw std::invalid_argument(fmt::format("the {} lies within a fixture, grown by the tool: nothing can be probed", what));
            if (!meet(extent, area ? reachable : omega)) continue;
            for (int axis = 0; axis < 3; ++axis) {
                if (extent.max[axis] > inner.max[axis]) close({axis, true});
                if (extent.min[axis] < inner.min[axis]) close({axis, false});
            }
            add_box(solid, inner);
            solids.push_back(std::move(solid));
        }
    }
    const double slack = kSlack * omega.diagonal();
    KnownSolids::Outside outside;
    if (area) {
        outside.parts = outside_of(*area, kOverlap * omega.diagonal());
        // What bounds the area beyond the workspace is no wall.
        std::erase_if(outside.parts, [&](const KnownSolids::Convex& part) {
            return part.size() == 1 && support(whole, -part.front().normal) + part.front().offset <= slack;
        });
        outside.faces = open_faces(omega, faces);
        for (const KnownSolids::Convex& part : outside.parts) {
            solids.push_back(part);
            add_box(solids.back(), inner);
        }
    }
    return {omega, KnownSolids(std::move(solids), floors, slack, std::move(outside)), faces, reachable, fixtures.assume_clear, area};
}

}  // namespace palpate
