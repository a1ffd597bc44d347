#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>
#include <iterator>
#include <random>
#include <vector>

#include "planner/baselines/baselines.h"
#include "planner/baselines/internal/meter.h"

namespace palpate {

BaselineResult probe_random_rays(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes, std::uint64_t seed) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    BaselineResult result;
    Meter meter(oracle);
    std::mt19937_64 random(seed);
    std::vector<Kernel::Point_3> points;
    if (probes > 0) meter.travel({surroundings.nearest_entry(meter.at())});
    for (std::uint64_t k = 0; k < probes; ++k) {
        const Segment chord = random_chord(surroundings, random);
        if (const std::vector<Point> path = surroundings.path(meter.at(), chord.source); !path.empty()) meter.travel(path);
        const auto contact = meter.probe(chord.target);
        if (!contact) continue;
        points.emplace_back(contact->x(), contact->y(), contact->z());
        result.mesh.points.push_back(*contact);
        meter.travel({chord.source});
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
