#include "planner/inference/normal_cone.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "planner/inference/lens.h"
#include "tests/planner/torus.h"

namespace palpate::normal_cone_test {
namespace {

constexpr std::uint64_t kSeed = 20261122;
constexpr double kMargin = 1e-12;

// Whether a unit vector lies in the cone that the extremes span, or almost.
bool holds(const NormalCone& cone, const Vector& n) {
    const auto extremes = cone.extremes();
    const Vector axis = cone.axis();
    for (std::size_t k = 0; k < extremes.size(); ++k) {
        const Vector& e = extremes[k];
        const Vector& f = extremes[(k + 1) % extremes.size()];
        Vector side = e.cross(f);
        if (side.norm() < 1e-12) continue;
        if (side.dot(axis) < 0) side = -side;
        if (side.normalized().dot(n) < -1e-9) return false;
    }
    return n.dot(axis) > 0;
}

struct Neighborhood {
    Torus::Place apex;
    std::vector<Vector> to;  // neighbours, from the apex
};

Neighborhood random_neighborhood(Random& random, const Torus& torus, double distance, int count) {
    Neighborhood result{torus.random_place(random), {}};
    while (static_cast<int>(result.to.size()) < count) {
        const Vector to = torus.nearest(result.apex.point + distance * random.direction()).point - result.apex.point;
        if (to.norm() > 0.3 * distance) result.to.push_back(to);
    }
    return result;
}

// Begins with the first pair that does, and narrows with all. Nothing if no pair does.
std::optional<NormalCone> cone_of(const Neighborhood& around, const Vector& outwards, double reach) {
    NormalCone cone;
    for (std::size_t j = 1; j < around.to.size() && !cone.is_known(); ++j) {
        for (std::size_t i = 0; i < j && !cone.is_known(); ++i) cone.begin(around.to[i], around.to[j], outwards, reach, kMargin);
    }
    if (!cone.is_known()) return std::nullopt;
    for (const Vector& to : around.to) {
        if (!cone.narrow(to, reach, kMargin)) return std::nullopt;
    }
    return cone;
}

TEST(NormalCone, HoldsTheNormalWheneverTheBoundIsTrue) {
    const Torus torus;
    int known = 0;
    for (std::uint64_t seed = kSeed; seed < kSeed + 2000; ++seed) {
        Random random(seed);
        const double distance = random.uniform(0.005, 0.3);
        const Neighborhood around = random_neighborhood(random, torus, distance, 2 + static_cast<int>(random.below(10)));
        // From where a probe may have come: anywhere above the tangent plane.
        Vector outwards = random.direction();
        if (outwards.dot(around.apex.normal) < 0) outwards = -outwards;
        const auto cone = cone_of(around, outwards, torus.minor * random.uniform(0.5, 1.0));
        if (!cone) continue;
        ++known;
        ASSERT_TRUE(holds(*cone, around.apex.normal)) << seed_text(seed);
    }
    EXPECT_GT(known, 1000);
}

TEST(NormalCone, HoldsEveryNormalThatNoSlabExcludes) {
    const Torus torus;
    for (std::uint64_t seed = kSeed; seed < kSeed + 300; ++seed) {
        Random random(seed);
        const Neighborhood around = random_neighborhood(random, torus, 0.05, 6);
        const auto cone = cone_of(around, around.apex.normal, torus.minor);
        if (!cone) continue;
        for (int k = 0; k < 200; ++k) {
            const Vector n = (around.apex.normal + random.uniform(0, 0.3) * random.direction()).normalized();
            const bool possible = std::all_of(around.to.begin(), around.to.end(), [&](const Vector& to) {
                return std::abs(to.normalized().dot(n)) <= to.norm() / (2 * torus.minor);
            });
            ASSERT_TRUE(!possible || holds(*cone, n)) << seed_text(seed);
        }
    }
}

TEST(NormalCone, ARingOfNeighborsLeavesLittle) {
    const Torus torus;
    const double distance = 0.05;
    for (std::uint64_t seed = kSeed; seed < kSeed + 200; ++seed) {
        Random random(seed);
        Neighborhood around{torus.random_place(random), {}};
        const Vector x = around.apex.normal.unitOrthogonal();
        const Vector y = around.apex.normal.cross(x);
        for (int k = 0; k < 6; ++k) {
            const double turn = k * std::numbers::pi / 3;
            around.to.push_back(torus.nearest(around.apex.point + distance * (std::cos(turn) * x + std::sin(turn) * y)).point -
                                around.apex.point);
        }
        const auto cone = cone_of(around, around.apex.normal, torus.minor);
        ASSERT_TRUE(cone);
        for (const Vector& n : cone->extremes()) {
            // 1.15 d / 2r, and a little for what is not first order.
            ASSERT_LE(std::acos(std::min(1.0, n.dot(around.apex.normal))), 2 * 1.2 * distance / (2 * torus.minor)) << seed_text(seed);
            ASSERT_LE(std::acos(std::min(1.0, n.dot(cone->axis()))), 1.3 * distance / (2 * torus.minor)) << seed_text(seed);
        }
    }
}

TEST(NormalCone, AFalseBoundLeavesNothing) {
    const Torus torus;
    int refuted = 0;
    for (std::uint64_t seed = kSeed; seed < kSeed + 200; ++seed) {
        Random random(seed);
        const Neighborhood around = random_neighborhood(random, torus, 0.1, 12);
        NormalCone cone;
        for (std::size_t j = 1; j < around.to.size() && !cone.is_known(); ++j) {
            cone.begin(around.to[0], around.to[j], around.apex.normal, 4 * torus.minor, kMargin);
        }
        if (!cone.is_known()) continue;
        for (const Vector& to : around.to) {
            if (cone.narrow(to, 4 * torus.minor, kMargin)) continue;
            ++refuted;
            break;
        }
    }
    EXPECT_GT(refuted, 150);
}

// The same slabs over and over, to rounding: corners that lie on one line make the polygon look concave.
TEST(NormalCone, StaysWithinItsCornersWhenSlabsAlmostCoincide) {
    Random random(kSeed);
    constexpr double kDistance = 0.2;
    const auto neighbor = [&] {
        const double height = 0.45 * random.uniform(-1, 1) * kDistance * kDistance;
        const double angle = random.uniform(0, 7);
        return Vector(kDistance * std::cos(angle), kDistance * std::sin(angle), -height);
    };
    for (int trial = 0; trial < 20000; ++trial) {
        NormalCone cone;
        for (int k = 0; k < 20 && !cone.is_known(); ++k) cone.begin(neighbor(), neighbor(), Vector::UnitZ(), 1, 0);
        const std::array<Vector, 4> again{neighbor(), neighbor(), neighbor(), neighbor()};
        for (int k = 0; k < 200 && cone.is_known(); ++k) {
            const Vector& b = again[random.below(4)];
            if (!cone.narrow(b + 1e-16 * kDistance * random.direction(), 1 + 1e-16 * k, 0)) break;
            ASSERT_LE(cone.extremes().size(), 8U);
        }
    }
}

TEST(NormalCone, CannotTellTheSidesOfATouchAlongTheSurface) {
    NormalCone cone;
    EXPECT_FALSE(cone.begin({0.1, 0, 0}, {0, 0.1, 0}, {1, 0, 0}, 1, kMargin)) << "the probe came in the tangent plane";
    EXPECT_FALSE(cone.begin({0.1, 0, 0}, {0.2, 0.001, 0}, {0, 0, 1}, 1, kMargin)) << "neighbours in one direction";
    EXPECT_TRUE(cone.begin({0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 1}, 1, kMargin));
    EXPECT_TRUE(cone.begin({0.1, 0, 0}, {0, 0.1, 0}, {0, 0, -1}, 1, kMargin));
    EXPECT_LT(cone.axis().z(), -0.9) << "outwards is where the probe came from";
}

TEST(Lens, IsFreeOutsideAndSolidInside) {
    const Torus torus;
    int exterior = 0;
    int interior = 0;
    for (std::uint64_t seed = kSeed; seed < kSeed + 500; ++seed) {
        Random random(seed);
        const Neighborhood around = random_neighborhood(random, torus, random.uniform(0.01, 0.15), 7);
        const auto cone = cone_of(around, around.apex.normal, torus.minor);
        if (!cone) continue;
        const Lens outside{around.apex.point, cone->extremes(), torus.minor, kMargin, Side::exterior};
        const Lens inside{around.apex.point, cone->extremes(), torus.minor, kMargin, Side::interior};
        for (int k = 0; k < 100; ++k) {
            const Point x = around.apex.point + random.uniform(0, 2 * torus.minor) * random.direction();
            if (outside.contains(x)) {
                ++exterior;
                ASSERT_GT(torus.distance(x), 0) << seed_text(seed);
            }
            if (inside.contains(x)) {
                ++interior;
                ASSERT_LT(torus.distance(x), 0) << seed_text(seed);
            }
        }
    }
    EXPECT_GT(exterior, 1000);
    EXPECT_GT(interior, 1000);
}

TEST(Lens, ClipsALineWhereItContainsItsPoints) {
    const Torus torus;
    int inside = 0;
    for (std::uint64_t seed = kSeed; seed < kSeed + 300; ++seed) {
        Random random(seed);
        const Neighborhood around = random_neighborhood(random, torus, 0.05, 7);
        const auto cone = cone_of(around, around.apex.normal, torus.minor);
        if (!cone) continue;
        const Lens lens{around.apex.point, cone->extremes(), torus.minor, kMargin, random.chance(0.5) ? Side::exterior : Side::interior};
        const Point origin = around.apex.point + 0.3 * random.direction();
        const Vector direction = random.direction();
        const auto clipped = lens.clip(origin, direction);
        for (int k = -200; k <= 200; ++k) {
            const double t = k * 0.005;
            const bool expected = clipped && t > clipped->low && t < clipped->high;
            if (clipped && std::min(std::abs(t - clipped->low), std::abs(t - clipped->high)) < 1e-9) continue;
            ASSERT_EQ(lens.contains(origin + t * direction), expected) << seed_text(seed) << ", t " << t;
            inside += expected;
        }
    }
    EXPECT_GT(inside, 1000);
}

}  // namespace
}  // namespace palpate::normal_cone_test
