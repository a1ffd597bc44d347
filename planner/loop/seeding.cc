#include "planner/loop/seeding.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <fmt/format.h>

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
// After so many tries, rays go elsewhere as well.
constexpr int kCentred = 8;
// First touches besides the seed facets that the triangulation starts with. More cost travel around ω and change
// nothing that lasts; fewer leave the first Voronoi edges long.
constexpr std::size_t kExtraTouches = 3;
// rad: the golden angle, between ways to the walls of an area.
constexpr double kTurn = 2.399963229728653;
// The vertices of a seed facet are touched along parallel rays this fraction of ε apart; on a slope they are farther
// apart than the rays, so that is halved until they keep kSeedSize.
constexpr double kRaySpacing = 0.25;
constexpr double kSeedSize = 1.0 / 3.0;
constexpr int kMaxHalvings = 5;
static_assert(kRaySpacing / (1 << kMaxHalvings) >= kSeedSpacing, "touches on parallel rays are at least as far apart as the rays");

std::string text(const Point& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z()); }

// Fractions of a square's sides, well spread from its middle on: Roberts' R2 sequence (the plastic number's powers).
std::array<double, 2> plane_fractions(int k) {
    constexpr double kFirst = 0.7548776662466927;
    constexpr double kSecond = 0.5698402909980532;
    const auto fraction = [](double x) { return x - std::floor(x); };
    return {fraction(0.5 + k * kFirst), fraction(0.5 + k * kSecond)};
}

struct Ray {
    Point origin = Point::Zero();
    Vector direction = Vector::Zero();                        // unit
    double end = std::numeric_limits<double>::infinity();     // mm from origin: not probed beyond
    double begin = -std::numeric_limits<double>::infinity();  // mm from origin: ω must not lie before it
    bool is_vouched = false;                                  // the user says that it meets the object
    bool may_be_known = false;                                // what it meets may be a known solid
};

// What all of seeding works with.
struct Context {
    const Options& options;
    ProbedSpace& space;
    ProbeHead& head;
};

// Probes a ray from where its line enters ω. Nothing if it misses ω or touches nothing.
std::optional<ProbeHead::Answer> touch(const Context& context, const Ray& ray) {
    const auto chord = context.space.delaunay().surroundings().unknown_part(ray.origin, ray.direction);
    if (!chord || ray.end <= chord->low || chord->high <= ray.begin) return std::nullopt;
    const Point entry = ray.origin + chord->low * ray.direction;
    if (!context.space.delaunay().surroundings().is_enterable(entry)) return std::nullopt;
    context.head.go_to(context.space.roadmap().add_on_boundary(entry));
    const Point target = ray.origin + std::min(ray.end, chord->high) * ray.direction;
    const auto expected = ray.is_vouched ? std::optional(ProbeHead::Expected{target}) : std::nullopt;
    const ProbeHead::Answer answer = context.head.probe({target, kNoNode, ray.end >= chord->high}, Touch::Role::crossing, expected);
    if (!answer.is_contact() || (answer.is_known && !ray.may_be_known)) return std::nullopt;
    return answer;
}

class FirstTouches {
public:
    explicit FirstTouches(const Context& context) : context_(context) {}

    // Until they span space; initialises the triangulation. The first `seed_count()` samples are the components' seeds.
    void run() {
        const std::vector<Segment>& given = context_.options.seed_rays;
        if (given.empty()) {
            seed_by_centre_ray();
        } else {
            for (std::size_t k = 0; k < given.size(); ++k) seed_by_user_ray(k);
        }
        seed_count_ = samples_.size();
        add_others();
        context_.space.delaunay().initialise(samples_);
        for (std::uint32_t k = 0; k < samples_.size(); ++k) context_.head.assign(touches_[k], Touch::Role::seed, k);
    }

    [[nodiscard]] std::size_t seed_count() const { return seed_count_; }
    [[nodiscard]] const Vector& approach(std::uint32_t sample) const { return approaches_[sample]; }

private:
    [[nodiscard]] const Region& region() const { return context_.space.delaunay().surroundings().region(); }

    [[nodiscard]] Ray centre_ray(int k) const { return {region().center(), -spread_direction(k)}; }

    // Towards a place a little inside the object, below the first touch: what lies far from the centre is found there.
    [[nodiscard]] Ray ray_below_first_touch(int k) const {
        return {samples_.front() + context_.options.epsilon * approaches_.front(), -spread_direction(k)};
    }

    // Through a place anywhere in ω: a plate through the centre is touched only there by rays to the centre.
    [[nodiscard]] Ray ray_aside(int k) const {
        const Vector aside = (0.2 + 0.6 * (k % 8) / 8) * region().radius() * spread_direction(kMaxRays + k);
        return {region().center() + aside, -spread_direction(k)};
    }

    // Straight into the area, or with `aside` a wall, from a place of the face that leads into it: from above, if that one does.
    [[nodiscard]] Ray ray_into_area(int k, bool aside) const {
        const Surroundings& surroundings = context_.space.delaunay().surroundings();
        const Box box = surroundings.bounds();
        int axis = 2;
        bool at_max = true;
        const auto leads_in = [&] { return surroundings.faces().is_open.at(static_cast<std::size_t>(axis)).at(at_max ? 1 : 0); };
        for (int face = 5; !leads_in() && face >= 0; --face) {
            axis = face / 2;
            at_max = face % 2 == 1;
        }
        const Vector size = box.max - box.min;
        const Vector inwards = (at_max ? -1 : 1) * Vector::Unit(axis);
        const auto [one, other] = plane_fractions(k);
        Ray ray{at_max ? box.max : box.min, inwards};
        ray.origin[(axis + 1) % 3] = box.min[(axis + 1) % 3] + one * size[(axis + 1) % 3];
        ray.origin[(axis + 2) % 3] = box.min[(axis + 2) % 3] + other * size[(axis + 2) % 3];
        if (!aside) return ray;
        const Vector across = std::cos(kTurn * k) * Vector::Unit((axis + 1) % 3) + std::sin(kTurn * k) * Vector::Unit((axis + 2) % 3);
        const double width = std::max(size[(axis + 1) % 3], size[(axis + 2) % 3]);
        ray.direction = (across + (0.1 + 0.9 * other) * size[axis] / width * inwards).normalized();
        return ray;
    }
    [[nodiscard]] bool has_area() const { return context_.space.delaunay().surroundings().area().has_value(); }

    void add(const ProbeHead::Answer& answer, const Ray& ray) {
        samples_.push_back(answer.position);
        touches_.push_back(answer.touch);
        approaches_.push_back(ray.direction);
    }

    void seed_by_centre_ray() {
        while (next_ray_ < kMaxRays) {
            const Ray ray = has_area() ? ray_into_area(next_ray_, false) : centre_ray(next_ray_);
            ++next_ray_;
            if (const auto first = touch(context_, ray)) return add(*first, ray);
        }
        if (has_area()) {
            throw SeedError(fmt::format(
                "none of {} rays straight into the area touched anything but its walls and fixtures: give probing.seed_rays, one ray that "
                "meets the object there per component, or move probing.area",
                kMaxRays));
        }
        throw SeedError(
            fmt::format("none of {} rays towards the centre of the workspace, {}, touched anything: give probing.seed_rays, one ray that "
                        "meets the object per component, or move the workspace",
                        kMaxRays, text(region().center())));
    }

    void seed_by_user_ray(std::size_t k) {
        const Segment& given = context_.options.seed_rays[k];
        const std::string name = fmt::format("seed ray {}, from {} to {},", k + 1, text(given.source), text(given.target));
        if (!context_.space.delaunay().surroundings().is_free(given.source)) {
            throw SeedError(fmt::format(
                "{} starts inside the workspace, where no way is proven free yet: start it outside, in probing.seed_rays", name));
        }
        const double length = (given.target - given.source).norm();
        const Ray ray{given.source, (given.target - given.source) / length, length, 0.0, true};
        const auto first = touch(context_, ray);
        if (!first) {
            throw SeedError(fmt::format(
                "{} touches nothing inside the {} before it ends: correct probing.seed_rays so that every ray meets the object{}", name,
                has_area() ? "area" : "workspace", has_area() ? ", on a way that comes in over a face that the area reaches" : ""));
        }
        // The same place twice would give two seed facets in each other's way. If it may be another component, that matters.
        const double nearest = distance_to_samples(first->position);
        if (nearest > context_.options.epsilon) return add(*first, ray);
        if (nearest > kSeedSize * context_.options.epsilon) {
            throw SeedError(fmt::format(
                "{} touches {:.6g} mm beside an earlier one, nearer than epsilon = {:.6g} mm: if it is the same component, drop the ray "
                "from probing.seed_rays; if it is another, make epsilon smaller",
                name, nearest, context_.options.epsilon));
        }
    }

    void add_others() {
        std::size_t wanted = samples_.size() + kExtraTouches;
        for (int k = 0; k < kMaxRays && (samples_.size() < wanted || !spans_space()); ++k) {
            Ray ray = has_area() && k % 4 < 3       ? ray_into_area(k, k % 4 > 0)
                      : k >= kCentred && k % 4 == 0 ? ray_aside(k)
                      : k % 2 == 0                  ? centre_ray(next_ray_++)
                                                    : ray_below_first_touch(k);
            ray.may_be_known = true;
            const auto first = touch(context_, ray);
            if (first && is_spaced(first->position)) add(*first, ray);
            // A small or thin object may not have that many: after a while, enough is enough.
            if (k > kMaxRays / 4) wanted = 0;
        }
        if (!spans_space()) {
            throw SeedError(
                fmt::format("no first touches farther than epsilon = {:.6g} mm apart that span a volume: the object is too small for this "
                            "epsilon; make epsilon smaller, or give probing.seed_rays",
                            context_.options.epsilon));
        }
    }

    [[nodiscard]] double distance_to_samples(const Point& p) const {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Point& q : samples_) nearest = std::min(nearest, (p - q).norm());
        return nearest;
    }
    [[nodiscard]] bool is_spaced(const Point& p) const { return distance_to_samples(p) > context_.options.epsilon; }

    [[nodiscard]] bool spans_space() const {
        const auto cgal = [&](std::size_t k) { return Kernel::Point_3(samples_[k].x(), samples_[k].y(), samples_[k].z()); };
        std::size_t line = 2;
        while (line < samples_.size() && CGAL::collinear(cgal(0), cgal(1), cgal(line))) ++line;
        for (std::size_t k = line + 1; k < samples_.size(); ++k) {
            if (!CGAL::coplanar(cgal(0), cgal(1), cgal(line), cgal(k))) return true;
        }
        return false;
    }

    const Context context_;
    std::vector<Point> samples_;
    std::vector<std::uint32_t> touches_;  // of the samples
    std::vector<Vector> approaches_;      // of the samples
    std::size_t seed_count_ = 0;
    int next_ray_ = 0;  // towards the centre
};

// The other two vertices of a seed facet, touched along rays parallel to the one that touched the first.
std::optional<std::array<ProbeHead::Answer, 2>> touch_beside(const Context& context, const Point& first, const Vector& approach) {
    const double near = kSeedSize * context.options.epsilon;
    const Vector side = approach.unitOrthogonal();
    const Vector sixty_degrees = 0.5 * side + std::numbers::sqrt3 / 2 * approach.cross(side);
    double spacing = kRaySpacing * context.options.epsilon;
    // At corners and edges of other samples' seed facets, and on faces that mirror each other, touches meet samples.
    const auto is_spaced = [&](const Point& p) {
        const MaintainedDelaunay& state = context.space.delaunay();
        return (state.sample(state.nearest_sample(p, state.cell_at(0))) - p).norm() >= kSeedSpacing * context.options.epsilon;
    };
    for (int attempt = 0; attempt <= kMaxHalvings; ++attempt, spacing /= 2) {
        // At an edge of the object one side may fall off: every other attempt goes to the opposite side. The rays may end
        // deeper than the first touch, but no deeper than a near touch can lie.
        const double sign = attempt % 2 == 0 ? 1 : -1;
        const auto second = touch(context, {first + sign * spacing * side, approach, near});
        if (!second || (second->position - first).norm() > near || !is_spaced(second->position)) continue;
        const auto third = touch(context, {first + sign * spacing * sixty_degrees, approach, near});
        if (!third || (third->position - first).norm() > near || (third->position - second->position).norm() > near) continue;
        if (!is_spaced(third->position)) continue;
        return std::array{*second, *third};
    }
    return std::nullopt;
}

// The dual edge of a seed facet, probed along its whole line from outside ω.
bool touch_dual_edge(const Context& context, const SeedFacet& facet) {
    const MaintainedDelaunay& state = context.space.delaunay();
    auto e = state.find_facet(facet.samples[0], facet.samples[1], facet.samples[2]);
    if (!e) return false;
    const auto outwards = [&](DirectedEdge edge) {
        const auto [a, b, c] = state.facet_samples(edge);
        return Vector((state.sample(b) - state.sample(a)).cross(state.sample(c) - state.sample(a)));
    };
    if (outwards(*e).dot(facet.approach) > 0) e = state.opposite(*e);
    const auto along = state.span(*e);
    if (!along) return false;
    const Vector inwards = outwards(*e).dot(along->line.direction) < 0 ? along->line.direction : Vector(-along->line.direction);
    const auto chord = context.space.delaunay().surroundings().unknown_part(along->line.origin, inwards);
    if (!chord) return false;
    const Point enters = along->line.origin + chord->low * inwards;
    if (!context.space.delaunay().surroundings().is_enterable(enters)) return false;
    const NodeId entry = context.space.roadmap().add_on_boundary(enters);
    context.head.go_to(entry);
    const ProbeHead::Answer answer = context.head.probe({along->end_point()});
    if (!answer.is_contact()) return false;
    const bool on_edge = inwards.dot(answer.position - along->start_point()) >= 0;
    const double ball_radius = (answer.position - state.sample(facet.samples[0])).norm();
    if (!on_edge || ball_radius > context.options.epsilon / 2) return false;
    context.space.learn_contact_from_outside(*e, *along, entry, context.head.at(), answer.touch);
    return true;
}

}  // namespace

Vector spread_direction(int k) {
    // Mapped to the sphere preserving area.
    const auto [height, turn] = plane_fractions(k + 1);
    const double z = 1 - 2 * height;
    const double longitude = 2 * std::numbers::pi * turn;
    const double flat = std::sqrt(1 - z * z);
    return {flat * std::cos(longitude), flat * std::sin(longitude), z};
}

std::optional<SeedFacet> touch_seed_facet(const Options& options, ProbedSpace& space, ProbeHead& head, std::uint32_t sample,
                                          const Vector& approach) {
    const Context context{options, space, head};
    const MaintainedDelaunay& state = space.delaunay();
    const auto beside = touch_beside(context, state.sample(sample), approach);
    if (!beside) return std::nullopt;
    SeedFacet facet{{sample, 0, 0}, approach};
    for (const std::size_t k : {0U, 1U}) {
        facet.samples[k + 1] = space.insert((*beside)[k].position, state.cell_at(sample)).sample;
        head.assign((*beside)[k].touch, Touch::Role::seed_facet, facet.samples[k + 1]);
    }
    if (!touch_dual_edge(context, facet)) return std::nullopt;
    return facet;
}

std::vector<SeedFacet> touch_seeds(const Options& options, ProbedSpace& space, ProbeHead& head) {
    FirstTouches first({options, space, head});
    first.run();
    std::vector<SeedFacet> facets;
    for (std::uint32_t k = 0; k < first.seed_count(); ++k) {
        if (const auto facet = touch_seed_facet(options, space, head, k, first.approach(k))) facets.push_back(*facet);
    }
    head.end_of_seeding();
    return facets;
}

}  // namespace palpate
