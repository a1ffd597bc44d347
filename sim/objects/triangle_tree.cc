#include "sim/objects/triangle_tree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_rational.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "sim/objects/internal/cgal_points.h"

namespace palpate {
namespace {

using Kernel = ExactPredicates;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Point from_cgal(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

// Exact. Most triangles that a box lets through are settled by orientations, which CGAL filters without exceptions; where a corner or an
// end is in the way exactly, its general test decides.
bool do_meet(const Kernel::Segment_3& s, const Kernel::Triangle_3& t) {
    const CGAL::Orientation source = CGAL::orientation(t[0], t[1], t[2], s.source());
    const CGAL::Orientation target = CGAL::orientation(t[0], t[1], t[2], s.target());
    if (source == target && source != CGAL::COPLANAR) return false;
    if (source != CGAL::COPLANAR && target != CGAL::COPLANAR) {
        // The line passes through the triangle if it has all edges on the same side, or meets them.
        const auto side = [&](int i) { return CGAL::orientation(s.source(), s.target(), t[i], t[(i + 1) % 3]); };
        const std::array<CGAL::Orientation, 3> sides{side(0), side(1), side(2)};
        const auto has = [&](CGAL::Orientation o) { return std::ranges::find(sides, o) != sides.end(); };
        return !(has(CGAL::POSITIVE) && has(CGAL::NEGATIVE));
    }
    return Kernel().do_intersect_3_object()(s, t);
}

// Parameter in [0, 1] along s, whose line meets the triangle's plane; nothing if the line is parallel to it.
std::optional<double> exact_parameter(const Kernel::Segment_3& s, const Kernel::Triangle_3& t) {
    using Number = CGAL::Exact_rational;
    using Exact = std::array<Number, 3>;
    const auto difference = [](const Kernel::Point_3& to, const Kernel::Point_3& from) {
        return Exact{Number(to.x()) - Number(from.x()), Number(to.y()) - Number(from.y()), Number(to.z()) - Number(from.z())};
    };
    const auto dot = [](const Exact& u, const Exact& v) { return Number(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]); };
    const Exact u = difference(t[1], t[0]);
    const Exact v = difference(t[2], t[0]);
    const Exact normal{Number(u[1] * v[2] - u[2] * v[1]), Number(u[2] * v[0] - u[0] * v[2]), Number(u[0] * v[1] - u[1] * v[0])};
    const Number denominator = dot(normal, difference(s.target(), s.source()));
    if (denominator == 0) return std::nullopt;
    return CGAL::to_double(Number(dot(normal, difference(t[0], s.source())) / denominator));
}

// Parameter along s of its first point in the triangle, given that they meet.
std::optional<double> parameter(const Kernel::Segment_3& s, const Kernel::Triangle_3& t) {
    // Below this share of the product of the vectors' lengths, the determinant has lost more than a digit and a half to rounding.
    constexpr double kWellConditioned = 0.03;
    const Vector d = from_cgal(s.target()) - from_cgal(s.source());
    const Vector u = from_cgal(t[1]) - from_cgal(t[0]);
    const Vector v = from_cgal(t[2]) - from_cgal(t[0]);
    const Vector normal = u.cross(v);
    const double denominator = normal.dot(d);
    std::optional<double> result;
    if (denominator * denominator > kWellConditioned * kWellConditioned * u.squaredNorm() * v.squaredNorm() * d.squaredNorm()) {
        result = normal.dot(from_cgal(t[0]) - from_cgal(s.source())) / denominator;
    } else {
        result = exact_parameter(s, t);
    }
    if (result) return std::clamp(*result, 0.0, 1.0);
    if (Kernel().do_intersect_3_object()(t, s.source())) return 0.0;
    if (Kernel().do_intersect_3_object()(t, s.target())) return 1.0;
    return std::nullopt;
}

// Where the segment is in the box, up to the parameter `latest`. Never misses one: differences and quotients of doubles have
// relative errors of 1e-16, so all parameters that matter, between 0 and 1, are known to a few times that.
std::optional<Interval> passage_of(const Point& source, const Vector& way, double latest, const Point& min, const Point& max) {
    constexpr double kSlack = 1e-14;
    double enter = 0.0;
    double leave = latest;
    for (int i = 0; i < 3; ++i) {
        const double low = min[i] - source[i];
        const double high = max[i] - source[i];
        if (way[i] == 0.0) {
            if (low > 0.0 || high < 0.0) return std::nullopt;
            continue;
        }
        const double a = low / way[i];
        const double b = high / way[i];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    if (enter > leave + kSlack) return std::nullopt;
    return Interval{enter, leave};
}

std::optional<double> entry_of(const Point& source, const Vector& way, double latest, const Point& min, const Point& max) {
    const auto passage = passage_of(source, way, latest, min, max);
    return passage ? std::optional(passage->low) : std::nullopt;
}

// What CGAL's tree traversal calls back: collects parameters of hits, all of them or only the least.
class Collector {
public:
    using Node = CGAL::AABB_node<Tree::AABB_traits>;

    Collector(const Kernel::Segment_3& s, bool only_first)
        : only_first_(only_first), source_(from_cgal(s.source())), way_(from_cgal(s.target()) - source_) {}

    [[nodiscard]] static bool go_further() { return true; }

    void intersection(const Kernel::Segment_3& s, const Primitive& primitive) {
        const Kernel::Triangle_3& triangle = *primitive.id();
        if (!do_meet(s, triangle)) return;
        const auto t = parameter(s, triangle);
        if (!t) return;
        if (only_first_) {
            if (hits_.empty()) hits_.push_back(*t);
            hits_.front() = std::min(hits_.front(), *t);
        } else {
            hits_.push_back(*t);
        }
    }

    using Priority = double;
    // Nearer boxes first: they may rule out the others.
    [[nodiscard]] std::pair<bool, Priority> do_intersect_with_priority(const Kernel::Segment_3&, const Node& node) const {
        const auto entry = entry_into(node.bbox());
        return {entry.has_value(), entry ? -*entry : 0.0};
    }
    [[nodiscard]] bool do_intersect(const Kernel::Segment_3&, const Node& node) const { return entry_into(node.bbox()).has_value(); }

    [[nodiscard]] std::vector<double> take() {
        std::ranges::sort(hits_);
        return std::move(hits_);
    }

private:
    [[nodiscard]] std::optional<double> entry_into(const CGAL::Bbox_3& box) const {
        return entry_of(source_, way_, only_first_ && !hits_.empty() ? hits_.front() : 1.0, Point(box.xmin(), box.ymin(), box.zmin()),
                        Point(box.xmax(), box.ymax(), box.zmax()));
    }

    bool only_first_;
    Point source_;
    Vector way_;
    std::vector<double> hits_;
};

std::array<Point, 3> corners_of(const Kernel::Triangle_3& t) { return {from_cgal(t[0]), from_cgal(t[1]), from_cgal(t[2])}; }

// By how much boxes grow for a capsule to meet one where its position is in it.
struct Growth {
    explicit Growth(const Capsule& capsule)
        : below(capsule.core.cwiseMax(0.0) + Vector::Constant(capsule.radius * kRounding)),
          above((-capsule.core).cwiseMax(0.0) + Vector::Constant(capsule.radius * kRounding)) {}

    static constexpr double kRounding = 1 + 1e-9;
    Vector below;
    Vector above;
};

// The same for a capsule that moves: only the first contact.
class ContactFinder {
public:
    using Node = CGAL::AABB_node<Tree::AABB_traits>;
    using Priority = double;

    ContactFinder(const Capsule& capsule, const Segment& move) : capsule_(capsule), move_(move), growth_(capsule) {}

    [[nodiscard]] static bool go_further() { return true; }
    void intersection(const Kernel::Segment_3&, const Primitive& primitive) {
        const auto at = palpate::first_contact(corners_of(*primitive.id()), capsule_, move_);
        if (at && (!first_ || *at < *first_)) first_ = at;
    }
    [[nodiscard]] std::pair<bool, Priority> do_intersect_with_priority(const Kernel::Segment_3&, const Node& node) const {
        const CGAL::Bbox_3 box = node.bbox();
        const auto entry =
            entry_of(move_.source, move_.target - move_.source, first_.value_or(1.0),
                     Point(box.xmin(), box.ymin(), box.zmin()) - growth_.below, Point(box.xmax(), box.ymax(), box.zmax()) + growth_.above);
        return {entry.has_value(), entry ? -*entry : 0.0};
    }
    [[nodiscard]] bool do_intersect(const Kernel::Segment_3& s, const Node& node) const {
        return do_intersect_with_priority(s, node).first;
    }
    [[nodiscard]] std::optional<double> first() const { return first_; }

private:
    const Capsule& capsule_;
    const Segment& move_;
    const Growth growth_;
    std::optional<double> first_;
};

// All contacts of a capsule that moves: a grown triangle is convex, so there is one interval of each. What lies where others do already is
// passed over.
class AllContactsFinder {
public:
    using Node = CGAL::AABB_node<Tree::AABB_traits>;

    AllContactsFinder(const Capsule& capsule, const Segment& move, Cover& cover)
        : capsule_(capsule), move_(move), back_{move.target, move.source}, growth_(capsule), cover_(cover) {}

    [[nodiscard]] static bool go_further() { return true; }
    void intersection(const Kernel::Segment_3&, const Primitive& primitive) {
        const std::array<Point, 3> triangle = corners_of(*primitive.id());
        const auto enter = palpate::first_contact(triangle, capsule_, move_);
        if (!enter) return;
        const auto leave = palpate::first_contact(triangle, capsule_, back_);
        if (leave && *enter < 1 - *leave) cover_.add({*enter, 1 - *leave});
    }
    [[nodiscard]] bool do_intersect(const Kernel::Segment_3&, const Node& node) const {
        const CGAL::Bbox_3 box = node.bbox();
        const auto passage =
            passage_of(move_.source, back_.source - move_.source, 1.0, Point(box.xmin(), box.ymin(), box.zmin()) - growth_.below,
                       Point(box.xmax(), box.ymax(), box.zmax()) + growth_.above);
        return passage && !cover_.contains(*passage);
    }

private:
    const Capsule& capsule_;
    const Segment& move_;
    const Segment back_;
    const Growth growth_;
    Cover& cover_;
};

// The least distance from triangles.
class DistanceFinder {
public:
    using Node = CGAL::AABB_node<Tree::AABB_traits>;

    DistanceFinder(const Parallelogram& swept, double within) : swept_(swept), centre_(swept.at(0.5, 0.5)), within_(within) {
        axes_.reserve(10);
        for (int i = 0; i < 3; ++i) axes_.push_back(axis(Vector::Unit(i)));
        axes_.push_back(axis(swept.u.cross(swept.v)));
        for (int i = 0; i < 3; ++i) {
            axes_.push_back(axis(Vector::Unit(i).cross(swept.u)));
            axes_.push_back(axis(Vector::Unit(i).cross(swept.v)));
        }
    }

    [[nodiscard]] bool go_further() const { return !found_ || *found_ > 0; }
    void intersection(const Parallelogram&, const Primitive& primitive) {
        const double distance = palpate::distance(swept_, corners_of(*primitive.id()));
        if (distance > within_) return;
        found_ = within_ = distance;
    }
    // No plane across one of the axes separates the box, grown by what is nearest so far, from the parallelogram.
    [[nodiscard]] bool do_intersect(const Parallelogram&, const Node& node) const {
        constexpr double kRounding = 1 + 1e-9;
        const CGAL::Bbox_3 box = node.bbox();
        const Point min(box.xmin(), box.ymin(), box.zmin());
        const Point max(box.xmax(), box.ymax(), box.zmax());
        const Vector between = 0.5 * (min + max) - centre_;
        const Vector half = kRounding * (0.5 * (max - min) + Vector::Constant(within_));
        const double rounding = (kRounding - 1) * (min.cwiseAbs() + max.cwiseAbs()).sum() * 1e-5;
        return std::ranges::all_of(axes_, [&](const Axis& a) {
            return std::abs(a.direction.dot(between)) <= a.direction.cwiseAbs().dot(half) + a.extent + rounding * a.length;
        });
    }
    [[nodiscard]] std::optional<double> found() const { return found_; }

private:
    struct Axis {
        Vector direction;
        double extent;  // of the parallelogram, half of it
        double length;
    };
    [[nodiscard]] Axis axis(const Vector& d) const {
        return {d, 0.5 * (std::abs(d.dot(swept_.u)) + std::abs(d.dot(swept_.v))) * (1 + 1e-9), d.norm()};
    }

    const Parallelogram& swept_;
    Point centre_;
    double within_;
    std::vector<Axis> axes_;
    std::optional<double> found_;
};

}  // namespace

struct TriangleTree::Impl {
    Triangles triangles;
    Tree tree;
    double extent = 0.0;  // mm: largest coordinate

    [[nodiscard]] std::vector<double> hits(const Segment& segment, bool only_first) const {
        const Kernel::Segment_3 query(to_cgal(segment.source), to_cgal(segment.target));
        if (query.is_degenerate()) {
            const Kernel::Point_3 p = query.source();
            return tree.do_intersect(p) ? std::vector<double>{0.0} : std::vector<double>{};
        }
        Collector collector(query, only_first);
        if (only_first) {
            tree.traversal_with_priority(query, collector);
        } else {
            tree.traversal(query, collector);
        }
        return collector.take();
    }
};

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
    assert(!mesh.triangles.empty());
    auto impl = std::make_unique<Impl>();
    impl->triangles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        assert(std::max({a, b, c}) < mesh.points.size());
        impl->triangles.emplace_back(to_cgal(mesh.points[a]), to_cgal(mesh.points[b]), to_cgal(mesh.points[c]));
        for (auto i : {a, b, c}) impl->extent = std::max(impl->extent, mesh.points[i].cwiseAbs().maxCoeff());
    }
    impl->tree.insert(impl->triangles.cbegin(), impl->triangles.cend());
    impl->tree.build();  // now, not at the first query: queries of several threads must not change anything
    impl->tree.accelerate_distance_queries();
    impl_ = std::move(impl);
}

TriangleTree::~TriangleTree() = default;
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;
TriangleTree& TriangleTree::operator=(TriangleTree&&) noexcept = default;

std::optional<Point> TriangleTree::first_hit(const Segment& segment) const {
    const std::vector<double> hits = impl_->hits(segment, true);
    if (hits.empty()) return std::nullopt;
    return segment.source + hits.front() * (segment.target - segment.source);
}

std::vector<Point> TriangleTree::crossings(const Segment& segment) const {
    // Well above the rounding of a hit (about 1e-16 / kWellConditioned of the coordinates that go into it).
    constexpr double kSame = 1e-13;
    const double same = kSame * std::max({impl_->extent, segment.source.cwiseAbs().maxCoeff(), segment.target.cwiseAbs().maxCoeff()});
    std::vector<Point> points;
    for (double t : impl_->hits(segment, false)) {
        const Point p = segment.source + t * (segment.target - segment.source);
        if (points.empty() || (p - points.back()).norm() > same) points.push_back(p);
    }
    return points;
}

std::optional<double> TriangleTree::first_contact(const Capsule& capsule, const Segment& move) const {
    ContactFinder finder(capsule, move);
    impl_->tree.traversal_with_priority(Kernel::Segment_3(to_cgal(move.source), to_cgal(move.target)), finder);
    return finder.first();
}

void TriangleTree::add_contacts(const Capsule& capsule, const Segment& move, Cover& cover) const {
    AllContactsFinder finder(capsule, move, cover);
    impl_->tree.traversal(Kernel::Segment_3(to_cgal(move.source), to_cgal(move.target)), finder);
}

std::optional<double> TriangleTree::distance(const Parallelogram& swept, double within) const {
    DistanceFinder finder(swept, within);
    impl_->tree.traversal(swept, finder);
    return finder.found();
}

Point TriangleTree::closest_point(const Point& p) const { return from_cgal(impl_->tree.closest_point(to_cgal(p))); }

}  // namespace palpate
