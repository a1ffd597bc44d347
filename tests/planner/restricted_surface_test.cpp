#include "planner/internal/restricted_surface.h"

#include <gtest/gtest.h>

#include <map>

#include "planner/internal/thin_places.h"
#include "planner/topology.h"
#include "tests/planner/probed_delaunay.h"

namespace palpate {
namespace {

// All that can be reached, known.
void explore(ProbedDelaunay& probed) {
    for (auto open = probed.open_edges(); !open.empty(); open = probed.open_edges()) {
        for (const DirectedEdge e : open) {
            if (probed.state().state(e) == EdgeState::unknown) probed.probe(e);
        }
    }
}

std::size_t edges_with_an_odd_number_of_facets(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> facets;
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) ++facets[std::minmax(t.at(k), t.at((k + 1) % 3))];
    }
    return static_cast<std::size_t>(std::ranges::count_if(facets, [](const auto& entry) { return entry.second % 2 == 1; }));
}

// Walls much thinner than the samples are apart, and solids that the samples resolve.
TEST(RestrictedSurface, EveryEdgeHasAnEvenNumberOfFacetsHoweverThinTheSolidIs) {
    std::size_t doubles = 0;
    std::size_t facets = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Random random(seed);
        Solid solid;
        for (int k = 0; k < 3; ++k) {
            const Point low = random.in_box(Point::Constant(-2), Point::Constant(0));
            Vector size = random.in_box(Point::Constant(0.5), Point::Constant(3));
            if (k < 2) size[static_cast<int>(random.below(3))] = random.uniform(0.02, 0.3);
            solid.add(Box{low, low + size});
        }
        solid.add(Ball{random.in_box(Point::Constant(-1), Point::Constant(1)), random.uniform(0.2, 1)});
        std::vector<Point> samples;
        for (int k = 0; k < 60; ++k) samples.push_back(solid.surface_point(random));
        ProbedDelaunay probed(Workspace(Ball{Point::Zero(), 6}), solid, samples);
        explore(probed);
        const RestrictedSurface surface = extract_surface(probed.state());
        EXPECT_EQ(edges_with_an_odd_number_of_facets(surface.mesh), 0U);
        doubles += doubly_crossed(probed.state()).size();
        facets += surface.mesh.triangles.size();
    }
    EXPECT_GT(doubles, 500U);
    EXPECT_GT(facets, 2000U);
}

TEST(RestrictedSurface, SamplesAreUsedOrNot) {
    RestrictedSurface surface;
    surface.sample_of = {1, 3, 4};
    EXPECT_EQ(surface.point_of(3), 1U);
    EXPECT_EQ(surface.point_of(2), std::nullopt);
    EXPECT_EQ(surface.point_of(9), std::nullopt);
    EXPECT_EQ(surface.unused_samples(6), (std::vector<std::uint32_t>{0, 2, 5}));
}

// A block, and a thin fin on its side: samples tell no sides of the fin apart.
TEST(ThinPlaces, AFinIsMinorAsLongAsItIsShortAndHangsOnTheRest) {
    const auto places = [](const Box& fin) {
        Random random(3);
        const Solid solid = Solid().add(Box{{-1, -1, -1}, {1, 1, 1}}).add(fin);
        std::vector<Point> samples;
        for (int k = 0; k < 400; ++k) samples.push_back(Solid().add(Box{{-1, -1, -1}, {1, 1, 1}}).surface_point(random));
        std::erase_if(samples, [&](const Point& p) { return solid.depth_at(p) > 1e-9; });
        for (int k = 0; k < 40; ++k) {
            const Point p = Solid().add(fin).surface_point(random);
            if (solid.depth_at(p) < 1e-9) samples.push_back(p);
        }
        ProbedDelaunay probed(Workspace(Ball{Point::Zero(), 6}), solid, samples);
        explore(probed);
        const RestrictedSurface surface = extract_surface(probed.state());
        EXPECT_EQ(edges_with_an_odd_number_of_facets(surface.mesh), 0U);
        return find_thin_places(probed.state(), surface, 0.6);
    };
    const std::vector<ThinPlace> on_block = places(Box{{0.9, -0.7, 0}, {1.4, 0.7, 0.004}});
    ASSERT_FALSE(on_block.empty());
    for (const ThinPlace& place : on_block) EXPECT_GE(place.thickness, 0.004 * (1 - 1e-9));
    EXPECT_TRUE(std::ranges::any_of(on_block, [](const ThinPlace& place) { return place.unused > 0; }));

    // Far too long, and apart.
    const std::vector<ThinPlace> long_fin = places(Box{{0.9, -0.7, 0}, {4, 0.7, 0.004}});
    EXPECT_TRUE(std::ranges::any_of(long_fin, [](const ThinPlace& place) { return !place.is_minor; }));
    const std::vector<ThinPlace> apart = places(Box{{2, -0.7, 0}, {3, 0.7, 0.004}});
    EXPECT_TRUE(std::ranges::any_of(apart, [](const ThinPlace& place) { return !place.is_minor && place.unused > 0; }));
}

}  // namespace
}  // namespace palpate
