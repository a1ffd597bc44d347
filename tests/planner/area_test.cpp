#include "planner/area.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planner/grown_fixtures.h"
#include "tests/random.h"

namespace palpate::area_test {
namespace {

using ::testing::HasSubstr;

constexpr std::uint64_t kSeed = 20261201;
constexpr double kOverlap = 1e-9;

using Corners = std::vector<Eigen::Vector2d>;

const Corners kL{{0, 0}, {8, 0}, {8, 3}, {3, 3}, {3, 8}, {0, 8}};
// Its hull is a square; two of its corners lie on the hull's upper edge, with a notch on each side of them.
const Corners kComb{{0, 0}, {10, 0}, {10, 6}, {8, 6}, {8, 2}, {6, 2}, {6, 6}, {4, 6}, {4, 2}, {2, 2}, {2, 6}, {0, 6}};

// As seen from the origin, at even angles; either way around.
Corners some_star(Random& random) {
    const std::size_t count = 3 + random.below(12);
    Corners corners;
    for (std::size_t k = 0; k < count; ++k) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(count);
        corners.emplace_back(Eigen::Vector2d(std::cos(angle), std::sin(angle)) * random.uniform(1, 6));
    }
    if (random.chance(0.5)) std::ranges::reverse(corners);
    return corners;
}

std::vector<Corners> some_polygons(Random& random) {
    std::vector<Corners> polygons{kL, kComb, {kComb.rbegin(), kComb.rend()}, {{0, 0}, {5, 0}, {10, 0}, {0, 10}}};
    for (int k = 0; k < 60; ++k) polygons.push_back(some_star(random));
    return polygons;
}

bool is_in(const std::vector<KnownSolids::Convex>& solids, const Point& p) {
    return std::ranges::any_of(solids, [&](const KnownSolids::Convex& solid) {
        return std::ranges::all_of(solid, [&](const KnownSolids::Plane& plane) { return plane.height(p) < 0; });
    });
}

TEST(Area, WhatIsOutsideAndWhatIsInsideAreAllOfSpace) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Corners& corners : some_polygons(random)) {
        ASSERT_EQ(problem_of(corners), "");
        const Area area = Prism{corners, {-2, 3}};
        const auto outside = outside_of(area, kOverlap);
        int inside = 0;
        for (int k = 0; k < 2000; ++k) {
            const Point p = random.in_box({-12, -12, -4}, {12, 12, 5});
            if (is_inside(area, p, 1e-6)) {
                ++inside;
                ASSERT_FALSE(is_in(outside, p)) << p.transpose();
            } else if (!is_inside(area, p, -1e-6)) {
                ASSERT_TRUE(is_in(outside, p)) << p.transpose();
            }
        }
        EXPECT_GT(inside, 0);
        const Box box = bounds_of(area);
        EXPECT_LE(size_of(area), (box.max - box.min).head<2>().prod() * (1 + 1e-12));
    }
    EXPECT_DOUBLE_EQ(size_of(Prism{kL}), 39);
    EXPECT_DOUBLE_EQ(size_of(Prism{kComb}), 44);
    EXPECT_DOUBLE_EQ(size_of(Box{{0, 0, 0}, {2, 3, 9}}), 6);
}

// Where two of them share a face, no line runs through between.
TEST(Area, PiecesOfWhatIsOutsideLeaveNoGap) {
    Random random(kSeed);
    for (const Corners& corners : {kL, kComb}) {
        const auto outside = outside_of(Prism{corners, {-2, 3}}, kOverlap);
        for (std::size_t k = 0; k < corners.size(); ++k) {
            for (std::size_t j = 0; j < corners.size(); ++j) {
                // Seams lead from corner to corner.
                const double share = random.uniform(0.05, 0.95);
                const Eigen::Vector2d on = corners[k] + share * (corners[j] - corners[k]);
                const Point p(on.x(), on.y(), 0);
                EXPECT_TRUE(is_in(outside, p) || is_inside(Prism{corners, {-2, 3}}, p, -1e-6)) << p.transpose();
            }
        }
    }
}

TEST(Area, DepthsAreDistancesToTheOutline) {
    const Area area = Prism{kL, {0, 10}};
    EXPECT_TRUE(is_inside(area, {1, 1, 5}, 1 - 1e-9));
    EXPECT_FALSE(is_inside(area, {1, 1, 5}, 1 + 1e-9));
    EXPECT_FALSE(is_inside(area, {4, 4, 5}, 0));
    EXPECT_TRUE(is_inside(area, {4, 4, 5}, -1 - 1e-9));
    EXPECT_FALSE(is_inside(area, {4, 4, 5}, -1 + 1e-9));
    EXPECT_FALSE(is_inside(area, {1, 1, 9.5}, 0.6));
    EXPECT_FALSE(is_inside(area, {1, 1, -0.1}, 0));
}

TEST(Area, SaysWhatIsWrongWithAPolygon) {
    EXPECT_THAT(problem_of({{0, 0}, {1, 0}}), HasSubstr("has 2 corner(s); allowed: at least 3 corners"));
    EXPECT_THAT(problem_of({{0, 0}, {1, 0}, {1, 1}, {0, 0}}), HasSubstr("has the corner (0, 0) twice"));
    EXPECT_THAT(problem_of({{0, 0}, {2, 2}, {2, 0}, {0, 2}}), HasSubstr("crosses itself"));
    EXPECT_THAT(problem_of({{0, 0}, {4, 0}, {4, 4}, {2, 0}}), HasSubstr("crosses itself"));  // a corner on an edge
    EXPECT_NE(problem_of({{0, 0}, {1, 1}, {2, 2}}), "");
    EXPECT_EQ(problem_of(kComb), "");
}

// --- surroundings ----------------------------------------------------------------------------------------------------

constexpr double kEpsilon = 0.2;
const Box kWorkspace{{-15, -15, -5}, {15, 15, 8}};

TEST(SurroundingsWithAnArea, NoMoveFromInsideLeavesItAndAllThatStayAreFree) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Corners& corners : some_polygons(random)) {
        const Area area = Prism{corners, {-3, 100}};
        if ((bounds_of(area).max - bounds_of(area).min).head<2>().minCoeff() < 1) continue;
        const Surroundings around = surroundings_with(kWorkspace, {}, {}, 0, kEpsilon, area);
        const Box& omega = std::get<Box>(around.region().shape());
        const KnownSolids& known = around.known();
        EXPECT_EQ(omega.max.z(), 8);
        EXPECT_LT(omega.min.z(), -3 - 3 * kEpsilon);
        int blocked = 0;
        for (int k = 0; k < 2000; ++k) {
            const Segment move{random.in_box(omega.min, omega.max), random.in_box(omega.min, omega.max)};
            ASSERT_EQ(known.is_buried(move.source), !is_inside(area, move.source, 0)) << move.source.transpose();
            if (!is_inside(area, move.source, 1e-6)) continue;
            const auto hit = known.first_hit(move);
            // As far as it goes it is inside, and there it leaves.
            const Vector way = move.target - move.source;
            const double end = hit ? (hit->at - move.source).norm() / way.norm() : 1;
            for (int step = 0; step <= 50; ++step) ASSERT_TRUE(is_inside(area, move.source + end * step / 50 * way, -1e-9));
            if (!hit) continue;
            ++blocked;
            ASSERT_FALSE(is_inside(area, hit->at + 1e-6 * way.normalized(), 0));
            // A wall, but near the faces that lead out.
            if (hit->at.z() < omega.max.z() - 2.1 * kEpsilon) {
                ASSERT_TRUE(hit->is_solid);
                ASSERT_TRUE(around.known_normal(hit->at));
                ASSERT_LT(around.known_normal(hit->at)->dot(way), 0);
            }
        }
        EXPECT_GT(blocked, 0);
    }
}

TEST(SurroundingsWithAnArea, TheToolEntersOverTheAreaAloneAndGoesAnywhereAbove) {
    Random random(kSeed);
    const Surroundings around = surroundings_with(kWorkspace, {}, {}, 0, kEpsilon, Prism{kL, {-3, 100}});
    const Box& omega = std::get<Box>(around.region().shape());
    EXPECT_EQ(around.bounds().min, Point(0, 0, -3));
    EXPECT_EQ(around.bounds().max, Point(8, 8, 8));
    for (int k = 0; k < 2000; ++k) {
        Point p = random.in_box(omega.min, omega.max);
        p.z() = omega.max.z();
        EXPECT_EQ(around.is_enterable(p), is_inside(Prism{kL}, p, 0)) << p.transpose();
        Point q = random.in_box(omega.min, omega.max);
        q.z() = omega.max.z();
        for (const Point& step : around.path(p, q)) {
            ASSERT_FALSE(around.first_known({p, step}));
            p = step;
        }
        // Sides and the bottom are closed.
        q = random.on_boundary(around.region());
        if (q.z() < omega.max.z()) {
            EXPECT_FALSE(around.is_enterable(q));
        }
    }
    EXPECT_EQ(around.nearest_entry({100, 1, 50}), Point(8, 1, 8));
    EXPECT_THROW((void)around.nearest_entry({100, 1, 0}), std::invalid_argument);
    // Straight up, though that is farther than through a wall.
    EXPECT_EQ(around.nearest_entry({2.9, 7, 0}), Point(2.9, 7, 8));
    EXPECT_TRUE(around.known().is_barred({5, 5, 0}));
    EXPECT_FALSE(around.known().is_barred({5, 5, 9}));
    EXPECT_FALSE(around.known().has_fixtures());
}

TEST(SurroundingsWithAnArea, FacesThatItReachesStayOpenAndOthersClose) {
    const auto faces = [&](const Area& area, const Fixtures& fixtures = {}) {
        return surroundings_with(kWorkspace, fixtures, {}, 0, kEpsilon, area).faces().is_open;
    };
    using Faces = decltype(Surroundings::OpenFaces::is_open);
    EXPECT_EQ(faces(Box{{-1, -1, -1}, {1, 1, 8}}), (Faces{{{false, false}, {false, false}, {false, true}}}));
    EXPECT_EQ(faces(Box{{-1, -1, -1}, {99, 1, 99}}), (Faces{{{false, true}, {false, false}, {false, true}}}));
    Fixtures table;
    table.solids.emplace_back(Table{-4});
    EXPECT_EQ(faces(Box{{-1, -1, -99}, {1, 1, 99}}, table), (Faces{{{false, false}, {false, false}, {false, true}}}));
    const Surroundings above = surroundings_with(kWorkspace, table, {}, 0, kEpsilon, Box{{-1, -1, -1}, {1, 1, 99}});
    EXPECT_FALSE(above.known().has_fixtures()) << "the table is behind the area's bottom";
    EXPECT_TRUE(surroundings_with(kWorkspace, table, {}, 0, kEpsilon, Box{{-1, -1, -99}, {1, 1, 99}}).known().has_fixtures());
    // A clamp beside the area closes nothing.
    Fixtures clamp;
    clamp.solids.emplace_back(Box{{3, -1, -2}, {5, 1, 9}});
    EXPECT_EQ(faces(Box{{-1, -1, -1}, {1, 1, 8}}, clamp), (Faces{{{false, false}, {false, false}, {false, true}}}));
}

std::string refusal(const Area& area, const Fixtures& fixtures = {}) {
    try {
        (void)surroundings_with(kWorkspace, fixtures, {}, 0, kEpsilon, area);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "nothing";
}

TEST(SurroundingsWithAnArea, RefusesWhatLeavesNothingToProbeOrNoWayIn) {
    EXPECT_THAT(refusal(Box{{-1, -1, -1}, {1, 1, 7}}), HasSubstr("no face of the workspace leads into the area"));
    EXPECT_THAT(refusal(Box{{-1, -1, -99}, {1, 1, 99}}), HasSubstr("or only two that face each other"));
    EXPECT_THAT(refusal(Box{{20, -1, -99}, {21, 1, 99}}), HasSubstr("lies outside the workspace"));
    EXPECT_THAT(refusal(Box{{0, 0, -1}, {0.7, 1, 99}}), HasSubstr("the area has 0.7 x 1 x 9 mm of the workspace, less than 4 epsilon"));
    Fixtures clamp;
    clamp.solids.emplace_back(Box{{-2, -2, -2}, {2, 2, 9}});
    EXPECT_THAT(refusal(Box{{-1, -1, -1}, {1, 1, 99}}, clamp), HasSubstr("the area lies within a fixture"));
    Fixtures table;
    table.solids.emplace_back(Table{9});
    EXPECT_THAT(refusal(Box{{-1, -1, -1}, {1, 1, 99}}, table), HasSubstr("the area lies below a table"));
    EXPECT_EQ(refusal(Box{{-1, -1, -1}, {1, 1, 99}}), "nothing");
}

}  // namespace
}  // namespace palpate::area_test
