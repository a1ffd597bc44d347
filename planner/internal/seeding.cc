#include "planner/internal/seeding.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

namespace palpate {
namespace {

// Rays from ω towards its centre that are tried before the object counts as not touched by them.
constexpr int kMaxRays = 256;
// First touches besides the seed facets that the triangulation starts with. More cost travel around ω and change
// nothing that lasts; fewer leave the first Voronoi edges long.
constexpr std::size_t kExtraTouches = 3;
// The vertices of a seed facet are touched along parallel rays this fraction of ε apart; on a slope they are farther
// apart than the rays, so that is halved until they keep kSeedSize.
constexpr double kRaySpacing = 0.25;
constexpr double kSeedSize = 1.0 / 3.0;
constexpr int kMaxHalvings = 5;

std::string text(const Point& p) { return "(" + std::to_string(p.x()) + ", " + std::to_string(p.y()) + ", " + std::to_string(p.z()) + ")"; }

class Seeding {
public:
    Seeding(const Workspace& workspace, const Options& options, MaintainedDelaunay& state, Tool& tool)
        : workspace_(workspace), options_(options), state_(state), tool_(tool) {}

    std::vector<SeedFacet> run() {
        if (options_.seed_rays.empty()) {
            seed_from_centre_rays();
        } else {
            for (std::size_t k = 0; k < options_.seed_rays.size(); ++k) seed_from_user_ray(k);
        }
        add_first_touches();
        state_.initialise(samples_);
        for (std::uint32_t k = 0; k < samples_.size(); ++k) tool_.assign(touch_of_[k], roles_[k], k);
        std::erase_if(facets_, [&](const SeedFacet& facet) { return !touch_dual_edge(facet); });
        tool_.end_of_seeding();
        return facets_;
    }

private:
    struct Ray {
        Point origin = Point::Zero();
        Vector direction = Vector::Zero();  // unit
        double end = std::numeric_limits<double>::infinity();  // mm from origin: not probed beyond
    };

    // Probes the ray from where its line enters ω. Nothing if it misses ω or touches nothing.
    std::optional<Tool::Answer> touch(const Ray& ray) {
        const auto chord = workspace_.clip(ray.origin, ray.direction);
        if (!chord || ray.end <= chord->low) return std::nullopt;
        Roadmap& roadmap = state_.roadmap();
        const NodeId entry = roadmap.add_on_boundary(ray.origin + chord->low * ray.direction);
        tool_.go_to(entry);
        const Tool::Answer answer = tool_.probe(ray.origin + std::min(ray.end, chord->high) * ray.direction);
        if (answer.contact || ray.end < chord->high) {
            tool_.arrive(roadmap.add(entry, answer.position));
        } else {
            const NodeId leave = roadmap.add_on_boundary(answer.position);
            roadmap.connect(entry, leave);
            tool_.arrive(leave);
        }
        if (!answer.contact) return std::nullopt;
        return answer;
    }

    Ray centre_ray(int k) const { return {workspace_.center(), -spread_direction(k)}; }

    // Towards a place a little inside the object, below the first touch: what lies far from the centre is found there.
    Ray ray_below_first_touch(int k) const { return {below_first_touch_, -spread_direction(k)}; }

    void seed_from_centre_rays() {
        while (next_ray_ < kMaxRays) {
            const Ray ray = centre_ray(next_ray_++);
            if (const auto first = touch(ray)) return add_seed(ray, *first);
        }
        throw SeedError("none of " + std::to_string(kMaxRays) + " rays towards the centre of the workspace, " + text(workspace_.center()) +
                        ", touched anything: give probing.seed_rays, one ray that meets the object per component, or move the workspace");
    }

    void seed_from_user_ray(std::size_t k) {
        const Segment& given = options_.seed_rays[k];
        const double length = (given.target - given.source).norm();
        const Ray ray{given.source, (given.target - given.source) / length, length};
        const auto first = touch(ray);
        if (!first) {
            throw SeedError("seed ray " + std::to_string(k + 1) + ", from " + text(given.source) + " to " + text(given.target) +
                            ", touches nothing inside the workspace before it ends: correct probing.seed_rays so that every ray meets the object");
        }
        // The same place twice would give two seed facets in each other's way.
        if (is_spaced(first->position)) add_seed(ray, *first);
    }

    [[nodiscard]] bool is_spaced(const Point& p) const {
        return std::all_of(samples_.begin(), samples_.end(), [&](const Point& q) { return (p - q).norm() > options_.epsilon; });
    }

    void add_sample(const Tool::Answer& answer, Touch::Role role) {
        samples_.push_back(answer.position);
        touch_of_.push_back(answer.touch);
        roles_.push_back(role);
    }

    // Two more touches beside the first, along rays parallel to its own.
    void add_seed(const Ray& ray, const Tool::Answer& first) {
        if (samples_.empty()) below_first_touch_ = first.position + options_.epsilon * ray.direction;
        const Vector side = ray.direction.unitOrthogonal();
        const Vector other = ray.direction.cross(side);
        const Vector sixty_degrees = 0.5 * side + std::numbers::sqrt3 / 2 * other;
        double spacing = kRaySpacing * options_.epsilon;
        for (int attempt = 0; attempt <= kMaxHalvings; ++attempt, spacing /= 2) {
            // At an edge of the object one side may fall off: every other attempt goes to the opposite side.
            const double sign = attempt % 2 == 0 ? 1 : -1;
            // They may end deeper than the first, but no deeper than a near touch can lie.
            const double end = kSeedSize * options_.epsilon;
            const auto second = touch({first.position + sign * spacing * side, ray.direction, end});
            if (!second || !is_near(first, *second)) continue;
            const auto third = touch({first.position + sign * spacing * sixty_degrees, ray.direction, end});
            if (!third || !is_near(first, *third) || !is_near(*second, *third)) continue;
            const auto index = static_cast<std::uint32_t>(samples_.size());
            facets_.push_back({{index, index + 1, index + 2}, ray.direction});
            for (const Tool::Answer& vertex : {first, *second, *third}) add_sample(vertex, Touch::Role::seed_facet);
            return;
        }
        add_sample(first, Touch::Role::seed);  // explored from later, like any sample that Ŝ does not use
    }

    [[nodiscard]] bool is_near(const Tool::Answer& a, const Tool::Answer& b) const {
        return (a.position - b.position).norm() <= kSeedSize * options_.epsilon;
    }

    [[nodiscard]] bool spans_space() const {
        using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
        const auto cgal = [&](std::size_t k) { return Kernel::Point_3(samples_[k].x(), samples_[k].y(), samples_[k].z()); };
        std::size_t line = 2;
        while (line < samples_.size() && CGAL::collinear(cgal(0), cgal(1), cgal(line))) ++line;
        for (std::size_t k = line + 1; k < samples_.size(); ++k) {
            if (!CGAL::coplanar(cgal(0), cgal(1), cgal(line), cgal(k))) return true;
        }
        return false;
    }

    void add_first_touches() {
        std::size_t wanted = samples_.size() + kExtraTouches;
        for (int k = 0; k < kMaxRays && (samples_.size() < wanted || !spans_space()); ++k) {
            const auto first = touch(k % 2 == 0 ? centre_ray(next_ray_++) : ray_below_first_touch(k));
            if (first && is_spaced(first->position)) add_sample(*first, Touch::Role::seed);
            // A small or thin object may not have that many: after a while, enough is enough.
            if (k > kMaxRays / 4) wanted = 0;
        }
        if (!spans_space()) {
            throw SeedError("no first touches farther than epsilon = " + std::to_string(options_.epsilon) +
                            " mm apart that span a volume: the object is too small for this epsilon; make epsilon smaller, or give probing.seed_rays");
        }
    }

    // The dual edge of a seed facet, probed along its whole line from outside ω.
    bool touch_dual_edge(const SeedFacet& facet) {
        auto e = state_.find_facet(facet.samples[0], facet.samples[1], facet.samples[2]);
        if (!e) return false;
        const auto [a, b, c] = state_.facet_samples(*e);
        const Vector normal = (samples_[b] - samples_[a]).cross(samples_[c] - samples_[a]);
        if (normal.dot(facet.approach) > 0) e = state_.opposite(*e);
        const auto along = state_.span(*e);
        if (!along) return false;
        const double sign = normal.dot(along->line.direction) * normal.dot(facet.approach) > 0 ? 1 : -1;
        const Vector inwards = sign * along->line.direction;
        const auto chord = workspace_.clip(along->line.origin, inwards);
        if (!chord) return false;
        Roadmap& roadmap = state_.roadmap();
        const NodeId entry = roadmap.add_on_boundary(along->line.origin + chord->low * inwards);
        tool_.go_to(entry);
        const Tool::Answer answer = tool_.probe(along->end_point());
        if (!answer.contact) {
            tool_.arrive(roadmap.add(entry, answer.position));
            return false;
        }
        const NodeId contact = roadmap.add(entry, answer.position);
        tool_.arrive(contact);
        const double at = inwards.dot(answer.position - along->start_point());
        const double ball_radius = (answer.position - samples_[a]).norm();
        if (at < 0 || ball_radius > options_.epsilon / 2) return false;
        state_.learn_contact_from_outside(*e, *along, entry, contact, answer.touch);
        return true;
    }

    const Workspace& workspace_;
    const Options& options_;
    MaintainedDelaunay& state_;
    Tool& tool_;
    int next_ray_ = 0;  // towards the centre
    Point below_first_touch_ = Point::Zero();
    std::vector<Point> samples_;
    std::vector<std::uint32_t> touch_of_;
    std::vector<Touch::Role> roles_;
    std::vector<SeedFacet> facets_;
};

}  // namespace

Vector spread_direction(int k) {
    // Roberts' R2 sequence (the plastic number's powers), mapped to the sphere preserving area.
    constexpr double kFirst = 0.7548776662466927;
    constexpr double kSecond = 0.5698402909980532;
    const auto fraction = [](double x) { return x - std::floor(x); };
    const double z = 1 - 2 * fraction(0.5 + (k + 1) * kFirst);
    const double longitude = 2 * std::numbers::pi * fraction(0.5 + (k + 1) * kSecond);
    const double flat = std::sqrt(1 - z * z);
    return {flat * std::cos(longitude), flat * std::sin(longitude), z};
}

std::vector<SeedFacet> touch_seeds(const Workspace& workspace, const Options& options, MaintainedDelaunay& state, Tool& tool) {
    return Seeding(workspace, options, state, tool).run();
}

}  // namespace palpate
