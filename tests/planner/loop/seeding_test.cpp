#include "planner/loop/seeding.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "planner/errors.h"
#include "tests/planner/support.h"

namespace palpate::seeding_test {
namespace {

constexpr std::uint64_t kSeed = 20240618;

// The largest angle (rad) from any direction to the nearest of the first n, by sampling directions.
double covering_radius(int n) {
    Random random(kSeed);
    double worst = 0;
    for (int k = 0; k < 20000; ++k) {
        const Vector u = random.direction();
        double best = -1;
        for (int i = 0; i < n; ++i) best = std::max(best, u.dot(spread_direction(i)));
        worst = std::max(worst, std::acos(std::min(best, 1.0)));
    }
    return worst;
}

TEST(SpreadDirection, EveryBeginningCoversTheSphere) {
    // n caps of angle r that cover the sphere have at least its area: n(1 - cos r)/2 >= 1. The best arrangements need about
    // 1.2 times that angle, random ones about 2.5 times.
    for (const int n : {4, 16, 64, 256}) {
        const double least = std::acos(std::max(-1.0, 1 - 2.0 / n));
        EXPECT_LE(covering_radius(n), 2.25 * least) << n;
    }
    EXPECT_LE(covering_radius(64), 0.5);
}

TEST(SpreadDirection, UnitAndAllDifferent) {
    std::vector<Vector> seen;
    for (int k = 0; k < 256; ++k) {
        const Vector u = spread_direction(k);
        ASSERT_NEAR(u.norm(), 1, 1e-14);
        for (const Vector& v : seen) ASSERT_GT((u - v).norm(), 0.02);
        ASSERT_EQ(u, spread_direction(k));
        seen.push_back(u);
    }
    for (int k = 0; k < 1000000; k += 997) ASSERT_NEAR(spread_direction(k).norm(), 1, 1e-14);
}

// Everything that seeding needs, with a solid to touch.
struct Bench {
    Region workspace;
    Solid solid;
    Options options;
    SolidOracle oracle;
    ProbedSpace space;
    MaintainedDelaunay& state = space.delaunay();
    ProbeHead head;

    Bench(const Region& w, const Solid& s, double epsilon, const std::vector<Segment>& rays = {})
        : workspace(w),
          solid(s),
          oracle(s, w.center() + 3 * w.radius() * Vector::UnitZ()),
          space(workspace),
          head(oracle, workspace, space.roadmap()) {
        options.epsilon = epsilon;
        options.seed_rays = rays;
    }

    std::vector<SeedFacet> seed() { return touch_seeds(options, space, head); }

    [[nodiscard]] std::string error() {
        try {
            seed();
        } catch (const SeedError& e) {
            return e.what();
        }
        return "";
    }

    // The facet's directed edge that holds the seed's contact.
    [[nodiscard]] std::optional<DirectedEdge> touched_edge(const SeedFacet& facet) const {
        const auto e = state.find_facet(facet.samples[0], facet.samples[1], facet.samples[2]);
        if (!e) return std::nullopt;
        if (state.recorded_state(*e) == EdgeState::crossing) return e;
        if (state.recorded_state(state.opposite(*e)) == EdgeState::crossing) return state.opposite(*e);
        return std::nullopt;
    }

    // The contract of a seed facet, on a ball.
    void expect_persistent(const SeedFacet& facet, const Ball& ball) {
        const double epsilon = options.epsilon;
        for (const std::uint32_t a : facet.samples) {
            ASSERT_NEAR((state.sample(a) - ball.center).norm(), ball.radius, 1e-9 * workspace.radius());
            for (const std::uint32_t b : facet.samples) ASSERT_LE((state.sample(a) - state.sample(b)).norm(), epsilon / 3);
            ASSERT_LT(facet.approach.dot(state.sample(a) - ball.center), 0) << "the approach is not from outside";
        }
        ASSERT_NEAR(facet.approach.norm(), 1, 1e-12);
        const auto e = touched_edge(facet);
        ASSERT_TRUE(e);
        const Crossing& c = state.crossing(*e);
        ASSERT_LT(c.ball_radius, epsilon / 2);
        ASSERT_NEAR((c.near - ball.center).norm(), ball.radius, 1e-9 * workspace.radius());
        ASSERT_NEAR((c.near - state.sample(facet.samples[0])).norm(), c.ball_radius, 1e-9 * workspace.radius());
        ASSERT_TRUE(c.from_vertex);
        ASSERT_TRUE(state.is_free(e->cell));
        // The free side is outside: facet_samples is counter-clockwise from there.
        const auto f = state.facet_samples(*e);
        const Vector normal = (state.sample(f[1]) - state.sample(f[0])).cross(state.sample(f[2]) - state.sample(f[0]));
        ASSERT_GT(normal.dot(state.sample(f[0]) - ball.center), 0);
        ASSERT_EQ(head.touches()[c.touch].position, c.near);
    }

    void expect_good_bookkeeping() {
        std::string why;
        ASSERT_TRUE(state.is_valid(&why)) << why;
        ASSERT_EQ(head.cost().seed, head.cost().probes());
        ASSERT_EQ(head.cost().contact, oracle.contacts);
        ASSERT_NEAR(head.cost().travel, oracle.travel_length, 1e-9 * oracle.travel_length);
        for (const Segment& s : oracle.travels)
            ASSERT_FALSE(solid.meets(s.source, s.target, 1e-9 * workspace.radius())) << "travelled through the object";
        // Every sample is a touch that knows it.
        std::vector<bool> assigned(state.sample_count());
        for (const Touch& touch : head.touches()) {
            if (!touch.sample) continue;
            ASSERT_TRUE(touch.role == Touch::Role::seed || touch.role == Touch::Role::seed_facet);
            ASSERT_EQ(touch.position, state.sample(*touch.sample));
            ASSERT_FALSE(assigned[*touch.sample]);
            assigned[*touch.sample] = true;
        }
        for (const bool done : assigned) ASSERT_TRUE(done);
    }
};

TEST(Seeding, ASphereGetsOnePersistentFacetFromRaysTowardsTheCentre) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int k = 0; k < 60; ++k) {
        const Ball ball{random.uniform(0, 1.5) * random.direction(), random.uniform(0.5, 1.4)};
        const double epsilon = ball.radius * std::pow(10, random.uniform(-2, -0.5));
        const Region workspace = k % 2 == 0 ? Region(Ball{{0, 0, 0}, 3}) : Region(Box{{-3, -3, -3}, {3, 3, 3.5}});
        SCOPED_TRACE("number " + std::to_string(k));
        Bench bench(workspace, Solid().add(ball), epsilon);
        const std::vector<SeedFacet> facets = bench.seed();
        ASSERT_EQ(facets.size(), 1U);
        ASSERT_GE(bench.state.sample_count(), 4U);
        bench.expect_persistent(facets[0], ball);
        if (HasFatalFailure()) return;
        bench.expect_good_bookkeeping();
        if (HasFatalFailure()) return;
        // First touches keep their distance; only the two that make the facet's first touch a triangle are exempt.
        const auto exempt = [&](std::uint32_t s) { return s == facets[0].samples[1] || s == facets[0].samples[2]; };
        for (std::uint32_t s = 0; s < bench.state.sample_count(); ++s) {
            for (std::uint32_t r = 0; r < s; ++r) {
                if (exempt(s) || exempt(r)) continue;
                ASSERT_GT((bench.state.sample(s) - bench.state.sample(r)).norm(), epsilon);
            }
        }
    }
}

TEST(Seeding, EveryUserRayGetsItsOwnFacet) {
    const Ball left{{-1.5, 0, 0}, 1};
    const Ball right{{1.5, 0.3, 0}, 0.8};
    const Region workspace(Ball{{0, 0, 0}, 4});
    Bench bench(workspace, Solid().add(left).add(right), 0.2, {{{-1.2, 0, 5}, {-1.2, 0, -5}}, {{1.5, 6, 0}, {1.5, 0.3, 0}}});
    const auto facets = bench.seed();
    ASSERT_EQ(facets.size(), 2U);
    bench.expect_persistent(facets[0], left);
    bench.expect_persistent(facets[1], right);
    bench.expect_good_bookkeeping();
    EXPECT_TRUE(facets[0].approach.isApprox(-Vector::UnitZ(), 1e-12));
    EXPECT_TRUE(facets[1].approach.isApprox(-Vector::UnitY(), 1e-12));
}

TEST(Seeding, TheSameRayTwiceIsOneSeed) {
    const Segment ray{{0.2, 0.1, 5}, {0.2, 0.1, 0}};
    const Ball ball{{0, 0, 0}, 1};
    Bench bench(Region(Ball{{0, 0, 0}, 3}), Solid().add(ball), 0.2, {ray, ray});
    const auto facets = bench.seed();
    ASSERT_EQ(facets.size(), 1U);
    bench.expect_persistent(facets[0], ball);
    bench.expect_good_bookkeeping();
}

TEST(Seeding, ARayThatTouchesNothingIsNamed) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    const Solid solid = Solid().add(Ball{{0, 0, 0}, 1});
    const Segment good{{0, 0, 5}, {0, 0, 0}};
    const std::vector<Segment> bad = {
        {{2, 0, 5}, {2, 0, -5}},    // beside the object
        {{0, 7, 5}, {0, 7, -5}},    // beside the workspace
        {{0, 0, 5}, {0, 0, 1.25}},  // ends before the object
        {{0, 0, 5}, {0, 0, 4}},     // ends before the workspace
    };
    for (const Segment& ray : bad) {
        const std::string error = Bench(workspace, solid, 0.2, {good, ray}).error();
        EXPECT_NE(error.find("seed ray 2"), std::string::npos) << error;
        EXPECT_NE(error.find("probing.seed_rays"), std::string::npos) << error;
        std::ostringstream place;
        place << "from (" << ray.source.x() << ", " << ray.source.y() << ", " << ray.source.z() << ") to (" << ray.target.x() << ", "
              << ray.target.y() << ", " << ray.target.z() << ")";
        EXPECT_NE(error.find(place.str()), std::string::npos) << error;
    }
}

TEST(Seeding, ARayIsNotProlongedBackwards) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    const Solid solid = Solid().add(Ball{{0, 0, 0}, 1});
    EXPECT_NE(Bench(workspace, solid, 0.2, {{{5, 0, 0}, {6, 0, 0}}}).error().find("touches nothing"), std::string::npos)
        << "it points away";
    for (const Segment& inside : {Segment{{0, 0, 2}, {0, 0, 0}}, Segment{{0, 0, 0}, {0, 0, 3}}}) {
        EXPECT_NE(Bench(workspace, solid, 0.2, {inside}).error().find("starts inside the workspace"), std::string::npos);
    }
}

TEST(Seeding, TwoRaysThatTouchNearlyTheSamePlaceAreNotTakenForOne) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    const Solid solid = Solid().add(Ball{{0, 0, 0}, 1});
    const Segment ray{{0, 0, 5}, {0, 0, 0}};
    EXPECT_EQ(Bench(workspace, solid, 0.2, {ray, ray}).error(), "") << "the same ray twice does no harm";
    EXPECT_NE(Bench(workspace, solid, 0.2, {ray, {{0.15, 0, 5}, {0.15, 0, 0}}}).error().find("nearer than epsilon"), std::string::npos);
}

TEST(Seeding, AnObjectBesideAllRaysIsAnErrorThatSaysWhatToGive) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    // A small ball in the widest gap between the lines towards the centre.
    Random random(kSeed);
    Vector gap = Vector::UnitX();
    double widest = 0;
    for (int k = 0; k < 3000; ++k) {
        const Vector u = random.direction();
        double nearest = 1;
        for (int i = 0; i < 256; ++i) nearest = std::min(nearest, u.cross(spread_direction(i)).norm());
        if (nearest > widest) {
            widest = nearest;
            gap = u;
        }
    }
    const Solid solid = Solid().add(Ball{2 * gap, 1.9 * widest});
    const std::string error = Bench(workspace, solid, 0.01).error();
    EXPECT_NE(error.find("probing.seed_rays"), std::string::npos) << error;
    EXPECT_NE(error.find("256"), std::string::npos) << error;
    // And with what it asks for, it works.
    Bench told(workspace, solid, 0.01, {{4 * gap, 2 * gap}});
    EXPECT_EQ(told.error(), "");
}

TEST(Seeding, AnObjectTooSmallForEpsilonIsAnErrorThatSaysSo) {
    const Solid solid = Solid().add(Ball{{0.01, 0, 0}, 0.1});
    const std::string error = Bench(Region(Ball{{0, 0, 0}, 3}), solid, 1).error();
    EXPECT_NE(error.find("epsilon"), std::string::npos) << error;
    EXPECT_NE(error.find("too small"), std::string::npos) << error;
    EXPECT_EQ(Bench(Region(Ball{{0, 0, 0}, 3}), solid, 0.03).error(), "");
}

TEST(Seeding, SharpBoxGetsASeedFacetOnAFace) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int k = 0; k < 20; ++k) {
        const Point low = random.in_box(Point::Constant(-1.2), Point::Constant(-0.3));
        const Point high = random.in_box(Point::Constant(0.3), Point::Constant(1.2));
        Bench bench(Region(Ball{{0, 0, 0}, 4}), Solid().add(Box{low, high}), 0.1);
        const auto facets = bench.seed();
        ASSERT_EQ(facets.size(), 1U);
        const auto e = bench.touched_edge(facets[0]);
        ASSERT_TRUE(e);
        ASSERT_LT(bench.state.crossing(*e).ball_radius, 0.05);
        bench.expect_good_bookkeeping();
        if (HasFatalFailure()) return;
    }
}

}  // namespace
}  // namespace palpate::seeding_test
