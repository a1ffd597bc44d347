#include "planner/delaunay/restricted_surface.h"

#include <gtest/gtest.h>

#include <map>

#include "planner/loop/thin_places.h"
#include "planner/topology.h"
#include "tests/planner/delaunay/explored_torus.h"
#include "tests/planner/delaunay/probed_delaunay.h"

namespace palpate::restricted_surface_test {
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
        ProbedDelaunay probed(Region(Ball{Point::Zero(), 6}), solid, samples);
        explore(probed);
        const RestrictedSurface surface = extract_surface(probed.state());
        EXPECT_EQ(edges_with_an_odd_number_of_facets(surface.mesh), 0U);
        doubles += doubly_crossed(probed.state()).size();
        facets += surface.mesh.triangles.size();
    }
    EXPECT_GT(doubles, 500U);
    EXPECT_GT(facets, 2000U);
}

// Where all is explored, Ŝ is what the definition says: the facets whose dual edge the surface passes an odd number of times, from a free
// end that is reached. What the tool meets first on its way from there is all that is known of them.
struct Counted {
    std::size_t odd = 0;        // in Ŝ
    std::size_t twice = 0;      // passed an even number of times, and not in it
    std::size_t unreached = 0;  // would be in Ŝ
};

void expect_facet(const Torus& torus, const MaintainedDelaunay& state, const RestrictedSurface& surface, std::size_t t,
                  const EdgeSpan& along, const std::vector<double>& at) {
    const bool from_start = torus.distance(along.start_point()) > 0;
    const Vector onwards = (along.end_point() - along.start_point()).normalized();
    const Point crossing = along.start_point() + (from_start ? at.front() : at.back()) * onwards;
    const auto& corners = surface.mesh.triangles[t];
    const Point& a = surface.mesh.points[corners[0]];
    ASSERT_NEAR(surface.ball_radii[t], (crossing - a).norm(), 1e-9);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Point& p : state.samples()) nearest = std::min(nearest, (p - crossing).norm());
    ASSERT_NEAR(surface.ball_radii[t], nearest, 1e-9) << "the ball holds a sample";
    ASSERT_LE((state.crossing(surface.dual_edges[t]).near - crossing).norm(), 1e-9);
    const Vector normal = (surface.mesh.points[corners[1]] - a).cross(surface.mesh.points[corners[2]] - a);
    ASSERT_GT((from_start ? -1 : 1) * onwards.dot(normal), 0) << "the free side is not outside";
}

void expect_defined_surface(ExploredTorus& explored, const RestrictedSurface& surface, Counted& counted) {
    const Torus& torus = explored.torus();
    MaintainedDelaunay& state = explored.state();
    ASSERT_EQ(surface.dual_edges.size(), surface.mesh.triangles.size());
    ASSERT_EQ(surface.ball_radii.size(), surface.mesh.triangles.size());
    std::map<std::array<std::uint32_t, 3>, std::size_t> facets;
    for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = surface.mesh.triangles[t];
        const std::array<std::uint32_t, 3> samples{surface.sample_of[a], surface.sample_of[b], surface.sample_of[c]};
        ASSERT_TRUE(facets.emplace(in_order(samples), t).second) << "a facet twice";
        for (const std::uint32_t v : {a, b, c}) ASSERT_EQ(surface.mesh.points[v], state.sample(surface.sample_of[v]));
    }
    const std::size_t before = counted.odd;
    explored.state().for_each_edge([&](DirectedEdge e) {
        if (testing::Test::HasFatalFailure() || !state.is_finite(e) || e.cell > state.neighbor(e)) return;
        const auto along = state.span(e);
        const std::vector<double> at = along ? torus.crossings(along->start_point(), along->end_point()) : std::vector<double>{};
        const bool is_odd = at.size() % 2 == 1;
        const bool is_reached = is_odd && state.is_free(torus.distance(along->start_point()) > 0 ? e.cell : state.neighbor(e));
        const auto found = facets.find(in_order(state.facet_samples(e)));
        ASSERT_EQ(found != facets.end(), is_reached) << at.size() << " crossings";
        counted.unreached += is_odd && !is_reached;
        counted.twice += !at.empty() && !is_odd;
        if (found == facets.end()) return;
        ++counted.odd;
        expect_facet(torus, state, surface, found->second, *along, at);
    });
    EXPECT_EQ(counted.odd - before, facets.size());
    EXPECT_EQ(edges_with_an_odd_number_of_facets(surface.mesh), 0U);
}

TEST(RestrictedSurface, OfAnExploredSurfaceIsWhatCountingAllCrossingsGives) {
    for (const Torus& torus : {Torus::sphere(1), Torus{1, 0.4}, Torus{1, 0.55}}) {
        for (const double spacing : {0.25, 0.45}) {  // of the minor radius
            SCOPED_TRACE(seed_text(31) + ", spacing " + std::to_string(spacing) + " of " + std::to_string(torus.minor));
            Random random(31);
            ExploredTorus explored(torus, ExploredTorus::spread(torus, spacing * torus.minor, random));
            const RestrictedSurface surface = extract_surface(explored.state());
            Counted counted;
            expect_defined_surface(explored, surface, counted);
            if (HasFatalFailure()) return;
            EXPECT_EQ(counted.unreached, 0U);
            const Topology topology = analyse_topology(surface.mesh);
            EXPECT_TRUE(topology.is_closed_oriented_manifold());
            EXPECT_EQ(topology.euler_characteristic, torus.euler_characteristic());
            EXPECT_EQ(topology.components, 1U);
            EXPECT_EQ(surface.mesh.points.size(), explored.state().sample_count());
        }
    }
}

TEST(RestrictedSurface, OfFarTooFewSamplesIsStillThat) {
    Counted counted;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Random random(seed);
        const Torus torus{1, random.uniform(0.1, 0.6)};
        std::vector<Point> samples;
        for (int k = 0; k < 16; ++k) samples.push_back(torus.random_place(random).point);
        ExploredTorus explored(torus, samples);
        expect_defined_surface(explored, extract_surface(explored.state()), counted);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(counted.odd, 500U);
    EXPECT_GT(counted.twice, 100U);
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
        ProbedDelaunay probed(Region(Ball{Point::Zero(), 6}), solid, samples);
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
}  // namespace palpate::restricted_surface_test
