#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh_default_criteria_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "planner/baselines/baselines.h"
#include "planner/baselines/internal/implicit_process.h"
#include "planner/baselines/internal/meter.h"

namespace palpate {
namespace {

// All lengths are parts of the radius of the ball around ω.
// Before and behind a touch, along the estimated normal, the distance to S is about that ...
constexpr double kStep = 0.03;
// ... but not quite while the estimate is coarse. For a mesh the normals are estimated again from all touches.
constexpr double kStepError = 0.3 * kStep;
constexpr double kFineStepError = 0.05 * kStep;
constexpr int kRounds = 2;
constexpr double kTouchError = 1e-5;
// On the ball itself S is far away, nobody knows how far.
constexpr double kFar = 0.3;
constexpr double kFarError = 0.2;
constexpr int kFarPlaces = 32;

// The next touch: of places where as many lines as that cross the estimated surface, looked at in as many steps, those that are farthest
// from all touches, and of these the least certain one.
constexpr int kLines = 40;
constexpr int kSteps = 24;
constexpr int kHalvings = 14;
constexpr std::size_t kCandidates = 16;

// Facets of the mesh: what they leave of the surface is below what touches leave. The distance is for one touch.
constexpr double kLeastAngle = 20.0;  // degrees
constexpr double kFacetRadius = 0.06;
constexpr double kFacetDistance = 0.2;
// Far below that: facets between points that are farther off are never near enough.
constexpr double kOnSurface = 1e-5;

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using Function = std::function<double(const Traits::Point_3&)>;

class Explorer {
public:
    Explorer(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t seed)
        : surroundings_(surroundings),
          bound_{surroundings.region().center(), surroundings.region().radius()},
          process_(bound_),
          meter_(oracle),
          random_(seed) {
        add_far(process_);
    }

    void probe() {
        const Segment chord = next();
        const Vector along = (chord.target - chord.source).normalized();
        if (const std::vector<Point> path = surroundings_.path(meter_.at(), chord.source); !path.empty()) meter_.travel(path);
        if (const auto contact = meter_.probe(chord.target)) {
            touched_.push_back(*contact);
            process_.add(*contact, 0, kTouchError * bound_.radius);
            const Vector up = process_.gradient(*contact).normalized();
            add_beside(process_, *contact, up.dot(along) < 0 ? up : Vector(-along), kStepError);
            meter_.travel({chord.source});
        } else if (expected_) {
            // S was thought to be there.
            process_.add(*expected_, kStep * bound_.radius, kStep * bound_.radius);
        }
    }

    [[nodiscard]] BaselineResult result() const { return {mesh_of(refined()), meter_.cost()}; }

private:
    // From each side of every axis first, until the process has seen inside and outside.
    [[nodiscard]] Segment next() {
        expected_.reset();
        const auto made = static_cast<int>(meter_.cost().probes());
        if (made < 6) {
            const Vector out = (made % 2 == 0 ? 1.0 : -1.0) * Vector::Unit(made / 2);
            return chord_through(bound_.center, -out);
        }
        const std::vector<Point> candidates = farthest(crossings());
        if (candidates.empty()) return random_chord(surroundings_, random_);
        const std::vector<double> variances = process_.variances(candidates);
        expected_ = candidates[static_cast<std::size_t>(std::ranges::max_element(variances) - variances.begin())];
        const Vector up = process_.gradient(*expected_);
        return chord_through(*expected_, up.norm() > 0 ? Vector(-up.normalized()) : Vector(-Vector::UnitZ()));
    }
    [[nodiscard]] Segment chord_through(const Point& p, const Vector& direction) {
        const auto chord = surroundings_.unknown_part(p, direction);
        if (!chord) return random_chord(surroundings_, random_);
        return {p + chord->low * direction, p + chord->high * direction};
    }
    // Where random lines cross the estimated surface.
    [[nodiscard]] std::vector<Point> crossings() {
        std::vector<Point> found;
        for (int line = 0; line < kLines; ++line) {
            const Segment chord = random_chord(surroundings_, random_);
            Point low = chord.source;
            double before = process_.mean(low);
            for (int k = 1; k <= kSteps; ++k) {
                const Point high = chord.source + static_cast<double>(k) / kSteps * (chord.target - chord.source);
                const double here = process_.mean(high);
                if ((before < 0) != (here < 0)) found.push_back(crossing(low, high, before < 0));
                low = high;
                before = here;
            }
        }
        return found;
    }
    [[nodiscard]] Point crossing(Point low, Point high, bool is_low_inside) const {
        for (int k = 0; k < kHalvings; ++k) {
            const Point middle = 0.5 * (low + high);
            ((process_.mean(middle) < 0) == is_low_inside ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }
    [[nodiscard]] std::vector<Point> farthest(const std::vector<Point>& places) const {
        std::vector<std::pair<double, std::size_t>> order;
        for (std::size_t k = 0; k < places.size(); ++k) {
            double least = std::numeric_limits<double>::infinity();
            for (const Point& touch : touched_) least = std::min(least, (touch - places[k]).squaredNorm());
            order.emplace_back(-least, k);
        }
        std::ranges::sort(order);
        std::vector<Point> chosen;
        for (std::size_t k = 0; k < std::min(kCandidates, order.size()); ++k) chosen.push_back(places[order[k].second]);
        return chosen;
    }

    void add_far(ImplicitProcess& process) const {
        for (int k = 0; k < kFarPlaces; ++k) {  // evenly, on a spiral
            const double z = 1 - (2 * k + 1.0) / kFarPlaces;
            const double angle = std::numbers::pi * (3 - std::sqrt(5.0)) * k;
            const Vector direction(std::cos(angle) * std::sqrt(1 - z * z), std::sin(angle) * std::sqrt(1 - z * z), z);
            process.add(bound_.center + bound_.radius * direction, kFar * bound_.radius, kFarError * bound_.radius);
        }
    }
    void add_beside(ImplicitProcess& process, const Point& touch, const Vector& up, double error) const {
        const double step = kStep * bound_.radius;
        process.add(touch + step * up, step, error * bound_.radius);
        process.add(touch - step * up, -step, error * bound_.radius);
    }
    [[nodiscard]] ImplicitProcess refined() const {
        ImplicitProcess process = process_;
        for (int round = 0; round < kRounds; ++round) {
            ImplicitProcess next(bound_);
            add_far(next);
            for (const Point& touch : touched_) {
                next.add(touch, 0, kTouchError * bound_.radius);
                add_beside(next, touch, process.gradient(touch).normalized(), kFineStepError);
            }
            process = std::move(next);
        }
        return process;
    }

    // CGAL's Delaunay refinement of the process' zero, from the touches on, which lie on it.
    [[nodiscard]] TriangleMesh mesh_of(const ImplicitProcess& process) const {
        TriangleMesh mesh;
        if (touched_.size() < 4) return mesh;
        const Function function = [&](const Traits::Point_3& p) { return process.mean({p.x(), p.y(), p.z()}); };
        const Point& c = bound_.center;
        const double radius = bound_.radius;
        const Traits::Sphere_3 sphere(Traits::Point_3(c.x(), c.y(), c.z()), radius * radius);
        const CGAL::Implicit_surface_3<Traits, Function> surface(function, sphere, kOnSurface);
        const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(kLeastAngle, kFacetRadius * radius,
                                                                            kFacetDistance / static_cast<double>(touched_.size()) * radius);
        Triangulation triangulation;
        for (const Point& p : touched_) triangulation.insert(Traits::Point_3(p.x(), p.y(), p.z()));
        Complex complex(triangulation);
        CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Non_manifold_tag(), 0);

        std::map<Triangulation::Vertex_handle, std::uint32_t> numbers;
        for (auto f = complex.facets_begin(); f != complex.facets_end(); ++f) {
            std::array<std::uint32_t, 3> corners{};
            for (int k = 0; k < 3; ++k) {
                const Triangulation::Vertex_handle v = f->first->vertex((f->second + k + 1) % 4);
                const auto [place, is_new] = numbers.try_emplace(v, static_cast<std::uint32_t>(mesh.points.size()));
                if (is_new) mesh.points.emplace_back(v->point().x(), v->point().y(), v->point().z());
                corners[static_cast<std::size_t>(k)] = place->second;
            }
            const auto [p, q, r] = corners;
            const Vector normal = (mesh.points[q] - mesh.points[p]).cross(mesh.points[r] - mesh.points[p]);
            const Point middle = (mesh.points[p] + mesh.points[q] + mesh.points[r]) / 3;
            mesh.triangles.push_back(normal.dot(process.gradient(middle)) < 0 ? std::array{p, r, q} : corners);
        }
        return mesh;
    }

    const Surroundings& surroundings_;
    const Ball bound_;
    ImplicitProcess process_;
    Meter meter_;
    std::mt19937_64 random_;
    std::vector<Point> touched_;
    std::optional<Point> expected_;  // where the next touch should meet S
};

}  // namespace

BaselineResult probe_gaussian_process(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes, std::uint64_t seed) {
    Explorer explorer(oracle, surroundings, seed);
    for (std::uint64_t k = 0; k < probes; ++k) explorer.probe();
    return explorer.result();
}

}  // namespace palpate
