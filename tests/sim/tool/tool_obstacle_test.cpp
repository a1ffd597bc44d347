#include "sim/tool/tool_obstacle.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "sim/objects/errors.h"
#include "sim/objects/parallelogram.h"
#include "sim/simulated_device.h"
#include "sim/tool/internal/fixture_kinds.h"
#include "sim/tool/internal/tool_parts.h"
#include "sim/tool/tool_audit.h"
#include "tests/sim/tool/tool_worlds.h"

namespace palpate::tool_obstacle_test {
namespace {

using Outcome = MoveResult::Outcome;
using Part = ToolContact::Part;
using Met = ToolContact::Met;

// --- brute force: every part against every triangle, by distances ---------------------------------------------------------

struct BruteWorld {
    std::vector<GrownTriangles> object;
    std::vector<ToolPart> parts;
    std::vector<HalfSpace> half_spaces;
    std::vector<Box> boxes;

    BruteWorld(const HiddenObject& hidden, const ToolShape& tool, const std::vector<Fixture>& fixtures)
        : object(hidden.grown_triangles()), parts(parts_of(tool)), half_spaces(half_spaces_of(fixtures)), boxes(boxes_of(fixtures)) {}

    // mm: between the tool, wherever it comes on that move, and all surfaces; negative where it gets into one.
    [[nodiscard]] double gap(const Segment& move) const {
        double least = std::numeric_limits<double>::infinity();
        for (const ToolPart& part : parts) {
            const Parallelogram swept{move.source + part.offset, part.capsule.core, move.target - move.source};
            const auto note = [&](double distance) { least = std::min(least, distance - part.capsule.radius); };
            for (const auto& [mesh, by] : object) {
                for (const auto& [a, b, c] : mesh.triangles) note(distance(swept, {mesh.points[a], mesh.points[b], mesh.points[c]}) - by);
            }
            for (const HalfSpace& half : half_spaces) {
                for (const auto& [s, t] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 0), std::pair(1, 1)}) {
                    note(half.normal.dot(swept.at(s, t) - half.point));
                }
            }
            for (const Box& box : boxes) {
                for (int k = 0; k <= 40; ++k) {
                    for (int i = 0; i <= 40; ++i) {
                        const Point p = swept.at(k / 40.0, i / 40.0);
                        note((p - p.cwiseMax(box.min).cwiseMin(box.max)).norm());
                    }
                }
            }
        }
        return least;
    }
    // Steps that are as long as the gap, until that is `near`.
    [[nodiscard]] std::optional<double> step_to_contact(const Segment& move, double near) const {
        const Vector way = move.target - move.source;
        double at = 0;
        for (int steps = 0; at <= 1 && steps < 3000; ++steps) {
            const Point p = move.source + at * way;
            const double left = gap({p, p});
            if (left < near) return at;
            at += left / way.norm();
        }
        return std::nullopt;
    }
};

void expect_contacts(ShapeSpec (&shape)(Random&), int moves, int stepped, std::uint64_t seed) {
    SCOPED_TRACE(seed_text(seed));
    Random random(seed);
    int contacts = 0;
    int clear = 0;
    int grazes = 0;
    for (int k = 0; k < moves; ++k) {
        const HiddenObject object(shape(random));
        const ToolShape tool = random_tool(random, 2);
        const std::vector<Fixture> fixtures = random_fixtures(random);
        const BruteWorld brute(object, tool, fixtures);
        const ToolWorld world(object.grown_triangles(), half_spaces_of(fixtures), boxes_of(fixtures));
        const Segment move{random.in_box(Point::Constant(-6), Point::Constant(6)), random.in_box(Point::Constant(-4), Point::Constant(4))};
        if (brute.gap({move.source, move.source}) < 1e-6) continue;
        const auto contact = world.first_contact(tool, move);
        const Vector way = move.target - move.source;
        const Point end = move.source + (contact ? contact->at : 1.0) * way;
        // Boxes are looked at by samples there.
        const bool is_sampled = !boxes_of(fixtures).empty();
        EXPECT_GT(brute.gap({move.source, end}), -1e-7) << "move " << k;
        if (contact) {
            ++contacts;
            EXPECT_NEAR(brute.gap({end, end}), 0, is_sampled ? 0.05 : 1e-7) << "move " << k;
        } else {
            ++clear;
        }
        if (k >= stepped || is_sampled) continue;
        const auto by_steps = brute.step_to_contact(move, 1e-6);
        if (by_steps.has_value() != contact.has_value()) {
            EXPECT_NEAR(brute.gap(move), 0, 2e-6) << "move " << k;
            ++grazes;
        } else if (contact) {
            EXPECT_LE(*by_steps, contact->at + 1e-9) << "move " << k;
            EXPECT_GE(brute.gap({move.source + *by_steps * way, end}), -1e-7) << "move " << k;
        }
    }
    EXPECT_GT(contacts, moves / 6);
    EXPECT_GT(clear, moves / 20);
    EXPECT_LE(grazes, 1 + moves / 500);
}

TEST(ToolContact, OfWholeToolsIsWhereNothingIsInTheWayBefore) { expect_contacts(random_columns, 6000, 2000, 20261130); }
TEST(ToolContact, OfWholeToolsWithRoundShapesIsWhereNothingIsInTheWayBefore) { expect_contacts(random_round_shapes, 6000, 2000, 20261202); }
TEST(ToolContact, NightlyOfWholeToolsIsWhereNothingIsInTheWayBefore) {
    expect_contacts(random_columns, 100'000, 10'000, 20261201);
    expect_contacts(random_round_shapes, 100'000, 10'000, 20261203);
}

// --- as an obstacle --------------------------------------------------------------------------------------------------------

HiddenObject bunny() { return HiddenObject(MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"}); }

// Crossings, sides and depths tell of one solid. Returns how many of the segments cross its surface.
int expect_consistent(const ToolObstacle& obstacle, const Box& around, Random& random, int segments) {
    constexpr double kNear = 1e-6;
    int crossed = 0;
    for (int k = 0; k < segments; ++k) {
        const Segment segment{random.around(around, 0.3), random.around(around, 0.3)};
        const Vector way = segment.target - segment.source;
        const std::vector<Point> crossings = obstacle.crossings(segment);
        crossed += crossings.empty() ? 0 : 1;
        bool inside = obstacle.contains(segment.source);
        if (const auto hit = obstacle.first_hit(segment); hit || !crossings.empty()) {
            EXPECT_TRUE(hit && !crossings.empty() && (*hit - crossings.front()).norm() < 1e-7) << k;
        }
        double last = 0;
        std::vector<Point> ends = crossings;
        ends.push_back(segment.target);
        for (const Point& end : ends) {
            const double at = (end - segment.source).dot(way) / way.squaredNorm();
            EXPECT_GE(at, last - 1e-12) << k;
            for (int i = 1; i < 12; ++i) {
                const Point p = segment.source + (last + (at - last) * i / 12) * way;
                // Where S* is within a hair, either side is right.
                if ((at - last) * way.norm() > 20 * kNear) {
                    EXPECT_EQ(obstacle.contains(p), inside) << k << ", " << i << ", depth " << obstacle.depth(p);
                }
            }
            inside = !inside;
            last = at;
        }
        for (const Point& p : crossings) EXPECT_LT(obstacle.depth(p), 1e-7) << k;
    }
    return crossed;
}

TEST(ToolObstacle, CrossingsSidesAndHitsAgree) {
    Random random(3);
    int crossed = 0;
    for (int k = 0; k < 200; ++k) {
        SCOPED_TRACE(k);
        const HiddenObject object(random_columns(random));
        const ToolObstacle obstacle(object, random_tool(random, 2), random_fixtures(random));
        crossed += expect_consistent(obstacle, {Point::Constant(-4), Point::Constant(4)}, random, 25);
    }
    EXPECT_GT(crossed, 200 * 25 / 3);
}

TEST(ToolObstacle, CrossingsSidesAndHitsAgreeOnAMesh) {
    Random random(4);
    const HiddenObject object = bunny();
    for (int k = 0; k < 5; ++k) {
        const ToolObstacle obstacle(object, random_tool(random, 4), {Table{1}, Box{{-5, 0, -5}, {-3, 3, 5}}});
        EXPECT_GT(expect_consistent(obstacle, object.bounds(), random, 60), 20);
    }
}

TEST(ToolObstacle, APointAndAFloatingPointOfFixtures) {
    Random random(6);
    const HiddenObject torus(ShapeSpec{TorusSpec{1.0, 0.4}});
    const ToolObstacle obstacle(torus, std::nullopt, {Table{-0.2}, Box{{1, -1, -1}, {3, 1, 1}}});
    EXPECT_GT(expect_consistent(obstacle, {Point::Constant(-2), Point::Constant(2)}, random, 600), 200);
    EXPECT_NEAR(obstacle.first_hit({{-3, 0, 0}, {3, 0, 0}}).value().x(), -1.4, 1e-12);
    EXPECT_NEAR(obstacle.first_hit({{0, 0, 3}, {0, 0, -3}}).value().z(), -0.2, 1e-12);
    EXPECT_EQ(obstacle.crossings({{0, 0, 0}, {5, 0, 0}}).size(), 2U) << "ring and box as one";
    EXPECT_NEAR(obstacle.depth({2, 0, 0}), 1, 1e-12);
}

TEST(ToolObstacle, BoundsAreThoseOfTheGrownObject) {
    const HiddenObject object(block_with_roof());
    const Box bounds = ToolObstacle(object, slim_probe(), {}).bounds();
    EXPECT_LT((bounds.min - Point(-2, -2, -16)).norm(), 1e-12) << "a radius of the holder beside it, and all of the tool below";
    EXPECT_LT((bounds.max - Point(2, 2, 3.2)).norm(), 1e-12);
    const Box point = ToolObstacle(object, std::nullopt, {Table{-1}}).bounds();
    EXPECT_EQ(point.min, object.bounds().min);
}

TEST(ToolObstacle, WhatIsBelowATableCannotBeReached) {
    const HiddenObject object(block_with_roof());
    const std::vector<Box> reachable = ToolObstacle(object, slim_probe(), {Table{-1}}).reachable_bounds();
    ASSERT_EQ(reachable.size(), 2U) << "the holder is above the part even where the ball is on the table";
    for (const Box& box : reachable) EXPECT_NEAR(box.min.z(), -0.8, 1e-12);
    EXPECT_NEAR(reachable[0].max.x(), 1.2, 1e-12);
    EXPECT_NEAR(reachable[1].max.x(), 1.1, 1e-12);
    EXPECT_EQ(ToolObstacle(object, slim_probe(), {}).reachable_bounds().size(), 3U);
    EXPECT_EQ(ToolObstacle(object, std::nullopt, {}).reachable_bounds().front().min, object.bounds().min);
}

TEST(ToolObstacle, ATallToolIsInsideWhereItsShaftIsThoughItsBallIsNot) {
    const HiddenObject object(block_with_roof());
    const ToolObstacle obstacle(object, slim_probe(), {});
    EXPECT_FALSE(obstacle.contains({-0.5, 0, 1}));
    EXPECT_TRUE(obstacle.contains({0.7, 0, 1})) << "the roof is around the stylus";
    EXPECT_GE(obstacle.depth({0.7, 0, 1}), 0.1);
    EXPECT_LE(obstacle.depth({0.7, 0, 1}), 0.1 + 0.3);
    EXPECT_NEAR(obstacle.depth({-0.5, 0, 0.15}), 0.05, 1e-12);
    EXPECT_NEAR(obstacle.depth({-0.5, 0, -0.5}), 0.7, 1e-12) << "the ball's centre is inside";
}

TEST(ToolObstacle, CrossingsSidesAndHitsAgreeOnRoundShapes) {
    Random random(5);
    int crossed = 0;
    for (int k = 0; k < 200; ++k) {
        SCOPED_TRACE(k);
        const HiddenObject object(random_round_shapes(random));
        const ToolObstacle obstacle(object, random_tool(random, 2), random_fixtures(random));
        crossed += expect_consistent(obstacle, {Point::Constant(-4), Point::Constant(4)}, random, 25);
    }
    EXPECT_GT(crossed, 200 * 25 / 3);
}

// Of a tool's axis to a shape whose distance is known in closed form: that is convex along it.
TEST(ToolDepths, OfRoundShapesAreThoseOfTheirOwnDistance) {
    Random random(8);
    constexpr double kSearched = 1e-8;  // mm: as far as the search below comes
    int touching = 0;
    for (int k = 0; k < 3000; ++k) {
        std::vector<ShapeSpec> parts = std::get<std::vector<ShapeSpec>>(random_round_shapes(random).kind);
        const HiddenObject object(parts.front());
        const ToolShape tool = random_tool(random, 2);
        const Point p = random.in_box(Point::Constant(-3), Point::Constant(3));
        double expected = std::numeric_limits<double>::infinity();
        bool is_outside = true;
        for (const ToolPart& part : parts_of(tool)) {
            const auto distance = [&](double s) {
                const Point at = p + part.offset + s * part.capsule.core;
                is_outside = is_outside && !object.contains(at);
                return object.distance(at);
            };
            double low = 0;
            double high = 1;
            while (high - low > 1e-9) {
                const double third = (high - low) / 3;
                if (distance(low + third) < distance(high - third)) {
                    high -= third;
                } else {
                    low += third;
                }
            }
            expected = std::min(expected, distance(low) - part.capsule.radius);
        }
        if (!is_outside) continue;
        const ToolDepths depths(object, tool, {});
        constexpr double kWithin = 0.5;
        EXPECT_NEAR(*depths.gap(p, kWithin), std::min(kWithin, expected), kSearched) << k;
        touching += expected < kWithin ? 1 : 0;
        if (expected > 0) {
            EXPECT_EQ(depths.at(p).object, 0) << k;
        } else {
            EXPECT_NEAR(depths.at(p).object, -expected, kSearched) << k;
        }
    }
    EXPECT_GT(touching, 100);
}

TEST(ToolObstacle, ABallTouchesASphereWhereItsCentreIsBothRadiiAway) {
    const HiddenObject sphere(ShapeSpec{SphereSpec{3}, Point(1, 2, 3)});
    const ToolObstacle obstacle(sphere, slim_probe(), {Table{0}});
    Random random(9);
    for (int k = 0; k < 200; ++k) {
        Vector from = random.direction();
        from.z() = std::abs(from.z());
        const Point outside = Point(1, 2, 3) + 9 * from;
        const auto hit = obstacle.first_hit({outside, Point(1, 2, 3)});
        ASSERT_TRUE(hit) << k;
        EXPECT_NEAR((*hit - Point(1, 2, 3)).norm(), 3.2, 1e-9) << "from above the ball comes first";
        EXPECT_LT((obstacle.normal(*hit, -from) - from).norm(), 1e-6);
    }
    // From below its equator the stylus does, which is upright.
    const auto shadowed = obstacle.first_hit({{9, 2, 1}, {1, 2, 1}});
    ASSERT_TRUE(shadowed);
    EXPECT_NEAR(shadowed->x(), 1 + 3.1, 1e-9);
    EXPECT_NEAR(obstacle.depth({1, 2, 3}), 3.2, 1e-12) << "at its centre";
}

TEST(ToolObstacle, ABodyNeedsTrianglesThatMayHaveGrown) {
    const HiddenObject torus(ShapeSpec{TorusSpec{2, 1}});
    const HiddenObject with_torus(ShapeSpec{std::vector<ShapeSpec>{{SphereSpec{1}, {0, 0, 9}}, {TorusSpec{2, 1}}}});
    for (const HiddenObject* object : {&torus, &with_torus}) {
        EXPECT_THROW(ToolObstacle(*object, slim_probe(), {}), ObjectError);
        EXPECT_THROW(ToolDepths(*object, slim_probe(), {}), std::invalid_argument);
        EXPECT_NO_THROW(ToolObstacle(*object, std::nullopt, {Table{0}}));
    }
    const HiddenObject turned(ShapeSpec{RoundedBoxSpec{{2, 2, 2}, 0.25}, Point(1, 2, 3), Vector(0.3, 0.2, 0.1)});
    const std::vector<GrownTriangles> grown = turned.grown_triangles();
    ASSERT_EQ(grown.size(), 1U);
    EXPECT_EQ(grown.front().by, 0.25);
    for (const Point& p : grown.front().triangles.points) EXPECT_NEAR(turned.distance(p), 0.25, 1e-14);
}

// --- moved ------------------------------------------------------------------------------------------------------------------

// A device with a tool, and the audit of all of the tool.
struct Rig {
    Rig(const ObjectSpec& spec, const std::optional<ToolShape>& tool, const std::vector<Fixture>& fixtures)
        : object(spec), obstacle(object, tool, fixtures), depths(object, tool, fixtures), audit(depths) {}

    [[nodiscard]] SimulatedDevice device(const Point& start) {
        return {obstacle, start, {.on_move = [this](const Segment& way, bool touched) { audit.record(way, touched); }}};
    }

    HiddenObject object;
    ToolObstacle obstacle;
    ToolDepths depths;
    ToolAudit audit;
};

TEST(MovedTool, TouchesATableWithItsBallAndARoofWithItsStylus) {
    Rig rig(block_with_roof(), slim_probe(), {Table{-1}});
    SimulatedDevice device = rig.device({-3, 0, 4});
    const MoveResult table = device.guarded_move({-3, 0, -5}, Pace::probe);
    EXPECT_EQ(table.outcome, Outcome::contact);
    EXPECT_NEAR(table.position.z(), -0.8, 1e-12);
    EXPECT_EQ(rig.audit.account().touches(Part::ball, Met::fixture), 1U);
    EXPECT_EQ(device.guarded_move({-3, 0, 1}, Pace::travel).outcome, Outcome::reached);
    const MoveResult roof = device.guarded_move({3, 0, 1}, Pace::probe);
    EXPECT_EQ(roof.outcome, Outcome::contact);
    EXPECT_NEAR(roof.position.x(), 0.4, 1e-12);
    EXPECT_EQ(rig.audit.account().touches(Part::stylus, Met::object), 1U);
    EXPECT_EQ(device.guarded_move({-3, 0, 1}, Pace::travel).outcome, Outcome::reached);
    EXPECT_EQ(device.unsafe_moves() + rig.audit.account().unsafe_moves, 0U);
    EXPECT_EQ(rig.audit.account().moves, 4U);
}

TEST(MovedTool, StartsAndTargetsInFixturesAreRefusedOrTouched) {
    Rig rig(block_with_roof(), std::nullopt, {Table{-1}});
    EXPECT_THROW((void)rig.device({-3, 0, -1.5}), std::exception);
    SimulatedDevice device = rig.device({-3, 0, 4});
    EXPECT_NEAR(device.guarded_move({-3, 0, -5}, Pace::probe).position.z(), -1, 1e-12);
    EXPECT_EQ(device.guarded_move({-3, 1, -5}, Pace::probe).position.z(), device.position().z()) << "it presses";
    EXPECT_EQ(device.guarded_move({-3, 0, 4}, Pace::travel).outcome, Outcome::reached);
    EXPECT_EQ(device.unsafe_moves() + rig.audit.account().unsafe_moves, 0U);
}

void walk(Rig& rig, Random& random, int moves) {
    const Box around{rig.object.bounds().min, rig.object.bounds().max};
    Point start = around.max + Vector::Constant(5 * around.diagonal());
    while (rig.obstacle.contains(start)) start = random.around(around, 4);
    SimulatedDevice device = rig.device(start);
    int contacts = 0;
    for (int i = 0; i < moves; ++i) {
        const MoveResult result = device.guarded_move(random.around(around, 0.6), Pace::probe);
        if (result.outcome != Outcome::contact) continue;
        ++contacts;
        EXPECT_LT(rig.obstacle.depth(result.position), 1e-7);
        // Back off, as a planner does, to a place that is free.
        const Point away = random.around(around, 0.6);
        (void)device.guarded_move(away, Pace::travel);
    }
    EXPECT_GT(contacts, moves / 20);
    EXPECT_EQ(device.unsafe_moves(), 0U);
    EXPECT_EQ(rig.audit.account().unsafe_moves, 0U) << rig.audit.account().deepest.object << ' ' << rig.audit.account().deepest.fixture;
}

TEST(MovedTool, RandomWalksEnterNothing) {
    Random random(8);
    for (int k = 0; k < 20; ++k) {
        SCOPED_TRACE(k);
        Rig rig(random_columns(random), random_tool(random, 1), random_fixtures(random));
        walk(rig, random, 150);
    }
    Rig on_table(MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"}, random_tool(random, 2), {Table{0.5}});
    walk(on_table, random, 400);
}

// --- the account -------------------------------------------------------------------------------------------------------------

TEST(ToolAudit, CountsWhatAnyPartOfTheToolEnters) {
    const HiddenObject object(block_with_roof());
    const ToolDepths depths(object, slim_probe(), {Table{-1}, Box{{-4, -1, -1}, {-3, 1, 1}}});
    const auto counted = [&](const Segment& move) {
        ToolAudit audit(depths);
        audit.record(move, false);
        EXPECT_EQ(audit.account().unsafe_moves,
                  std::min<std::uint64_t>(1, audit.account().moves_into_object + audit.account().moves_into_fixtures));
        return std::pair(audit.account().moves_into_object, audit.account().moves_into_fixtures);
    };
    const std::pair<std::uint64_t, std::uint64_t> none{0, 0};
    const std::pair<std::uint64_t, std::uint64_t> part{1, 0};
    const std::pair<std::uint64_t, std::uint64_t> fixture{0, 1};
    EXPECT_EQ(counted({{-0.6, 0, 3}, {-0.6, 0, 0.2}}), none) << "to a touch";
    EXPECT_EQ(counted({{-0.6, 0, 3}, {-0.6, 0, 0.2 - 1e-5}}), part) << "by the ball";
    EXPECT_EQ(counted({{-0.6, 0, 1}, {0.4, 0, 1}}), none);
    EXPECT_EQ(counted({{-0.6, 0, 1}, {0.4 + 1e-5, 0, 1}}), part) << "by the stylus";
    EXPECT_EQ(counted({{-0.6, 0, 1}, {4, 0, 1}}), part) << "through the roof";
    EXPECT_EQ(counted({{-3, 0, 2.5}, {-3, 0, 1.2}}), none);
    EXPECT_EQ(counted({{-3, 0, 2.5}, {-3, 0, 1.1}}), fixture) << "the box";
    EXPECT_EQ(counted({{-2, 0, 1}, {-2, 0, -0.81}}), fixture) << "the table";
    EXPECT_EQ(counted({{0, 3, 1}, {0.9, -3, 1}}), part) << "the stylus between, in mid move";
    EXPECT_EQ(counted({{-0.2, 0, -0.5}, {-0.2, 0, -0.5}}), part) << "standing inside";
}

// An error of a simulator: it stops where a point would.
TEST(ToolAudit, SeesThatADeviceForgotTheTool) {
    Rig rig(block_with_roof(), slim_probe(), {Table{-1}});
    SimulatedDevice forgetful(rig.object, {-3, 0, 4},
                              {.on_move = [&](const Segment& way, bool touched) { rig.audit.record(way, touched); }});
    (void)forgetful.guarded_move({-3, 0, -0.9}, Pace::travel);
    EXPECT_EQ(rig.audit.account().moves_into_fixtures, 1U);
    (void)forgetful.guarded_move({-3, 0, 0.5}, Pace::travel);
    (void)forgetful.guarded_move({-0.5, 0, 0.5}, Pace::travel);
    EXPECT_EQ(rig.audit.account().moves_into_object, 0U);
    (void)forgetful.guarded_move({-0.5, 0, -3}, Pace::probe);
    EXPECT_EQ(rig.audit.account().moves_into_object, 1U);
    EXPECT_NEAR(rig.audit.account().deepest.object, 0.2, 1e-9);
    EXPECT_EQ(forgetful.unsafe_moves(), 0U) << "which the audit of a point does not see";
}

TEST(ToolAudit, AllowsWhatAMachineRunsOn) {
    const HiddenObject object(block_with_roof());
    const ToolDepths depths(object, slim_probe(), {});
    ToolAudit audit(depths, 0.05);
    audit.record({{-0.6, 0, 3}, {-0.6, 0, 0.16}}, true);
    EXPECT_EQ(audit.account().unsafe_moves, 0U);
    EXPECT_NEAR(audit.account().deepest.object, 0.04, 1e-12);
    EXPECT_EQ(audit.account().touches(Part::ball, Met::object), 1U);
    audit.record({{-0.6, 0, 3}, {-0.6, 0, 0.14}}, true);
    EXPECT_EQ(audit.account().unsafe_moves, 1U);
}

}  // namespace
}  // namespace palpate::tool_obstacle_test
