#include "sim/objects/capsule_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>

#include "sim/objects/mesh/mesh_file.h"
#include "sim/objects/triangle_tree.h"
#include "tests/random.h"
#include "tests/sim/objects/brute_distance.h"

namespace palpate::capsule_contact_test {
namespace {

// --- brute force: distances between a segment and a triangle, and steps that are never too long -------------------------

// Between two segments: a convex function of the place on the first.
double distance(const Segment& s, const Segment& other) {
    return least([&](double x) { return distance_to(other, s.source + x * (s.target - s.source)); }, 80);
}

double distance(const Segment& s, const Triangle& t) {
    const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
    const double a = n.dot(s.source - t[0]);
    const double b = n.dot(s.target - t[0]);
    if ((a < 0) != (b < 0)) {
        const Point through = s.source + a / (a - b) * (s.target - s.source);
        bool is_in = true;
        for (std::size_t i = 0; i < 3; ++i) is_in = is_in && n.dot((t.at((i + 1) % 3) - t.at(i)).cross(through - t.at(i))) >= 0;
        if (is_in) return 0;
    }
    double nearest = std::min(point_distance(s.source, t), point_distance(s.target, t));
    for (std::size_t i = 0; i < 3; ++i) nearest = std::min(nearest, distance(s, Segment{t.at(i), t.at((i + 1) % 3)}));
    return nearest;
}

constexpr double kNear = 1e-9;

std::optional<double> step_to_contact(const Triangle& t, const Capsule& c, const Segment& move) {
    const Vector way = move.target - move.source;
    const double length = way.norm();
    double gone = 0;
    while (gone <= length) {
        const Point p = move.source + gone / length * way;
        const double gap = distance(Segment{p, p + c.core}, t) - c.radius;
        if (gap < kNear) return gone / length;
        gone += gap;
    }
    return std::nullopt;
}

// How deep the capsule gets into the triangle at most; negative: how near it comes.
double depth_on_way(const Triangle& t, const Capsule& c, const Segment& move) {
    double deepest = -1e9;
    for (int k = 0; k <= 400; ++k) {
        const Point p = move.source + k / 400.0 * (move.target - move.source);
        deepest = std::max(deepest, c.radius - distance(Segment{p, p + c.core}, t));
    }
    return deepest;
}

Point random_point(Random& random, double size) {
    return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

void expect_contacts(int moves) {
    Random random(20261130);
    int contacts = 0;
    int grazes = 0;
    for (int k = 0; k < moves; ++k) {
        Triangle t{random_point(random, 2), random_point(random, 2), random_point(random, 2)};
        Capsule c{random.chance(0.3) ? Vector::Zero() : Vector(random.uniform(0, 4) * random.direction()), random.uniform(0.05, 1.5)};
        if (random.chance(0.2)) c.core = Vector(0, 0, 3);
        if (random.chance(0.1)) c.core = 1.5 * (t[1] - t[0]);  // along an edge
        Segment move{random_point(random, 6), random_point(random, 3)};
        if (random.chance(0.1)) move.target = move.source + 4 * c.core;  // along the capsule
        if (move.target == move.source || distance(Segment{move.source, move.source + c.core}, t) < c.radius + 1e-6) continue;
        const auto found = first_contact(t, c, move);
        const auto stepped = step_to_contact(t, c, move);
        const double length = (move.target - move.source).norm();
        if (found.has_value() != stepped.has_value()) {
            // Either sees what only grazes.
            EXPECT_NEAR(depth_on_way(t, c, move), 0, 2e-4) << "move " << k;
            ++grazes;
            continue;
        }
        if (!found) continue;
        ++contacts;
        const Point p = move.source + *found * (move.target - move.source);
        EXPECT_NEAR(distance(Segment{p, p + c.core}, t), c.radius, 1e-7) << "move " << k;
        // Steps end where the gap is kNear: on a way that hardly approaches, long before.
        EXPECT_GE(*found * length, *stepped * length - 1e-6) << "move " << k;
        const Point before = p - 1e-6 * (move.target - move.source).normalized();
        if (*found * length > 1e-6) {
            EXPECT_GT(distance(Segment{before, before + c.core}, t), c.radius - 1e-8) << "move " << k;
        }
        EXPECT_LE(*found * length, *stepped * length + 1e-3) << "move " << k;
    }
    EXPECT_GT(contacts, moves / 4);
    EXPECT_LE(grazes, moves / 5000);
}

TEST(CapsuleContact, IsWhereStepsByDistanceEnd) { expect_contacts(10'000); }
TEST(CapsuleContact, NightlyIsWhereStepsByDistanceEnd) { expect_contacts(100'000); }

TEST(CapsuleContact, AMoveThatLeavesMeetsNothingAndOneThatPressesMeetsAtOnce) {
    const Triangle t{Point(-1, -1, 0), Point(2, -1, 0), Point(0, 2, 0)};
    for (const Vector& core : {Vector(0, 0, 0), Vector(0, 0, 5)}) {
        const Capsule c{core, 0.5};
        EXPECT_FALSE(first_contact(t, c, {{0, 0, 0.5}, {0, 0, 3}}));
        EXPECT_FALSE(first_contact(t, c, {{0, 0, 0.5}, {1, 0, 0.5}})) << "along it";
        EXPECT_FALSE(first_contact(t, c, {{0, 0, 0.5}, {5, 0, 0.5}})) << "and beyond its edge";
        EXPECT_EQ(first_contact(t, c, {{0, 0, 0.5}, {0.2, 0, 0.1}}), 0.0);
        EXPECT_EQ(first_contact(t, c, {{0, 0, 0.3}, {0, 0, 3}}), 0.0) << "it begins within";
    }
}

// What every touch of a simulation does: to the surface, back off it, sideways, on again.
TEST(CapsuleContact, AfterATouchTheWayBackIsFree) {
    Random random(7);
    for (int k = 0; k < 20'000; ++k) {
        const Triangle t{random_point(random, 2), random_point(random, 2), random_point(random, 2)};
        const Capsule c{random.chance(0.5) ? Vector::Zero() : Vector(0, 0, 3), random.uniform(0.05, 1)};
        const Segment move{random_point(random, 6), random_point(random, 2)};
        if (distance(Segment{move.source, move.source + c.core}, t) < c.radius + 1e-6) continue;
        const auto at = first_contact(t, c, move);
        if (!at || *at < 1e-6) continue;
        const Point touched = move.source + *at * (move.target - move.source);
        EXPECT_FALSE(first_contact(t, c, {touched, move.source})) << k;
    }
}

TEST(CapsuleContact, WithAHalfSpaceIsWhereItsLowestPointIs) {
    Random random(11);
    for (int k = 0; k < 10'000; ++k) {
        const Vector n = random.direction();
        const double offset = random.uniform(-1, 1);
        const Capsule c{2 * random.direction(), random.uniform(0, 1)};
        const Segment move{random_point(random, 5), random_point(random, 5)};
        const auto lowest = [&](const Point& p) { return std::min(n.dot(p), n.dot(p + c.core)) - c.radius - offset; };
        const auto at = first_contact_with_half_space(n, offset, c, move);
        if (lowest(move.source) < -1e-6) {
            EXPECT_EQ(at, 0.0);
        } else if (lowest(move.target) > 1e-6) {
            EXPECT_FALSE(at);
        } else if (lowest(move.source) > 1e-6 && lowest(move.target) < -1e-6) {
            ASSERT_TRUE(at);
            EXPECT_NEAR(lowest(move.source + *at * (move.target - move.source)), 0, 1e-12);
        }
    }
}

TEST(TriangleTree, FindsTheFirstOfAllTrianglesThatACapsuleTouches) {
    const TriangleMesh bunny = read_triangles(PALPATE_TEST_DATA "/bunny.off");
    const TriangleTree tree(bunny);
    Random random(13);
    int contacts = 0;
    for (int k = 0; k < 400; ++k) {
        const Capsule c{random.chance(0.3) ? Vector::Zero() : Vector(0, 4, 0), random.uniform(0.01, 0.6)};
        const Segment move{Point(0, 5, 0) + 9 * random.direction(), Point(0, 5, 0) + random_point(random, 4)};
        std::optional<double> first;
        for (const auto& [a, b, d] : bunny.triangles) {
            const auto at = first_contact({bunny.points[a], bunny.points[b], bunny.points[d]}, c, move);
            if (at && (!first || *at < *first)) first = at;
        }
        EXPECT_EQ(tree.first_contact(c, move), first) << k;
        contacts += first.has_value();
    }
    EXPECT_GT(contacts, 250);
}

}  // namespace
}  // namespace palpate::capsule_contact_test
