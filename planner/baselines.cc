#include "planner/baselines.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

namespace palpate {
namespace {

// The oracle with an account of what it did.
class Meter {
public:
    explicit Meter(SurfaceOracle& oracle) : oracle_(oracle), at_(oracle.position()) {}

    void travel(const std::vector<Point>& path) {
        oracle_.travel(path, Ground::proven);
        cost_.travel += path_length(at_, path);
        at_ = path.back();
    }
    std::optional<Point> probe(const Point& target) {
        const ProbeAnswer answer = oracle_.probe(target);
        cost_.probing += (answer.position - at_).norm();
        at_ = answer.position;
        const bool contact = answer.outcome == ProbeAnswer::Outcome::contact;
        ++(contact ? cost_.contact : cost_.clear);
        return contact ? std::optional(answer.position) : std::nullopt;
    }
    [[nodiscard]] const Point& at() const { return at_; }
    [[nodiscard]] const Cost& cost() const { return cost_; }

private:
    SurfaceOracle& oracle_;
    Cost cost_;
    Point at_;
};

Vector random_direction(std::mt19937_64& random) {
    // Uniform in a ball's box until it lies in the ball.
    const auto uniform = [&] { return 2 * (static_cast<double>(random() >> 11U) * 0x1p-53) - 1; };
    while (true) {
        const double x = uniform();
        const double y = uniform();
        const double z = uniform();
        const Vector v(x, y, z);
        if (v.squaredNorm() <= 1 && v.squaredNorm() > 1e-6) return v.normalized();
    }
}

}  // namespace

BaselineResult probe_raster(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes) {
    BaselineResult result;
    const double radius = surroundings.region().radius();
    const Point low = surroundings.region().center() - Point::Constant(radius);
    const double top = surroundings.region().center().z() + radius;
    const auto at = [&](std::uint64_t i, std::uint64_t j, std::uint64_t lines) {
        const double step = 2 * radius / static_cast<double>(lines);
        return Point(low.x() + (static_cast<double>(i) + 0.5) * step, low.y() + (static_cast<double>(j) + 0.5) * step, top);
    };
    const auto meets = [&](const Point& p) { return surroundings.unknown_part(p, -Vector::UnitZ()).has_value(); };
    // The finest grid that the number of probes allows.
    std::uint64_t lines = 0;
    for (std::uint64_t count = 0; count <= probes; ++lines) {
        count = 0;
        for (std::uint64_t i = 0; i <= lines; ++i) {
            for (std::uint64_t j = 0; j <= lines; ++j) count += meets(at(i, j, lines + 1)) ? 1 : 0;
        }
        if (count > probes) break;
    }
    if (lines == 0) return result;
    Meter meter(oracle);
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> touched(lines * lines, kNone);
    for (std::uint64_t i = 0; i < lines; ++i) {
        for (std::uint64_t k = 0; k < lines; ++k) {
            const std::uint64_t j = i % 2 == 0 ? k : lines - 1 - k;
            const Point start = at(i, j, lines);
            if (!meets(start)) continue;
            if (meter.at() != start) meter.travel({start});
            const auto contact = meter.probe({start.x(), start.y(), low.z()});
            if (contact) {
                touched[i * lines + j] = static_cast<std::uint32_t>(result.mesh.points.size());
                result.mesh.points.push_back(*contact);
            }
            meter.travel({start});
        }
    }
    for (std::uint64_t i = 0; i + 1 < lines; ++i) {
        for (std::uint64_t j = 0; j + 1 < lines; ++j) {
            const std::array<std::uint32_t, 4> corners{touched[i * lines + j], touched[(i + 1) * lines + j],
                                                       touched[(i + 1) * lines + j + 1], touched[i * lines + j + 1]};
            std::vector<std::uint32_t> known;
            for (const std::uint32_t corner : corners) {
                if (corner != kNone) known.push_back(corner);
            }
            if (known.size() >= 3) result.mesh.triangles.push_back({known[0], known[1], known[2]});
            if (known.size() == 4) result.mesh.triangles.push_back({known[0], known[2], known[3]});
        }
    }
    result.cost = meter.cost();
    return result;
}

BaselineResult probe_random_rays(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes, std::uint64_t seed) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    BaselineResult result;
    Meter meter(oracle);
    std::mt19937_64 random(seed);
    std::vector<Kernel::Point_3> points;
    if (probes > 0) meter.travel({surroundings.nearest_entry(meter.at())});
    for (std::uint64_t k = 0; k < probes;) {
        // A uniform direction, and a uniform point of the disc across it.
        const Vector direction = random_direction(random);
        const Vector across = direction.unitOrthogonal();
        const double angle = 2 * std::numbers::pi * (static_cast<double>(random() >> 11U) * 0x1p-53);
        const double distance = surroundings.region().radius() * std::sqrt(static_cast<double>(random() >> 11U) * 0x1p-53);
        const Point through =
            surroundings.region().center() + distance * (std::cos(angle) * across + std::sin(angle) * direction.cross(across));
        const auto chord = surroundings.unknown_part(through, direction);
        if (!chord) continue;
        ++k;
        const Point entry = through + chord->low * direction;
        if (const std::vector<Point> path = surroundings.path(meter.at(), entry); !path.empty()) meter.travel(path);
        const auto contact = meter.probe(through + chord->high * direction);
        if (!contact) continue;
        points.emplace_back(contact->x(), contact->y(), contact->z());
        result.mesh.points.push_back(*contact);
        meter.travel({entry});
    }
    if (points.size() >= 4) {
        std::vector<std::array<std::size_t, 3>> facets;
        CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(), std::back_inserter(facets));
        for (const auto& f : facets) {
            result.mesh.triangles.push_back(
                {static_cast<std::uint32_t>(f[0]), static_cast<std::uint32_t>(f[1]), static_cast<std::uint32_t>(f[2])});
        }
    }
    result.cost = meter.cost();
    return result;
}

}  // namespace palpate
