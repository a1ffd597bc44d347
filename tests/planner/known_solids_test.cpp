#include "planner/known_solids.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "planner/grown_fixtures.h"
#include "tests/random.h"

namespace palpate::known_solids_test {
namespace {

constexpr std::uint64_t kSeed = 20261130;
constexpr double kSlack = 1e-9;
constexpr double kEpsilon = 1.0;

// A box somewhere, turned somehow.
KnownSolids::Convex some_box(Random& random) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(random.direction(), random.direction());
    const Point center = random.in_box(Point::Constant(-2), Point::Constant(2));
    KnownSolids::Convex box;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
            const Vector normal = turn * (sign * Vector::Unit(axis));
            box.push_back({normal, normal.dot(center) + random.uniform(0.2, 1.5)});
        }
    }
    return box;
}

TEST(KnownSolids, AMoveMeetsWhatSteppingAlongItMeets) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    int hits = 0;
    for (int round = 0; round < 300; ++round) {
        const KnownSolids solids({some_box(random), some_box(random)}, {}, kSlack);
        const Segment move{random.in_box(Point::Constant(-4), Point::Constant(4)), random.in_box(Point::Constant(-4), Point::Constant(4))};
        const auto hit = solids.first_hit(move);
        const Vector way = move.target - move.source;
        constexpr int kSteps = 2000;
        std::optional<double> inside;
        for (int k = 0; k <= kSteps && !inside; ++k) {
            if (solids.contains(move.source + static_cast<double>(k) / kSteps * way)) inside = static_cast<double>(k) / kSteps;
        }
        if (!inside) continue;  // a corner that steps pass over may still be met
        ASSERT_TRUE(hit);
        ++hits;
        const double at = (hit->at - move.source).norm() / way.norm();
        ASSERT_LE(at, *inside);
        ASSERT_GE(at, *inside - 1.0 / kSteps - 1e-9);
        if (at > 0) {
            ASSERT_FALSE(solids.contains(hit->at));
            ASSERT_TRUE(solids.normal_at(hit->at));
            ASSERT_LT(solids.normal_at(hit->at)->dot(way), 0);
            ASSERT_TRUE(solids.contains(hit->at + 1e-6 * way.normalized()));
        }
    }
    EXPECT_GT(hits, 60);
}

TEST(KnownSolids, AMoveThatEndsOrRunsOnAFaceMeetsNothingAndOneFromItInwardsMeetsItAtOnce) {
    const KnownSolids::Convex plate{{Vector::UnitZ(), 1.0},  {-Vector::UnitZ(), 0.0}, {Vector::UnitX(), 5.0},
                                    {-Vector::UnitX(), 5.0}, {Vector::UnitY(), 5.0},  {-Vector::UnitY(), 5.0}};
    const KnownSolids solids({plate}, {}, kSlack);
    EXPECT_FALSE(solids.first_hit({{0, 0, 3}, {0, 0, 1}}));
    EXPECT_FALSE(solids.first_hit({{-1, 0, 1}, {1, 2, 1}}));
    EXPECT_FALSE(solids.first_hit({{0, 0, 1}, {3, 0, 2}}));
    const auto hit = solids.first_hit({{0, 0, 1}, {0.1, 0, 0.5}});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->at, Point(0, 0, 1));
    EXPECT_TRUE(hit->is_solid);
}

TEST(KnownSolids, BesideAPlateTheFloorIsMetAndOnItThePlate) {
    const KnownSolids::Convex plate{{Vector::UnitZ(), 0.0},  {-Vector::UnitZ(), 3.0}, {Vector::UnitX(), 5.0},
                                    {-Vector::UnitX(), 5.0}, {Vector::UnitY(), 5.0},  {-Vector::UnitY(), 5.0}};
    const KnownSolids solids({plate}, {{Vector::UnitZ(), 0.0}}, kSlack);
    const auto on = solids.first_hit({{4, 0, 2}, {4, 0, -2}});
    ASSERT_TRUE(on);
    EXPECT_TRUE(on->is_solid);
    const auto beside = solids.first_hit({{6, 0, 2}, {6, 0, -2}});
    ASSERT_TRUE(beside);
    EXPECT_FALSE(beside->is_solid);
    EXPECT_EQ(beside->at, Point(6, 0, 0));
    EXPECT_TRUE(solids.is_buried({6, 0, -1}));
    EXPECT_FALSE(solids.contains({6, 0, -1}));
    EXPECT_EQ(*solids.first_entry({{6, 0, -1}, {0, 0, -1}}), Point(5, 0, -1));
}

// --- grown fixtures --------------------------------------------------------------------------------------------------

ToolShape some_tool(Random& random) {
    ToolShape tool;
    tool.ball_diameter = random.uniform(1, 3);
    tool.stylus = ToolShape::Shaft{random.uniform(0.5, 1) * tool.ball_diameter, random.uniform(5, 15)};
    if (random.chance(0.5)) tool.holder = ToolShape::Shaft{random.uniform(4, 8), random.uniform(5, 10)};
    if (random.chance(0.5)) tool.axis = random.direction();
    return tool;
}

double distance_to(const Box& box, const Point& p) { return (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm(); }

// mm: the least distance between the box and the tool with its reference point there, by sampling the tool's axis; negative: how deep.
double gap(const ToolShape& tool, const Box& box, const Point& p) {
    constexpr int kSteps = 400;
    double least = distance_to(box, p) - tool.ball_diameter / 2;
    double end = 0;
    for (const auto& shaft : {tool.stylus, tool.holder}) {
        if (!shaft) continue;
        for (int k = 0; k <= kSteps; ++k) {
            least = std::min(least, distance_to(box, p + (end + shaft->length * k / kSteps) * tool.axis) - shaft->diameter / 2);
        }
        end += shaft->length;
    }
    return least;
}

TEST(GrownFixtures, AToolOutsideAGrownBoxKeepsItsClearanceAndOneFarFromItIsOutside) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Box workspace{Point::Constant(-60), Point::Constant(60)};
    constexpr double kClearance = 0.2;
    int inside = 0;
    for (int round = 0; round < 40; ++round) {
        const ToolShape tool = some_tool(random);
        Fixtures fixtures;
        const Box box{random.in_box(Point::Constant(-8), Point::Constant(-1)), random.in_box(Point::Constant(1), Point::Constant(8))};
        fixtures.solids.emplace_back(box);
        const Surroundings around = surroundings_with(workspace, fixtures, tool, kClearance, kEpsilon);
        for (int k = 0; k < 200; ++k) {
            const Point p = random.in_box(Point::Constant(-18), Point::Constant(18));
            const double distance = gap(tool, box, p);
            const bool contains = around.known().contains(p);
            inside += contains ? 1 : 0;
            if (distance < kClearance - 0.01) {
                ASSERT_TRUE(contains) << distance;
            }
            // At corners a box that is moved out by ρ reaches ρ √3.
            const double thickest = std::max(tool.ball_diameter, tool.holder ? tool.holder->diameter : 0.0) / 2 + kClearance;
            if (distance > kClearance + (std::sqrt(3.0) - 1) * thickest + 0.01) {
                ASSERT_FALSE(contains) << distance;
            }
        }
    }
    EXPECT_GT(inside, 400);
}

TEST(GrownFixtures, ATableClosesTheBottomAndReachesBelowTheWorkspace) {
    const Box workspace{{-30, -30, -5}, {30, 30, 40}};
    Fixtures fixtures;
    fixtures.solids.emplace_back(Table{2.0});
    ToolShape tool;
    tool.ball_diameter = 4;
    const Surroundings around = surroundings_with(workspace, fixtures, tool, 0.1, kEpsilon);
    const double top = 4.1;
    EXPECT_TRUE(around.known().contains({0, 0, top - 0.01}));
    EXPECT_FALSE(around.known().contains({0, 0, top + 0.01}));
    EXPECT_FALSE(around.region().contains({0, 0, top - 5.1}) && around.known().contains({0, 0, top - 5.1}));
    EXPECT_EQ(around.bounds().min.z(), top);
    EXPECT_TRUE(around.is_enterable({30, 0, 10}));
    EXPECT_TRUE(around.is_enterable({0, 0, 40}));
    EXPECT_FALSE(around.is_enterable({30, 0, top - 0.01}));
    EXPECT_FALSE(around.is_enterable({0, 0, std::get<Box>(around.region().shape()).min.z()}));
    EXPECT_EQ(around.nearest_entry({50, 0, 0}), Point(30, 0, top));
    // Every way between places that can be entered stays above the table.
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const auto some_entry = [&] {
        while (true) {
            const Point p = around.region().nearest_boundary(100 * random.direction());
            if (around.is_enterable(p)) return p;
        }
    };
    for (int k = 0; k < 300; ++k) {
        const Point from = some_entry();
        Point last = from;
        for (const Point& p : around.path(from, some_entry())) {
            ASSERT_FALSE(around.first_known({last, p}));
            last = p;
        }
    }
}

TEST(GrownFixtures, ATiltedHalfSpaceStaysBelowEveryWay) {
    const Box workspace{{-30, -30, 0}, {30, 30, 40}};
    Fixtures fixtures;
    fixtures.solids.emplace_back(HalfSpace{{0, 0, 5}, {0.05, -0.02, 1}});
    const Surroundings around = surroundings_with(workspace, fixtures, {}, 0.1, kEpsilon);
    EXPECT_FALSE(around.is_enterable({-30, 0, 6}));
    EXPECT_TRUE(around.is_enterable({-30, 0, 7}));
    EXPECT_TRUE(around.known().contains({0, 0, 5}));
    EXPECT_FALSE(around.known().contains({0, 0, 5.2}));
}

TEST(GrownFixtures, AClampThatReachesOutOfTheWorkspaceClosesAFace) {
    const Box workspace{{-30, -30, 0}, {30, 30, 40}};
    Fixtures fixtures;
    fixtures.solids.emplace_back(Table{0.0});
    fixtures.solids.emplace_back(Box{{20, -5, -10}, {50, 5, 15}});
    const Surroundings around = surroundings_with(workspace, fixtures, {}, 0.1, kEpsilon);
    EXPECT_FALSE(around.is_enterable({30, 20, 30}));
    EXPECT_TRUE(around.is_enterable({-30, 20, 30}));
    EXPECT_TRUE(around.is_enterable({20, 20, 40}));
    EXPECT_THROW((void)around.nearest_entry({60, 0, 20}), std::invalid_argument);
}

TEST(GrownFixtures, RefusesWhatCannotBeProbed) {
    const Box workspace{{-30, -30, 0}, {30, 30, 40}};
    Fixtures above;
    above.solids.emplace_back(Table{41.0});
    EXPECT_THROW((void)surroundings_with(workspace, above, {}, 0.1, kEpsilon), std::invalid_argument);
    Fixtures within;
    within.solids.emplace_back(Box{Point::Constant(-100), Point::Constant(100)});
    EXPECT_THROW((void)surroundings_with(workspace, within, {}, 0.1, kEpsilon), std::invalid_argument);
    Fixtures shaft;  // only two faces that look at each other stay open
    shaft.solids.emplace_back(Box{{-31, -100, -100}, {-20, 100, 100}});
    shaft.solids.emplace_back(Box{{20, -100, -100}, {31, 100, 100}});
    shaft.solids.emplace_back(Box{{-100, -31, -100}, {100, -20, 100}});
    shaft.solids.emplace_back(Box{{-100, 20, -100}, {100, 31, 100}});
    EXPECT_THROW((void)surroundings_with(workspace, shaft, {}, 0.1, kEpsilon), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::known_solids_test
