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

// Of the difference of the radii: a way straight up that is so far off S* and meets it cannot be the ball's, as a wall that the ball
// touched goes on up or recedes. With noise, that is added.
constexpr double kBeside = 0.05;
// ... and what it meets so far off is what the rod touched, however coarse the facets are.
constexpr double kClearlyBeside = 0.5;
// Of the ball's radius: so far below an edge the ball may touch it.
constexpr double kRollsBelow = 0.5;
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
                 const CompensationOptions& options)
        : traced_(traced),
          fans_(fans),
          contacts_(contacts),
          options_(options),
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
            if (touched_[v].tag == PartTag::tip && verdicts_[v] && is_amid_shadows(v)) follow(v);
        }
        for (const std::uint32_t v : order) {
            if (touched_[v].tag == PartTag::tip) doubt_wall(v);
        }
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
            const bool is_shadow = is_told && (differs < 0 || found->gap < most);
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
    // What juts out above a wall was touched by the rod, wherever facets are too coarse to show its place.
    void doubt_wall(std::uint32_t v) {
        const Vector& normal = frame_.normals[v];
        const Vector out(normal.x(), normal.y(), 0);
        if (rods_.empty() || std::abs(normal.z()) > kWall + std::sin(std::min(contacts_[v].angle, 0.5))) return;
        // A rim of S* is as round as the ball at least: by so much a chord between samples cuts it off.
        const double sag = 3 * options_.epsilon * options_.epsilon / (8 * radius_);
        for (const Rod& rod : rods_) {
            const double differs = radius_ - rod.radius;
            if (differs <= 0) continue;
            const double near = std::max(kBeside * differs, kClearlyBeside * differs - sag) + 2 * options_.noise;
            if (!is_barred_above(v, near * out.normalized(), rod.to)) continue;
            const bool is_clear =
                differs > 3 * kToldApart * options_.noise && is_barred_above(v, kClearlyBeside * differs * out.normalized(), rod.to);
            verdicts_[v] = {is_clear ? PartTag::shadow : PartTag::ambiguous, true, rod.radius, out.normalized()};
            return follow(v);
        }
    }
    // Whether S* is met straight up from a place beside the point, as far as the rod reaches.
    [[nodiscard]] bool is_barred_above(std::uint32_t v, const Vector& beside, double reach) const {
        const Point from = traced_in_frame_.points[v] + beside;
        bool is_barred = false;
        // Not the edge below which the ball rolls.
        const Segment up{from + kRollsBelow * radius_ * Vector::UnitZ(), from + reach * Vector::UnitZ()};
        traced_tree_.near(up, kMeets, [&](const FacetPlace&) { is_barred = true; });
        return is_barred;
    }
    // Two thirds of the corners around, fixtures apart: what is nearly explained there is no touch of the ball's.
    [[nodiscard]] bool is_amid_shadows(std::uint32_t v) const {
        std::size_t others = 0;
        std::size_t hidden = 0;
        for (const std::uint32_t f : fans_.around(v)) {
            for (const std::uint32_t w : traced_.mesh.triangles[f]) {
                if (w == v || touched_[w].tag == PartTag::fixture) continue;
                ++others;
                hidden += touched_[w].tag == PartTag::tip ? 0 : 1;
            }
        }
        return hidden > 0 && 3 * hidden >= 2 * others;
    }

    const TracedSurface& traced_;
    const FacetFans& fans_;
    const std::vector<Contact>& contacts_;
    const CompensationOptions& options_;
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
                                       const ToolShape& tool, const CompensationOptions& options) {
    return ShadowTeller(traced, fans, contacts, tool, options).run();
}

}  // namespace palpate
