#include "planner/surroundings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace palpate {
namespace {

// The tangent polygon around an arc is cut into pieces of at most this angle; its length exceeds the arc's by
// tan(x)/x - 1 < 0.8 % at x = kMaxArc / 2.
constexpr double kMaxArc = 0.3;  // rad

// A point is on a face of the box when it is nearer to it than this fraction of the box' diagonal: points come from
// clipping lines, so they are off by rounding only.
constexpr double kOnFace = 1e-9;

double arc_between(const Vector& u, const Vector& v) { return std::atan2(u.cross(v).norm(), u.dot(v)); }

int arc_pieces(double angle) { return std::max(1, static_cast<int>(std::ceil(angle / kMaxArc))); }

// Some unit vector orthogonal to the unit vector u, chosen by u alone.
Vector any_orthogonal(const Vector& u) {
    int axis = 0;
    u.cwiseAbs().minCoeff(&axis);
    return u.cross(Vector::Unit(axis)).normalized();
}

std::vector<Point> arc_path(const Ball& ball, const Point& from, const Point& to) {
    const Vector u = (from - ball.center).normalized();
    const Vector v = (to - ball.center).normalized();
    const double angle = arc_between(u, v);
    Vector side = v - v.dot(u) * u;
    side = side.norm() > 1e-12 ? Vector(side.normalized()) : any_orthogonal(u);
    side = (side - side.dot(u) * u).normalized();  // again: near the antipode of u the difference cancels
    const int pieces = arc_pieces(angle);
    const double piece = angle / pieces;
    const double outer_radius = ball.radius / std::cos(piece / 2);
    std::vector<Point> path;
    for (int k = 0; k < pieces; ++k) {
        const double at = (k + 0.5) * piece;
        path.emplace_back(ball.center + outer_radius * (std::cos(at) * u + std::sin(at) * side));
    }
    path.push_back(to);
    return path;
}

// A face of the box: the coordinate that is fixed, and at which end.
struct Face {
    int axis = 0;
    bool at_max = false;
};

double face_coordinate(const Box& box, const Face& face) { return face.at_max ? box.max[face.axis] : box.min[face.axis]; }

using OpenFaces = Surroundings::OpenFaces;

bool is_open(const OpenFaces& open, const Face& face) {
    return open.is_open.at(static_cast<std::size_t>(face.axis)).at(face.at_max ? 1 : 0);
}

// The open ones.
std::vector<Face> faces_at(const Box& box, const OpenFaces& open, const Point& p) {
    const double tolerance = kOnFace * (box.max - box.min).norm();
    std::vector<Face> faces;
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool at_max : {false, true}) {
            if (is_open(open, {axis, at_max}) && std::abs(p[axis] - face_coordinate(box, {axis, at_max})) <= tolerance)
                faces.push_back({axis, at_max});
        }
    }
    return faces;
}

// The straight line from `from` (on face a) to `to` (on face b, adjacent) in the unfolding of the two faces.
Point over_edge(const Box& box, const Face& a, const Face& b, const Point& from, const Point& to) {
    const int along = 3 - a.axis - b.axis;
    const double before = std::abs(from[b.axis] - face_coordinate(box, b));
    const double after = std::abs(to[a.axis] - face_coordinate(box, a));
    const double share = before + after > 0 ? before / (before + after) : 0.5;
    Point corner;
    corner[a.axis] = face_coordinate(box, a);
    corner[b.axis] = face_coordinate(box, b);
    corner[along] = from[along] + share * (to[along] - from[along]);
    return corner;
}

// From face a to the opposite face b over the face `side`, again straight in the unfolding.
std::array<Point, 2> over_side(const Box& box, const Face& a, const Face& b, const Face& side, const Point& from, const Point& to) {
    const int along = 3 - a.axis - side.axis;
    const double border = face_coordinate(box, side);
    const double before = std::abs(from[side.axis] - border);
    const double across = box.max[a.axis] - box.min[a.axis];
    const double total = before + across + std::abs(to[side.axis] - border);
    std::array<Point, 2> corners;
    for (const bool second : {false, true}) {
        Point& corner = corners.at(second ? 1 : 0);
        corner[a.axis] = face_coordinate(box, second ? b : a);
        corner[side.axis] = border;
        corner[along] = from[along] + (before + (second ? across : 0.0)) / total * (to[along] - from[along]);
    }
    return corners;
}

// Shortest over all pairs of faces that the two points lie on (an edge or corner of the box belongs to several).
std::vector<Point> box_path(const Box& box, const OpenFaces& open, const Point& from, const Point& to) {
    std::vector<Point> best;
    double best_length = std::numeric_limits<double>::infinity();
    const auto offer = [&](std::vector<Point> path) {
        if (const double length = path_length(from, path); length < best_length) {
            best_length = length;
            best = std::move(path);
        }
    };
    for (const Face& a : faces_at(box, open, from)) {
        for (const Face& b : faces_at(box, open, to)) {
            if (a.axis == b.axis && a.at_max == b.at_max) {
                offer({to});
            } else if (a.axis != b.axis) {
                offer({over_edge(box, a, b, from, to), to});
            } else {
                for (int axis = 0; axis < 3; ++axis) {
                    if (axis == a.axis) continue;
                    for (const bool at_max : {false, true}) {
                        if (!is_open(open, {axis, at_max})) continue;
                        const auto corners = over_side(box, a, b, {axis, at_max}, from, to);
                        offer({corners[0], corners[1], to});
                    }
                }
            }
        }
    }
    if (best.empty()) throw std::invalid_argument("Surroundings::path: a point is not on an open face of the box");
    return best;
}

// Any two open faces share an edge, or have a third one beside both.
bool are_joined(const OpenFaces& open) {
    const auto count = std::ranges::count_if(open.is_open, [](const auto& pair) { return pair[0] || pair[1]; });
    const bool is_pair = std::ranges::any_of(open.is_open, [](const auto& pair) { return pair[0] && pair[1]; });
    return count > 1 || (count == 1 && !is_pair);
}

}  // namespace

Surroundings::Surroundings(const Box& box, KnownSolids known, const OpenFaces& faces, const Box& reachable, bool assumes_clear,
                           std::optional<Area> area)
    : region_(box), known_(std::move(known)), faces_(faces), reachable_(reachable), assumes_clear_(assumes_clear), area_(std::move(area)) {
    if (are_joined(faces)) return;
    if (area_) {
        throw std::invalid_argument(
            "no face of the workspace leads into the area, or only two that face each other: the area has to reach up to a face from which "
            "the tool comes (its top, in most cases), and to end inside the workspace or at a fixture at one of two such faces");
    }
    throw std::invalid_argument(
        "no open face of the workspace leads out of it, or only two that face each other: a fixture closes the others");
}

bool Surroundings::is_enterable(const Point& p) const {
    const auto* box = std::get_if<Box>(&region_.shape());
    return box == nullptr || (!faces_at(*box, faces_, p).empty() && !known_.is_buried(p) && !known_.contains(p));
}

Point Surroundings::nearest_entry(const Point& p) const {
    const auto* box = std::get_if<Box>(&region_.shape());
    if (box == nullptr || !reachable_) return region_.nearest_boundary(p);
    // What lies on a closed face up to rounding is not beyond it.
    const bool is_inside = box->contains(p, kOnFace * box->diagonal());
    std::optional<Point> nearest;
    bool stays_in = false;
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool at_max : {false, true}) {
            const Face face{axis, at_max};
            const double beyond = (at_max ? 1 : -1) * (p[axis] - face_coordinate(*box, face));
            if (!is_open(faces_, face) || (!is_inside && beyond < 0)) continue;
            Point entry = p.cwiseMax(reachable_->min).cwiseMin(reachable_->max);
            entry[axis] = face_coordinate(*box, face);
            const bool stays = !area_ || !is_inside || !first_known({p, entry});
            const bool is_nearer = !nearest || (entry - p).norm() < (*nearest - p).norm();
            if (stays == stays_in ? !is_nearer : stays_in) continue;
            nearest = entry;
            stays_in = stays;
        }
    }
    if (!nearest) throw std::invalid_argument("the tool is beside a closed face of the workspace: move it above an open one first");
    return *nearest;
}

std::vector<Point> Surroundings::path(const Point& from, const Point& to) const {
    if (const auto* ball = std::get_if<Ball>(&region_.shape())) return arc_path(*ball, from, to);
    return box_path(std::get<Box>(region_.shape()), faces_, from, to);
}

Box Surroundings::bounds() const {
    if (reachable_) return *reachable_;
    if (const auto* box = std::get_if<Box>(&region_.shape())) return *box;
    const auto& ball = std::get<Ball>(region_.shape());
    const Vector outer = Vector::Constant(ball.radius / std::cos(kMaxArc / 2));
    return {ball.center - outer, ball.center + outer};
}

double Surroundings::distance(const Point& from, const Point& to) const {
    if (const auto* ball = std::get_if<Ball>(&region_.shape())) {
        const double angle = arc_between(from - ball->center, to - ball->center);
        const int pieces = arc_pieces(angle);
        return 2 * pieces * ball->radius * std::tan(angle / (2 * pieces));
    }
    return path_length(from, box_path(std::get<Box>(region_.shape()), faces_, from, to));
}

}  // namespace palpate
