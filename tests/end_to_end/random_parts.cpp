#include "tests/end_to_end/random_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "planner/topology.h"
#include "tests/end_to_end/part_meshes.h"
#include "tests/random.h"

namespace palpate {
namespace {

class Maker {
public:
    explicit Maker(std::uint64_t seed) : random_(seed), seed_(seed) {}

    RandomPart make() {
        static constexpr int kKinds = 11;
        part_.epsilon = uniform(0.07, 0.11);
        switch (seed_ % kKinds) {
            case 0:
                plate();
                break;
            case 1:
                tube();
                break;
            case 2:
                wedge();
                break;
            case 3:
                reflex();
                break;
            case 4:
                slot();
                break;
            case 5:
                star();
                break;
            case 6:
                gear();
                break;
            case 7:
                holes();
                break;
            case 8:
                boxes();
                break;
            case 9:
                sheets();
                break;
            default:
                spike();
                break;
        }
        if (random_.chance(0.5)) turn();
        return std::move(part_);
    }

private:
    double uniform(double low, double high) { return random_.uniform(low, high); }
    // A length about as large as epsilon.
    double thin() { return part_.feature = part_.epsilon * std::exp(uniform(std::log(0.1), std::log(3.0))); }
    int count(int low, int high) { return low + static_cast<int>(random_.below(static_cast<std::size_t>(high - low + 1))); }

    void plate() {
        part_.kind = "plate";
        part_.mesh = box({uniform(0.5, 1.0), uniform(0.5, 1.0), thin()});
    }
    void tube() {
        part_.kind = "tube";
        const double outer = uniform(0.25, 0.4);
        const int corners = count(6, 48);
        const double wall = std::min(thin(), 0.8 * outer);
        part_.feature = std::min(wall, 2 * (outer - wall) * std::cos(std::numbers::pi / corners));
        part_.mesh = extruded({regular(corners, outer), regular(corners, outer - wall)}, uniform(0.3, 0.9));
    }
    void wedge() {
        part_.kind = "wedge";
        static constexpr std::array kDegrees{60.0, 45.0, 30.0, 20.0, 10.0, 5.0, 2.0};
        const double angle = kDegrees.at(random_.below(kDegrees.size())) * std::numbers::pi / 180;
        const double length = uniform(0.5, 0.9);
        part_.feature = 0;
        part_.mesh =
            extruded({{{0, 0}, {length, -length * std::tan(angle / 2)}, {length, length * std::tan(angle / 2)}}}, uniform(0.3, 0.8));
    }
    void reflex() {
        part_.kind = "reflex corner";
        const double a = uniform(0.5, 0.9);
        const double b = uniform(0.5, 0.9);
        const double s = random_.chance(0.5) ? thin() : part_.feature = uniform(0.2, 0.4);
        const double t = uniform(0.15, 0.4);
        part_.mesh = extruded({{{0, 0}, {a, 0}, {a, s}, {t, s}, {t, b}, {0, b}}}, uniform(0.2, 0.7));
    }
    void slot() {
        part_.kind = "slot";
        const double w = thin();
        const double a = uniform(0.2, 0.35);
        const double b = uniform(0.4, 0.8);
        const double floor = uniform(0.1, 0.3);
        part_.mesh = extruded(
            {{{-w / 2 - a, 0}, {w / 2 + a, 0}, {w / 2 + a, b}, {w / 2, b}, {w / 2, floor}, {-w / 2, floor}, {-w / 2, b}, {-w / 2 - a, b}}},
            uniform(0.2, 0.6));
    }
    void star() {
        part_.kind = "star";
        const int points = count(3, 8);
        const double outer = uniform(0.35, 0.5);
        const double inner = outer * uniform(0.25, 0.7);
        part_.feature = 0;
        part_.mesh = extruded({around(2 * points, [&](int k) { return k % 2 == 0 ? outer : inner; })}, uniform(0.1, 0.5));
    }
    void gear() {
        part_.kind = "gear";
        const int teeth = count(6, 16);
        const double outer = uniform(0.35, 0.5);
        const double inner = outer * uniform(0.75, 0.9);
        part_.feature = kTwoPi * inner / (4 * teeth);
        std::vector<Polygon> polygons{around(4 * teeth, [&](int k) { return k % 4 < 2 ? outer : inner; })};
        if (random_.chance(0.5)) {
            const double bore = inner * uniform(0.2, 0.6);
            polygons.push_back(regular(24, bore));
            part_.feature = std::min({part_.feature, 2 * bore, inner - bore});
        }
        part_.mesh = extruded(polygons, uniform(0.1, 0.4));
    }
    void holes() {
        part_.kind = "plate with holes";
        const double a = uniform(0.35, 0.5);
        const double b = uniform(0.25, 0.4);
        std::vector<Polygon> polygons{{{-a, -b}, {a, -b}, {a, b}, {-a, b}}};
        const double thickness = thin();
        const int n = count(1, 3);
        for (int k = 0; k < n; ++k) {
            const double r = uniform(0.3, 0.9) * std::min(a / n, b);
            const int corners = count(3, 20);
            polygons.push_back(regular(corners, r, uniform(0, kTwoPi), a * (2.0 * k + 1 - n) / n, 0));
            // The hole, and the walls beside it.
            part_.feature = std::min({part_.feature, 2 * r * std::cos(std::numbers::pi / corners), 2 * (a / n - r), b - r});
        }
        part_.mesh = extruded(polygons, thickness);
    }
    void boxes() {
        part_.kind = "boxes";
        std::array<std::vector<double>, 3> planes;
        for (auto& axis : planes) {
            double at = 0;
            axis.push_back(at);
            for (int k = 0; k < 3; ++k) axis.push_back(at += uniform(0.1, 0.35));
        }
        part_.feature = 0.1;
        do {
            std::set<std::array<int, 3>> cells;
            std::array<int, 3> at{count(0, 2), count(0, 2), count(0, 2)};
            for (int k = 0; k < 12; ++k) {  // a walk: connected
                cells.insert(at);
                const std::size_t axis = random_.below(3);
                at.at(axis) = std::clamp(at.at(axis) + (random_.chance(0.5) ? 1 : -1), 0, 2);
            }
            part_.mesh = of_cells(planes, cells);
        } while (!analyse_topology(part_.mesh).is_closed_oriented_manifold() || analyse_topology(part_.mesh).components > 1);
    }
    void sheets() {
        part_.kind = "two sheets";
        const double gap = part_.epsilon * uniform(0.1, 1.5);
        const double t = uniform(0.1, 0.3);
        const Vector size(uniform(0.4, 0.8), uniform(0.4, 0.8), t);
        part_.mesh = box(size);
        append(part_.mesh, box(size), (gap + t) * Vector::UnitZ());
        part_.feature = gap;
        part_.seed_rays = {{{0.01, 0.02, -2}, {0.01, 0.02, 0}}, {{0.01, 0.02, 2.2}, {0.01, 0.02, gap + t}}};
    }
    void spike() {
        part_.kind = "cone";
        const bool is_needle = random_.chance(0.5);
        const double radius = is_needle ? thin() / 2 : uniform(0.15, 0.4);
        part_.feature = 0;  // at its tip
        part_.mesh = cone(count(3, 24), radius, uniform(0.5, 1.0));
    }

    void turn() {
        const Eigen::AngleAxisd by(uniform(0, kTwoPi), Vector(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized());
        const Vector at(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
        for (Point& p : part_.mesh.points) p = by * p + at;
        for (Segment& ray : part_.seed_rays) ray = {by * ray.source + at, by * ray.target + at};
    }

    Random random_;
    const std::uint64_t seed_;
    RandomPart part_;
};

}  // namespace

RandomPart random_part(std::uint64_t seed) { return Maker(seed).make(); }

}  // namespace palpate
