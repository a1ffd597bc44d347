#include "sim/motion_audit.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "sim/objects/hidden_object.h"
#include "tests/sim/support.h"

namespace palpate::motion_audit_test {
namespace {

std::uint64_t unsafe(const HiddenObject& object, const Segment& move) {
    MotionAudit audit(object);
    audit.record(move);
    return audit.unsafe_moves();
}

TEST(MotionAuditTest, CountsEveryWayIntoTheSolid) {
    const HiddenObject object(ShapeSpec{TorusSpec{1.0, 0.4}});
    EXPECT_EQ(unsafe(object, {{3, 0, 0}, {1, 0, 0}}), 1U);      // in
    EXPECT_EQ(unsafe(object, {{1, 0, 0}, {3, 0, 0}}), 1U);      // out
    EXPECT_EQ(unsafe(object, {{1, 0, 0}, {1.1, 0, 0}}), 1U);    // within
    EXPECT_EQ(unsafe(object, {{1, 0, 0}, {1, 0, 0}}), 1U);      // standing inside
    EXPECT_EQ(unsafe(object, {{3, 0, 0}, {-3, 0, 0}}), 1U);     // through
    EXPECT_EQ(unsafe(object, {{3, 0, 0}, {0, 0, 0}}), 1U);      // through one side, ends in the hole
    EXPECT_EQ(unsafe(object, {{1.4, 0, 0}, {0.6, 0, 0}}), 1U);  // from S through to S
    EXPECT_EQ(unsafe(object, {{0.6, 0, 0}, {1.4, 0, 0}}), 1U);
    EXPECT_EQ(unsafe(object, {{1.4 - 1e-6, -1, -1}, {1.4 - 1e-6, 1, 1}}), 1U);  // a sliver
}

TEST(MotionAuditTest, DoesNotCountLegalMoves) {
    const HiddenObject object(ShapeSpec{TorusSpec{1.0, 0.4}});
    EXPECT_EQ(unsafe(object, {{3, 0, 0}, {1.4, 0, 0}}), 0U);     // to a touch
    EXPECT_EQ(unsafe(object, {{1.4, 0, 0}, {3, 0, 0}}), 0U);     // away from it
    EXPECT_EQ(unsafe(object, {{0.6, 0, 0}, {-0.6, 0, 0}}), 0U);  // from S through the hole to S
    EXPECT_EQ(unsafe(object, {{0, 0, -3}, {0, 0, 3}}), 0U);
    EXPECT_EQ(unsafe(object, {{1, -3, 0.4}, {1, 3, 0.4}}), 0U);  // touching along its tangent
    EXPECT_EQ(unsafe(object, {{1.4, 0, 0}, {1.4, 0, 0}}), 0U);   // standing on S
}

TEST(MotionAuditTest, MeasuresAndCanLeaveOutTheCheck) {
    const HiddenObject object(ShapeSpec{SphereSpec{1.0}});
    MotionAudit audit(object, false);
    audit.record({{-3, 0, 0}, {3, 0, 0}});
    audit.record({{3, 0, 0}, {3, 4, 0}});
    EXPECT_EQ(audit.moves(), 2U);
    EXPECT_DOUBLE_EQ(audit.distance(), 10.0);
    EXPECT_EQ(audit.unsafe_moves(), 0U);
}

TEST(MotionAuditTest, AgreesWithSamplingAlongRandomMoves) {
    constexpr std::uint64_t kSeed = 11;
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    std::vector<std::pair<std::string, HiddenObject>> objects;
    for (const auto& [name, spec] : all_shapes()) objects.emplace_back(name, HiddenObject(spec));
    objects.emplace_back("bunny", HiddenObject(MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"}));
    for (const auto& [name, object] : objects) {
        SCOPED_TRACE(name);
        Random random(kSeed);
        int clear = 0;
        for (int i = 0; i < 300; ++i) {
            const Segment s{random.around(object.bounds(), 0.2), random.around(object.bounds(), 0.2)};
            bool inside = false;
            for (int k = 0; k <= 200; ++k) inside = inside || object.contains(s.source + (k / 200.0) * (s.target - s.source));
            const bool counted = unsafe(object, s) == 1;
            if (inside) {
                ASSERT_TRUE(counted);
            } else if (counted) {
                ASSERT_GE(object.crossings(s).size(), 2U);  // a sliver between the samples
            } else {
                ++clear;
            }
        }
        EXPECT_GT(clear, 20);
    }
}

}  // namespace
}  // namespace palpate::motion_audit_test
