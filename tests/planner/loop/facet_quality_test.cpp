#include "planner/loop/facet_quality.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <set>

#include "tests/planner/delaunay/explored_torus.h"
#include "tests/planner/delaunay/probed_delaunay.h"

namespace palpate::facet_quality_test {
namespace {

constexpr std::uint64_t kSeed = 20261130;
constexpr double kSkinniest = std::numbers::pi / 6;

Options options(double epsilon) {
    Options result;
    result.epsilon = epsilon;
    return result;
}

struct Corners {
    Point a, b, c;
};
Corners corners_of(const RestrictedSurface& surface, std::uint32_t facet) {
    const auto& t = surface.mesh.triangles[facet];
    return {surface.mesh.points[t[0]], surface.mesh.points[t[1]], surface.mesh.points[t[2]]};
}

double angle_at(const Point& p, const Point& q, const Point& r) { return std::atan2((q - p).cross(r - p).norm(), (q - p).dot(r - p)); }
double smallest_angle(const Corners& t) { return std::min({angle_at(t.a, t.b, t.c), angle_at(t.b, t.c, t.a), angle_at(t.c, t.a, t.b)}); }

// By facet: the spacing that it is bad for. Each facet is named once at most.
std::map<std::uint32_t, double> bad_facets(const MaintainedDelaunay& state, const RestrictedSurface& surface, const Options& wanted,
                                           const std::vector<bool>& is_seed) {
    std::map<std::uint32_t, double> result;
    for (const BadFacet& bad : find_bad_facets(state, surface, Criteria(wanted), is_seed)) {
        EXPECT_TRUE(result.emplace(bad.facet, bad.spacing).second) << "named twice";
    }
    return result;
}

// Samples of a sphere, near each other at one side and far at the other.
class OnSphere : public ::testing::Test {
protected:
    OnSphere() : explored_(kSphere, samples()), surface_(extract_surface(explored_.state())), is_seed_(explored_.state().sample_count()) {}

    static std::vector<Point> samples() {
        Random random(kSeed);
        std::vector<Point> dense;
        for (const Point& p : ExploredTorus::spread(kSphere, 0.05, random)) {
            const double wanted = 0.05 + 0.4 * std::max(0.0, 0.5 - p.x());
            if (std::ranges::all_of(dense, [&](const Point& q) { return (p - q).norm() > wanted; })) dense.push_back(p);
        }
        return dense;
    }
    [[nodiscard]] std::map<std::uint32_t, double> bad(const Options& wanted) {
        return bad_facets(explored_.state(), surface_, wanted, is_seed_);
    }
    [[nodiscard]] std::uint32_t facets() const { return static_cast<std::uint32_t>(surface_.mesh.triangles.size()); }

    static inline const Torus kSphere = Torus::sphere(1);
    ExploredTorus explored_;
    RestrictedSurface surface_;
    std::vector<bool> is_seed_;
};

TEST_F(OnSphere, FacetsWithASmallAngleAreBadAndNoOthers) {
    SCOPED_TRACE(seed_text(kSeed));
    EXPECT_TRUE(bad(options(10)).empty()) << "not asked for";
    for (const double least : {0.8 * kSkinniest, kSkinniest}) {
        Options wanted = options(10);
        wanted.min_angle = least;
        const auto found = bad(wanted);
        std::size_t skinny = 0;
        for (std::uint32_t t = 0; t < facets(); ++t) {
            const double angle = smallest_angle(corners_of(surface_, t));
            if (std::abs(angle - least) < 1e-12) continue;
            ASSERT_EQ(found.contains(t), angle < least) << angle;
            skinny += angle < least;
            EXPECT_TRUE(!found.contains(t) || found.at(t) == Criteria(wanted).least_spacing());
        }
        EXPECT_GT(skinny, 10U);
        EXPECT_LT(skinny, facets());
    }
}

TEST_F(OnSphere, FacetsThatAreLargeForTheRadiusOfCurvatureAreBad) {
    SCOPED_TRACE(seed_text(kSeed));
    for (const double share : {0.1, 0.14}) {
        Options wanted = options(10);
        wanted.sizing.radii_of_curvature = share;
        wanted.sizing.smallest = 1e-6;
        const auto found = bad(wanted);
        std::size_t large = 0;
        std::size_t small = 0;
        for (std::uint32_t t = 0; t < facets(); ++t) {
            const double radius = surface_.ball_radii[t];
            // The radius is 1; it is estimated from neighbours, so that it may be off by that.
            if (radius > 1.6 * share) {
                ++large;
                ASSERT_TRUE(found.contains(t)) << radius;
            } else if (radius < 0.4 * share) {
                ++small;
                ASSERT_FALSE(found.contains(t)) << radius;
            }
        }
        EXPECT_GT(large, 20U);
        EXPECT_GT(small, 20U);
        for (const auto& [t, spacing] : found) EXPECT_EQ(spacing, Criteria(wanted).least_spacing());
    }
    // Nothing smaller than what was given is refined.
    Options wanted = options(10);
    wanted.sizing.radii_of_curvature = 0.05;
    wanted.sizing.smallest = 0.1;
    for (const auto& [t, spacing] : bad(wanted)) EXPECT_GT(surface_.ball_radii[t], 0.1);
    EXPECT_FALSE(bad(wanted).empty());
}

TEST_F(OnSphere, FacetsLargerThanARegionWantsAreBad) {
    SCOPED_TRACE(seed_text(kSeed));
    Options wanted = options(10);
    wanted.sizing.regions = {{Box{{0.8, -0.5, -0.5}, {1.2, 0.5, 0.5}}, 0.03, 0.2}, {Box{{-1, 0, 0}, {-1, 0, 0}}, 0.1, 1}};
    const Criteria criteria(wanted);
    const auto found = bad(wanted);
    std::set<bool> seen;
    for (std::uint32_t t = 0; t < facets(); ++t) {
        // The ball's centre is where the facet's line meets the sphere.
        const Corners f = corners_of(surface_, t);
        const Point centre = (f.b - f.a).cross(f.c - f.a).normalized();
        const double radius = (centre - f.a).norm();
        const double size = criteria.size_at(centre);
        if (std::abs(radius - size) < 1e-9) continue;
        ASSERT_EQ(found.contains(t), radius > size);
        EXPECT_TRUE(!found.contains(t) || std::abs(found.at(t) - size) < 1e-7);
        seen.insert(radius > size);
    }
    EXPECT_EQ(seen.size(), 2U);
}

TEST_F(OnSphere, FacetsAtASeedMayHaveAnyShapeButNotAnySize) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    Options wanted = options(10);
    wanted.min_angle = kSkinniest;
    wanted.sizing.radii_of_curvature = 0.05;
    wanted.sizing.smallest = 1e-6;
    const auto before = bad(wanted);
    for (std::size_t s = 0; s < is_seed_.size(); ++s) is_seed_[s] = random.chance(0.3);
    const auto after = bad(wanted);
    std::size_t exempt = 0;
    for (std::uint32_t t = 0; t < facets(); ++t) {
        const auto& corners = surface_.mesh.triangles[t];
        const bool at_seed = std::ranges::any_of(corners, [&](std::uint32_t v) { return is_seed_[surface_.sample_of[v]]; });
        ASSERT_EQ(after.contains(t), before.contains(t) && !at_seed);
        exempt += before.contains(t) && at_seed;
    }
    EXPECT_GT(exempt, 20U);
    // What is larger than ε is bad everywhere.
    const double epsilon = 0.1;
    const auto large = bad(options(epsilon));
    for (std::uint32_t t = 0; t < facets(); ++t) ASSERT_EQ(large.contains(t), surface_.ball_radii[t] > epsilon);
    EXPECT_GT(large.size(), 20U);
}

TEST_F(OnSphere, WhatIsBadDoesNotDependOnBoundaries) {
    SCOPED_TRACE(seed_text(kSeed));
    // Half of the surface: facets at its boundary have fewer neighbours to be flat against.
    RestrictedSurface half = surface_;
    half.mesh.triangles.resize(facets() / 2);
    half.dual_edges.resize(facets() / 2);
    half.ball_radii.resize(facets() / 2);
    Options wanted = options(10);
    wanted.sizing.radii_of_curvature = 0.1;
    wanted.sizing.smallest = 1e-6;
    const auto whole = bad(wanted);
    for (const auto& [t, spacing] : bad_facets(explored_.state(), half, wanted, is_seed_)) {
        ASSERT_LT(t, facets() / 2);
        EXPECT_TRUE(whole.contains(t)) << "a neighbour less shows no more curvature";
    }
}

// Samples of a box: flat but across its edges.
TEST(FacetQuality, FlatFacesAreNeverTooFlatButAcrossEdgesTheyAre) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Box box{{-1, -0.8, -0.6}, {1, 0.8, 0.6}};
    const Solid solid = Solid().add(box);
    std::vector<Point> samples;
    for (int k = 0; k < 6000; ++k) {
        const Point p = solid.surface_point(random);
        if (std::ranges::all_of(samples, [&](const Point& q) { return (p - q).norm() > 0.15; })) samples.push_back(p);
    }
    ProbedDelaunay probed(Region(Ball{Point::Zero(), 3}), solid, samples);
    for (auto open = probed.open_edges(); !open.empty(); open = probed.open_edges()) {
        for (const DirectedEdge e : open) {
            if (probed.state().state(e) == EdgeState::unknown) probed.probe(e);
        }
    }
    const RestrictedSurface surface = extract_surface(probed.state());
    const auto face_of = [&](std::uint32_t t) {
        const Corners f = corners_of(surface, t);
        for (int axis = 0; axis < 3; ++axis) {
            for (const double at : {box.min[axis], box.max[axis]}) {
                if (f.a[axis] == at && f.b[axis] == at && f.c[axis] == at) return axis * 2 + (at > 0 ? 1 : 0);
            }
        }
        return -1;  // across an edge
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> at_edge;
    for (std::uint32_t t = 0; t < surface.mesh.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            at_edge[std::minmax(surface.mesh.triangles[t].at(k), surface.mesh.triangles[t].at((k + 1) % 3))].push_back(t);
        }
    }
    std::vector<bool> is_flat(surface.mesh.triangles.size(), true);
    for (std::uint32_t t = 0; t < is_flat.size(); ++t) is_flat[t] = face_of(t) >= 0;
    for (const auto& [edge, facets] : at_edge) {
        for (const std::uint32_t t : facets) {
            for (const std::uint32_t u : facets) {
                if (face_of(t) != face_of(u)) is_flat[t] = false;
            }
        }
    }
    Options wanted = options(10);
    wanted.sizing.radii_of_curvature = 0.5;
    wanted.sizing.smallest = 1e-6;
    const auto found = bad_facets(probed.state(), surface, wanted, std::vector<bool>(probed.state().sample_count()));
    std::size_t flat = 0;
    std::size_t bent = 0;
    for (std::uint32_t t = 0; t < is_flat.size(); ++t) {
        if (is_flat[t]) {
            ++flat;
            ASSERT_FALSE(found.contains(t)) << "all of its neighbours lie in its plane";
        } else {
            bent += found.contains(t);
        }
    }
    EXPECT_GT(flat, 100U);
    EXPECT_GT(bent, 50U);
}

}  // namespace
}  // namespace palpate::facet_quality_test
