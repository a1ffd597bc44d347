#include "sim/objects/hidden_object.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "sim/objects/errors.h"
#include "tests/sim/support.h"

namespace palpate::hidden_object_test {
namespace {

HiddenObject bunny() { return HiddenObject(MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"}); }

TEST(HiddenObjectTest, AnswersForShapes) {
    const HiddenObject object(ShapeSpec{TorusSpec{1.0, 0.4}, Point(10.0, 0.0, 0.0)});
    EXPECT_EQ(object.reach(), 0.4);
    EXPECT_FALSE(object.area());
    EXPECT_EQ(object.components(), 1);
    EXPECT_EQ(object.euler_characteristic(), 0);
    EXPECT_NEAR(object.distance({10.0, 0.0, 0.0}), 0.6, 1e-14);
    EXPECT_NEAR(object.distance({11.0, 0.0, 0.0}), 0.4, 1e-14);
    EXPECT_TRUE(object.contains({11.0, 0.0, 0.1}));
    EXPECT_TRUE(object.warnings().empty());
    EXPECT_GE(object.scale(), 11.4);
    EXPECT_EQ(object.crossings({{0.0, 0.0, 0.0}, {10.0, 0.0, 0.0}}).size(), 2U);
}

TEST(HiddenObjectTest, AnswersForMeshes) {
    const HiddenObject object = bunny();
    EXPECT_FALSE(object.reach());
    EXPECT_GT(object.area().value(), 0.0);
    EXPECT_EQ(object.euler_characteristic(), 2);
    EXPECT_EQ(object.components(), 1);
    EXPECT_THROW(HiddenObject(MeshSpec{"missing.off"}), ObjectError);
    EXPECT_THROW(HiddenObject(ShapeSpec{SphereSpec{-1.0}}), ObjectError);
}

TEST(HiddenObjectTest, CanBeMovedAndAskedFromSeveralThreads) {
    HiddenObject first = bunny();
    const HiddenObject object = std::move(first);
    const auto sum = [&] {
        Random random(5);
        double total = 0.0;
        for (int i = 0; i < 2000; ++i) {
            const Segment s{random.around(object.bounds(), 0.1), random.around(object.bounds(), 0.1)};
            total += object.distance(s.source) + (object.contains(s.target) ? 1.0 : 0.0);
            if (const auto hit = object.first_hit(s)) total += hit->sum();
        }
        return total;
    };
    double other = 0.0;
    std::thread thread([&] { other = sum(); });
    const double own = sum();
    thread.join();
    EXPECT_EQ(own, other);
}

}  // namespace
}  // namespace palpate::hidden_object_test
