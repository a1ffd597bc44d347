#include "planner/part/internal/shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "planner/part/internal/facet_fans.h"
#include "planner/part/internal/facet_tree.h"

namespace palpate {
namespace {

// Radii that differ by less than that many touch errors cannot be told apart.
constexpr double kToldApart = 4;
// Of what counts as touched: amid shadows this still does.
constexpr double kNearly = 3;
// The normal along the axis, as a cosine: less is the side of a rod.
constexpr double kSide = 0.2;
// How far off a place is at most, over how far it mostly is.
constexpr double kTypical = 8;
// Of the difference of the radii: what the rod may seem to lack to what it touches, for facets that are not the surface.
constexpr double kTouches = 0.03;
// rad: where S* has a normal that differs so much from the shank's, and no crease beside it, the ball touched.
constexpr double kOtherSide = 0.6;

// Of the difference of the radii: a way straight up that is so far beside a wall meets S* if the rod touched. Nearer it meets facets, too.
constexpr double kBeside = 0.9;
constexpr double kClearlyBeside = 0.5;
// ... and nearer where ε is more than that, over the difference: facets cut off more.
constexpr double kCoarse = 3;
// ... and so near where half of what is around is none of the ball's.
constexpr double kAmidBeside = 0.7;
// Of what normals that are off say of a facet's bulge: by so much S* may lie outside of that for what is ambiguous, and for a shadow.
constexpr double kTrust = 2.5;
constexpr double kClearTrust = 0;
// Of the difference of the radii: so deep the ball is not below what it touched itself, unless it rolled as far below as it could.
constexpr double kDeep = 0.95;
// Of the distance from a wall's place: so far off it is still the wall.
constexpr double kOnWall = 0.1;
// Of the corners around, fixtures apart.
constexpr double kAmid = 2.0 / 3;
constexpr double kHalf = 0.5;
constexpr double kAmidCreased = 0.75;
// rad: normals are not farther off.
constexpr double kMostOff = 0.5;
// The normal along the axis, as a cosine: a wall, straight up.
constexpr double kWall = 0.01;

// A round rod of the tool as seen from the ball's centre: from `from` to `to` along the axis.
struct Rod {
    double radius = 0.0;
    double from = 0.0;
    double to = 0.0;
};

// mm: a line that is nearer to a facet than that passes through it.
constexpr double kMeets = 1e-9;

enum class State : std::uint8_t { unknown, seen, hidden };

// The touched surface as far as it is known, in a frame whose z axis is the tool's: from the top down.
class ShadowTest {
public:
    ShadowTest(const TriangleMesh& surface, const std::vector<Vector>& normals, const std::vector<double>& uncertainty, double noise)
        : surface_(surface), normals_(normals), uncertainty_(uncertainty), noise_(noise), tree_(surface), state_(surface.points.size()) {}

    void set(std::uint32_t v, State state) { state_[v] = state; }

    struct Explanation {
        double gap = 0.0;        // mm: from the rod's surface to what it touches; negative if that is inside
        double tolerance = 0.0;  // mm: of that
        Vector normal;           // of the rod's surface there, into the rod
    };
    // How the rod explains a touch with the ball at `centre`; nothing if it is far off what is known.
    [[nodiscard]] std::optional<Explanation> explain(const Point& centre, const Rod& rod, double within) const {
        const Segment axis{centre + rod.from * Vector::UnitZ(), centre + rod.to * Vector::UnitZ()};
        // A facet is flat, the surface bulges above it, and either may be off.
        Explanation best{std::numeric_limits<double>::infinity(), 0, Vector::UnitX()};
        tree_.near(axis, rod.radius + within, [&](const FacetPlace& place) {
            const auto& corners = surface_.triangles[place.facet];
            if (!std::ranges::all_of(corners, [&](std::uint32_t v) { return state_[v] == State::seen; })) return;
            double height = 0;
            double off = 0;
            for (Eigen::Index k = 0; k < 3; ++k) {
                const std::uint32_t a = corners[static_cast<std::size_t>(k)];
                const std::uint32_t b = corners[static_cast<std::size_t>((k + 1) % 3)];
                const double rise = bulge(surface_.points[a], normals_[a], surface_.points[b], normals_[b]);
                height += place.share[k] * place.share[(k + 1) % 3] * rise;
                off = std::max({off, noise_ + (uncertainty_[a] - noise_) / kTypical, noise_ + std::abs(rise) / 8});
            }
            const double gap = place.distance - height - rod.radius;
            if (gap >= best.gap) return;
            const Point foot = nearest_on(axis, place.point);
            best = {gap, noise_ / 2 + off, (foot - place.point).normalized()};
        });
        return std::isfinite(best.gap) ? std::optional(best) : std::nullopt;
    }

private:
    const TriangleMesh& surface_;
    const std::vector<Vector>& normals_;
    const std::vector<double>& uncertainty_;
    double noise_;
    FacetTree tree_;
    std::vector<State> state_;
};

// What a rod says of a touch.
struct Verdict {
    PartTag tag = PartTag::shadow;
    bool is_near = false;  // by itself, whatever is said of its neighbours
    double radius = 0.0;   // mm, of the rod
    Vector normal;         // in the tool's frame
};

struct Frame {
    Eigen::Quaterniond turn;
    TriangleMesh surface;  // what the ball touched
    std::vector<Vector> normals;
    std::vector<double> uncertainty;
};

Frame turned(const TracedSurface& traced, const std::vector<Contact>& contacts, const Vector& axis) {
    Frame frame{Eigen::Quaterniond::FromTwoVectors(axis, Vector::UnitZ()), {{}, traced.mesh.triangles}, {}, {}};
    for (const Contact& contact : contacts) {
        frame.surface.points.emplace_back(frame.turn * contact.point);
        frame.normals.emplace_back(frame.turn * contact.normal);
        frame.uncertainty.push_back(contact.uncertainty);
    }
    return frame;
}

TriangleMesh turned(const TriangleMesh& mesh, const Eigen::Quaterniond& turn) {
    TriangleMesh result = mesh;
    for (Point& p : result.points) p = turn * p;
    return result;
}

std::vector<Rod> rods_of(const ToolShape& tool) {
    std::vector<Rod> rods;
    const double radius = tool.ball_diameter / 2;
    double length = 0;
    if (tool.stylus) {
        // Below that its surface is inside the ball.
        const double shank = tool.stylus->diameter / 2;
        length = tool.stylus->length;
        const double leaves = std::sqrt(std::max(radius * radius - shank * shank, 0.0));
        if (leaves < length) rods.push_back({shank, leaves, length});
    }
    if (tool.holder) rods.push_back({tool.holder->diameter / 2, length, length + tool.holder->length});
    return rods;
}

class ShadowTeller {
public:
    ShadowTeller(const TracedSurface& traced, const FacetFans& fans, const std::vector<Contact>& contacts, const ToolShape& tool,
                 const CompensationOptions& options, bool is_last)
        : traced_(traced),
          fans_(fans),
          contacts_(contacts),
          options_(options),
          is_last_(is_last),
          radius_(tool.ball_diameter / 2),
          rods_(rods_of(tool)),
          frame_(turned(traced, contacts, tool.axis)),
          test_(frame_.surface, frame_.normals, frame_.uncertainty, options.noise),
          traced_in_frame_(turned(traced.mesh, frame_.turn)),
          traced_tree_(traced_in_frame_),
          verdicts_(contacts.size()),
          touched_(contacts.size()) {}

    [[nodiscard]] std::vector<TouchedPoint> run() && {
        std::vector<std::uint32_t> order(contacts_.size());
        std::iota(order.begin(), order.end(), 0U);
        std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
            const double at_a = frame_.surface.points[a].z();
            const double at_b = frame_.surface.points[b].z();
            return at_a != at_b ? at_a > at_b : a < b;
        });
        for (const std::uint32_t v : order) {
            const Contact& contact = contacts_[v];
            touched_[v] = {contact.point, contact.normal, contact.uncertainty, PartTag::tip};
            if (!traced_.is_fixture.empty() && traced_.is_fixture[v] != 0) {
                touched_[v].tag = PartTag::fixture;
                touched_[v].uncertainty = std::numeric_limits<double>::infinity();
                continue;
            }
            verdicts_[v] = judge(v);
            if (verdicts_[v] && verdicts_[v]->is_near) follow(v);
            test_.set(v, touched_[v].tag == PartTag::shadow ? State::hidden : State::seen);
        }
        for (const std::uint32_t v : order) {
            if (touched_[v].tag == PartTag::tip && verdicts_[v] && is_amid_shadows(v, kAmid)) follow(v);
        }
        for (const std::uint32_t v : order) {
            if (touched_[v].tag == PartTag::tip) doubt_wall(v);
        }
        for (bool grows = !rods_.empty(); grows;) {
            grows = false;
            for (const std::uint32_t v : order) {
                if (touched_[v].tag == PartTag::tip) grows = doubt_beside_shadows(v) || grows;
            }
        }
        if (is_last_) doubt_brinks();
        widen_beside_shadows();
        return std::move(touched_);
    }

private:
    // The first rod that explains the touch, else one that nearly does.
    [[nodiscard]] std::optional<Verdict> judge(std::uint32_t v) const {
        const Contact& contact = contacts_[v];
        std::optional<Verdict> verdict;
        for (const Rod& rod : rods_) {
            const auto found = test_.explain(frame_.turn * traced_.mesh.points[v], rod, options_.epsilon);
            const double differs = radius_ - rod.radius;
            if (!found) continue;
            const double tolerance = std::max(found->tolerance, kTouches * std::min(std::abs(differs), radius_));
            if (found->gap > kNearly * tolerance) continue;
            if (!contact.is_creased && angle_between(frame_.normals[v], found->normal) > kOtherSide + contact.angle) continue;
            // The ball's own wall stands r off: it has to be ruled out, with touches of both places off.
            const bool is_told = std::abs(differs) > kToldApart * options_.noise;
            const double most = std::min(differs / 2, differs - found->tolerance - 2 * options_.noise);
            bool is_shadow = is_told && (differs < 0 || found->gap < most);
            if (is_shadow && differs > 0) {
                const Vector out = Vector(found->normal.x(), found->normal.y(), 0).normalized();
                is_shadow = !is_free_above(v, kClearlyBeside * differs * out, rod, kClearTrust);
            }
            verdict = {is_shadow ? PartTag::shadow : PartTag::ambiguous, found->gap <= tolerance, rod.radius, found->normal};
            if (verdict->is_near) break;
        }
        return verdict;
    }
    void follow(std::uint32_t v) {
        const Verdict& verdict = *verdicts_[v];
        TouchedPoint& point = touched_[v];
        point.tag = verdict.tag;
        point.uncertainty = std::numeric_limits<double>::infinity();
        // What a round end touches says nothing of what is below.
        if (verdict.tag != PartTag::shadow || std::abs(verdict.normal.z()) > kSide) return;
        point.normal = frame_.turn.conjugate() * Vector(verdict.normal.x(), verdict.normal.y(), 0).normalized();
        point.point = traced_.mesh.points[v] - verdict.radius * point.normal;
    }
    // rad: how far a normal may be off.
    [[nodiscard]] double off_of(std::uint32_t v) const { return std::min(contacts_[v].angle + contacts_[v].disagreement, kMostOff); }
    [[nodiscard]] Vector out_of(std::uint32_t v) const { return Vector(frame_.normals[v].x(), frame_.normals[v].y(), 0).normalized(); }
    void doubt(std::uint32_t v, PartTag tag, const Rod& rod, const Vector& out) {
        verdicts_[v] = {tag, true, rod.radius, out};
        follow(v);
    }
    // What stands there was not looked at, at no height.
    [[nodiscard]] bool is_beyond_area(const Point& p) const {
        if (!traced_.area) return false;
        const Box box = bounds_of(*traced_.area);
        return !is_inside(*traced_.area, {p.x(), p.y(), std::clamp(p.z(), box.min.z(), box.max.z())}, 0);
    }
    // What juts out above a wall was touched by the rod, wherever facets are too coarse to show its place.
    void doubt_wall(std::uint32_t v) {
        if (std::abs(frame_.normals[v].z()) > kWall + std::sin(off_of(v))) return;
        const Vector out = out_of(v);
        for (const Rod& rod : rods_) {
            const double differs = radius_ - rod.radius;
            if (differs > 0 && is_beyond_area(traced_.mesh.points[v] - rod.radius * (frame_.turn.conjugate() * out))) {
                return doubt(v, PartTag::ambiguous, rod, out);
            }
            if (differs <= 0 || is_free_above(v, beside(differs) * out, rod, kTrust)) continue;
            const bool is_clear =
                differs > 3 * kToldApart * options_.noise && !is_free_above(v, kClearlyBeside * differs * out, rod, kClearTrust);
            return doubt(v, is_clear ? PartTag::shadow : PartTag::ambiguous, rod, out);
        }
    }
    // The same where half of what is around is no touch of the ball's, and at the foot of such a wall, where the normal may be the floor's.
    bool doubt_beside_shadows(std::uint32_t v) {
        for (const Rod& rod : rods_) {
            const double differs = radius_ - rod.radius;
            if (differs <= 0) continue;
            if (std::abs(frame_.normals[v].z()) < kSide) {
                const Vector out = out_of(v);
                if (!is_amid_shadows(v, kHalf) || is_free_above(v, kAmidBeside * differs * out, rod, 2 * kTrust)) continue;
                doubt(v, PartTag::ambiguous, rod, out);
                return true;
            }
            if (!contacts_[v].is_creased) continue;
            if (is_amid_shadows(v, kAmid)) {
                doubt(v, PartTag::ambiguous, rod, frame_.normals[v]);
                return true;
            }
            for (const std::uint32_t w : ring(v)) {
                const bool is_wall =
                    touched_[w].tag != PartTag::tip && touched_[w].tag != PartTag::fixture && std::abs(frame_.normals[w].z()) < kSide;
                if (!is_wall) continue;
                const Vector out = out_of(w);
                const Vector to = traced_in_frame_.points[v] - traced_in_frame_.points[w];
                if (std::abs(out.dot(to)) > kOnWall * to.norm() || is_free_above(v, beside(differs) * out, rod, kTrust)) continue;
                doubt(v, PartTag::ambiguous, rod, out);
                return true;
            }
        }
        return false;
    }
    // At the brink of shadows normals are mixed, and what the ball touched last is hardly deeper than what the rod did.
    void doubt_brinks() {
        std::vector<std::uint32_t> doubted;
        for (std::uint32_t v = 0; v < touched_.size(); ++v) {
            if (touched_[v].tag != PartTag::shadow || verdicts_[v]->radius > radius_) continue;
            double others = 0;
            double shadows = 0;
            for (const std::uint32_t f : fans_.around(v)) {
                for (const std::uint32_t w : traced_.mesh.triangles[f]) {
                    if (w == v || touched_[w].tag == PartTag::fixture) continue;
                    ++others;
                    shadows += touched_[w].tag == PartTag::shadow ? 1 : 0;
                }
            }
            const bool is_brink = shadows < (contacts_[v].is_creased ? kAmidCreased : kHalf) * others;
            const Verdict& verdict = *verdicts_[v];
            const Rod& rod = *std::ranges::find(rods_, verdict.radius, &Rod::radius);
            const Vector out = Vector(verdict.normal.x(), verdict.normal.y(), 0).normalized();
            if (is_brink && is_free_above(v, kDeep * (radius_ - rod.radius) * out, rod, kClearTrust)) doubted.push_back(v);
        }
        for (const std::uint32_t v : doubted) touched_[v].tag = PartTag::ambiguous;
    }
    [[nodiscard]] std::vector<std::uint32_t> ring(std::uint32_t v) const {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t f : fans_.around(v)) {
            for (const std::uint32_t w : traced_.mesh.triangles[f]) {
                if (w != v && std::ranges::find(found, w) == found.end()) found.push_back(w);
            }
        }
        return found;
    }
    // mm: how far beside the way up to look. Nearer where the mesh is coarse over that.
    [[nodiscard]] double beside(double differs) const { return kBeside * differs * std::min(1.0, kCoarse * differs / options_.epsilon); }
    // A rod that touches has what it touches within its radius of its axis: lifted by so much, the ball is as deep in S* as it is wider,
    // and so it is on its way up beside, by less than that. Whether S* rules that out, however its facets bulge.
    [[nodiscard]] bool is_free_above(std::uint32_t v, const Vector& aside, const Rod& rod, double trust) const {
        const Point from = traced_in_frame_.points[v] + aside;
        const Segment up{from + rod.from * Vector::UnitZ(), from + rod.to * Vector::UnitZ()};
        bool is_free = true;
        traced_tree_.near(up, options_.epsilon, [&](const FacetPlace& place) {
            if (!is_free) return;
            const auto& corners = traced_in_frame_.triangles[place.facet];
            // No rod touches a fixture.
            if (std::ranges::any_of(corners, [&](std::uint32_t w) { return touched_[w].tag == PartTag::fixture; })) return;
            double bulges = 0;
            for (Eigen::Index k = 0; k < 3; ++k) {
                const std::uint32_t a = corners[static_cast<std::size_t>(k)];
                const std::uint32_t b = corners[static_cast<std::size_t>((k + 1) % 3)];
                const Point& at_a = traced_in_frame_.points[a];
                const Point& at_b = traced_in_frame_.points[b];
                const double rise = bulge(at_a, frame_.normals[a], at_b, frame_.normals[b]);
                if (trust <= 0 && is_creased(at_a, frame_.normals[a], at_b, frame_.normals[b])) return;
                const double doubt = (at_b - at_a).norm() * (off_of(a) + off_of(b)) / 2;
                bulges += place.share[k] * place.share[(k + 1) % 3] * std::max(rise + trust * doubt, 0.0);
            }
            is_free = place.distance > std::max(kMeets, bulges);
        });
        return is_free;
    }
    // Beside a shadow a fit does not tell how far the ball rolled below the edge: as far as the rod lets it.
    void widen_beside_shadows() {
        if (rods_.empty()) return;
        for (std::uint32_t v = 0; v < touched_.size(); ++v) {
            TouchedPoint& point = touched_[v];
            if (point.tag != PartTag::tip || !contacts_[v].is_creased || std::abs(frame_.normals[v].z()) > kSide) continue;
            const auto is_hidden = [&](std::uint32_t w) {
                return touched_[w].tag == PartTag::shadow || touched_[w].tag == PartTag::ambiguous;
            };
            if (std::ranges::any_of(ring(v), is_hidden)) point.uncertainty = std::max(point.uncertainty, rods_.front().from);
        }
    }
    // So many of the corners around, fixtures apart, are no touches of the ball's.
    [[nodiscard]] bool is_amid_shadows(std::uint32_t v, double share) const {
        std::size_t others = 0;
        std::size_t hidden = 0;
        for (const std::uint32_t f : fans_.around(v)) {
            for (const std::uint32_t w : traced_.mesh.triangles[f]) {
                if (w == v || touched_[w].tag == PartTag::fixture) continue;
                ++others;
                hidden += touched_[w].tag == PartTag::tip ? 0 : 1;
            }
        }
        return hidden > 0 && static_cast<double>(hidden) >= share * static_cast<double>(others);
    }

    const TracedSurface& traced_;
    const FacetFans& fans_;
    const std::vector<Contact>& contacts_;
    const CompensationOptions& options_;
    bool is_last_;
    double radius_;
    std::vector<Rod> rods_;
    Frame frame_;
    ShadowTest test_;
    TriangleMesh traced_in_frame_;
    FacetTree traced_tree_;
    std::vector<std::optional<Verdict>> verdicts_;
    std::vector<TouchedPoint> touched_;
};

}  // namespace

std::vector<TouchedPoint> tell_shadows(const TracedSurface& traced, const FacetFans& fans, const std::vector<Contact>& contacts,
                                       const ToolShape& tool, const CompensationOptions& options, bool is_last) {
    return ShadowTeller(traced, fans, contacts, tool, options, is_last).run();
}

}  // namespace palpate
