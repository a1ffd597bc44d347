// The curved surface of whole runs: how far the objects are from it, and whether its uncertainty holds (planner/curved/README.md).
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <random>

#include "planner/curved/curved_surface.h"
#include "planner/part/internal/facet_tree.h"
#include "sim/objects/crofton.h"
#include "sim/truth.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::curved_test {
namespace {

struct Case {
    std::string subject;
    double epsilon;
    double gain;           // the 99 % distance falls by that at least
    double least_covered;  // % of the places, within the stated uncertainty; a sphere errs alike everywhere, about by what is stated
};

class Curved : public ::testing::TestWithParam<Case> {};

TEST_P(Curved, IsNearerToTheObjectThanTheMeshAndKnowsHowNear) {
    const Case& c = GetParam();
    const FinishedRun run(subject(c.subject), c.epsilon, Strategy::adaptive());
    const TriangleMesh& mesh = run.result().mesh;
    const std::clock_t start = std::clock();
    const CurvedSurface surface = curve({mesh, {}, {}}, {.epsilon = c.epsilon});
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const Topology topology = analyse_topology(surface.mesh);
    EXPECT_TRUE(topology.is_closed_oriented_manifold());
    EXPECT_EQ(topology.euler_characteristic, run.result().topology.euler_characteristic);

    constexpr std::size_t kPlaces = 30'000;
    const SurfaceDistances plain = measure_surface(run.object(), mesh, kPlaces, 1);
    const SurfaceDistances curved = measure_surface(run.object(), surface.mesh, kPlaces, 1);
    std::mt19937_64 random(2);
    const FacetTree tree(surface.mesh);
    std::size_t covered = 0;
    const std::vector<Point> places = sample_surface(run.object(), kPlaces, random).points;
    for (const Point& p : places) {
        const FacetPlace place = tree.nearest(p);
        double stated = 1e-12;
        for (std::size_t k = 0; k < 3; ++k) {
            stated += place.share[static_cast<Eigen::Index>(k)] * surface.uncertainty[surface.mesh.triangles[place.facet][k]];
        }
        covered += place.distance <= stated ? 1 : 0;
    }
    const double share = 100.0 * static_cast<double>(covered) / static_cast<double>(places.size());
    std::printf("| %s, %g | %zu | %.2g; %.2g | %.2g; %.2g | %.1f %% | %.2g |\n", c.subject.c_str(), c.epsilon, mesh.points.size(),
                plain.p99, plain.max, curved.p99, curved.max, share, seconds);
    EXPECT_LT(curved.p99 * c.gain, plain.p99);
    EXPECT_LT(curved.max, plain.max);
    EXPECT_GE(share, c.least_covered);
}

INSTANTIATE_TEST_SUITE_P(Objects, Curved,
                         ::testing::Values(Case{"torus", 0.1, 25, 93}, Case{"torus", 0.14, 25, 93}, Case{"torus", 0.2, 20, 93},
                                           Case{"sphere", 0.16, 20, 80}, Case{"ellipsoid", 0.16, 15, 93}, Case{"genus2", 0.08, 6, 93},
                                           Case{"rounded_box", 0.1, 2, 93}, Case{"bunny", 0.25, 1.1, 93}),
                         [](const auto& test) {
                             return test.param.subject + "_" + std::to_string(static_cast<int>(test.param.epsilon * 1000 + 0.5));
                         });

}  // namespace
}  // namespace palpate::curved_test
