#include "planner/loop/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "planner/union_find.h"

namespace palpate {
namespace {

// So often Ŝ is refined around a touch that no facet uses: it may be a false touch, which nothing will ever join to Ŝ, and on a machine
// touches around it are not for nothing.
constexpr int kMaxRepairs = 24;
// Beside walls that samples cannot show, balls smaller than kHopeless · ε are refined so often in a cube of side ε: enough for the defects
// along a sharp edge, which become fewer, and not for those in a plate, which become more.
constexpr double kHopeless = 0.25;
constexpr int kHopelessRepairs = 6;
// Of ε: components of Ŝ that are nearer to each other may be one.
constexpr double kTorn = 4.0;

constexpr const char* kTornText =
    "two components of the mesh near each other, which may be one; if they are two, give probing.seed_rays a ray to each";

using SamplePair = std::pair<std::uint32_t, std::uint32_t>;

// By point of the mesh: its triangles.
std::vector<std::vector<std::uint32_t>> triangles_at(const TriangleMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> at(mesh.points.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const std::uint32_t v : mesh.triangles[t]) at[v].push_back(t);
    }
    return at;
}

}  // namespace

bool Repair::is_worth_it(const SurfaceBall& ball) {
    const auto e = state_.edge_of(ball.id, ball.generation);
    if (!e || !criteria_.may_repair(ball.radius)) return false;
    const Point& at = state_.crossing(*e).near;
    if (ball.radius > kHopeless * options_.epsilon || !walls_.is_hopeless(at, ball.radius)) return true;
    return ++hopeless_[grid_cell(at, options_.epsilon)] <= kHopelessRepairs;
}

std::vector<SurfaceBall> Repair::balls(const RestrictedSurface& surface) {
    std::vector<SurfaceBall> found;
    const auto add_largest = [&](const std::vector<std::uint32_t>& facets) {
        if (facets.empty()) return;
        SurfaceBall largest;
        for (const std::uint32_t facet : facets) largest = std::max(largest, ball_of(state_, surface.dual_edges[facet]));
        if (is_worth_it(largest)) found.push_back(largest);
    };
    for (const Defect& defect : analyse_topology(surface.mesh).defects) add_largest(defect.facets);
    for (const DirectedEdge e : doubly_crossed(state_)) {
        const SurfaceBall ball = ball_of(state_, larger_ball(state_, e));
        if (walls_.can_show(state_.thickness(e)) && criteria_.may_repair(ball.radius)) found.push_back(ball);
    }

    const auto facets_of = triangles_at(surface.mesh);
    std::vector<std::uint32_t> neighbors;
    const auto add_near = [&](std::uint32_t sample) {
        if (++repairs_[sample] > kMaxRepairs) return;
        std::vector<std::uint32_t> facets;
        state_.adjacent_samples(sample, neighbors);
        for (const std::uint32_t b : neighbors) {
            const auto v = surface.point_of(b);
            if (v) facets.insert(facets.end(), facets_of[*v].begin(), facets_of[*v].end());
        }
        add_largest(facets);
    };
    // Ŝ is too coarse to see what was touched.
    for (const std::uint32_t sample : surface.unused_samples(state_.sample_count())) {
        if (state_.is_known(sample)) continue;  // nobody touched it: it may lie below the object's foot
        if (!state_.is_thin_at(sample)) add_near(sample);
    }
    for (const auto& [a, b] : torn_apart(surface)) {
        add_near(a);
        add_near(b);
    }
    std::sort(found.rbegin(), found.rend());
    return found;
}

bool Repair::is_vouched(std::uint32_t sample) const {
    return std::ranges::any_of(options_.seed_rays, [&](const Segment& ray) {
        const Vector way = (ray.target - ray.source).normalized();
        const Vector to = state_.sample(sample) - ray.source;
        return (to - to.dot(way) * way).norm() <= MaintainedDelaunay::kSamePlace * state_.surroundings().region().radius() + touch_error_;
    });
}

std::vector<SamplePair> Repair::torn_apart(const RestrictedSurface& surface) const {
    const TriangleMesh& mesh = surface.mesh;
    UnionFind components(mesh.points.size());
    std::size_t count = mesh.points.size();
    const auto join = [&](std::uint32_t v, std::uint32_t w) { count -= components.join(v, w) ? 1 : 0; };
    for (const auto& t : mesh.triangles) {
        join(t[0], t[1]);
        join(t[1], t[2]);
    }
    if (count < 2) return {};
    std::vector<bool> vouched(mesh.points.size());
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        if (is_vouched(surface.sample_of[v])) vouched[components.root(v)] = true;
    }
    const auto distance = [&](const SamplePair& pair) { return (state_.sample(pair.first) - state_.sample(pair.second)).norm(); };
    std::map<std::pair<std::size_t, std::size_t>, SamplePair> nearest;  // by components
    std::vector<std::uint32_t> around;
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        const std::size_t c = components.root(v);
        state_.adjacent_samples(surface.sample_of[v], around);
        for (const std::uint32_t b : around) {
            const auto w = surface.point_of(b);
            if (!w) continue;
            const std::size_t d = components.root(*w);
            const SamplePair pair{surface.sample_of[v], b};
            if (c >= d || (vouched[c] && vouched[d]) || distance(pair) > kTorn * options_.epsilon) continue;
            const auto [known, is_new] = nearest.try_emplace({c, d}, pair);
            if (!is_new && distance(pair) < distance(known->second)) known->second = pair;
        }
    }
    std::vector<SamplePair> pairs;
    pairs.reserve(nearest.size());
    for (const auto& [of, pair] : nearest) pairs.push_back(pair);
    return pairs;
}

BadPlace Repair::named(const ThinPlace& place) const {
    if (place.thickness == 0) {
        return {place.position, "touch that no facet uses; if it is on a component of its own, give probing.seed_rays a ray to it",
                finest()};
    }
    return {place.position, fmt::format("wall or sharp edge, {:.6g} mm thick, thinner than samples there show", place.thickness),
            std::min(options_.epsilon, ThinWalls::kPerThickness * place.thickness)};
}

Repair::Findings Repair::findings(const RestrictedSurface& surface, const Topology& topology, const Effort& effort) const {
    Findings found;
    for (const Defect& defect : topology.defects) {
        constexpr std::array<const char*, 4> kWhat = {"boundary edge", "non-manifold edge", "inconsistently oriented edge", "split vertex"};
        double largest = 0;
        for (const std::uint32_t facet : defect.facets) largest = std::max(largest, surface.ball_radii[facet]);
        found.bad_places.push_back({(surface.mesh.points[defect.vertices[0]] + surface.mesh.points[defect.vertices[1]]) / 2,
                                    kWhat.at(static_cast<std::size_t>(defect.kind)), largest});
    }
    for (const ThinPlace& place : find_thin_places(state_, surface, options_.epsilon)) {
        if (place.is_minor) {
            found.thin_places.push_back(named(place));
            continue;
        }
        found.bad_places.push_back(named(place));
        found.unrepresented_touches += place.unused;
        ++found.unresolved_places;
    }
    for (const auto& [a, b] : torn_apart(surface)) {
        const double apart = (state_.sample(a) - state_.sample(b)).norm();
        found.bad_places.push_back({(state_.sample(a) + state_.sample(b)) / 2, kTornText, std::min(apart, options_.epsilon)});
        ++found.torn_components;
    }
    const std::string fruitless =
        fmt::format("work given up after {} probes, and {} more for every sample found there, that settled nothing", Effort::kTries,
                    Effort::kPerSample);
    for (const Point& place : effort.given_up()) found.bad_places.push_back({place, fruitless, finest()});
    return found;
}

}  // namespace palpate
