#include "devices/decorators/limited_device.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "devices/errors.h"
#include "tests/devices/fake_probe.h"
#include "tests/random.h"

namespace palpate::limited_device_test {
namespace {

const Box kLimits{{-1, -2, -3}, {4, 5, 6}};

// The message of the OutOfLimits that it throws; empty if it throws none.
std::string refusal(ProbeDevice& device, const Point& target) {
    try {
        (void)device.guarded_move(target, Pace::travel);
    } catch (const OutOfLimits& error) {
        return error.what();
    }
    return "";
}

TEST(LimitedDevice, PassesMovesInsideAndOnTheFaces) {
    FakeProbe probe(half_space(Vector::UnitX(), 1), {2, 0, 0}, 0.5);
    LimitedDevice limited(probe, kLimits);
    EXPECT_EQ(limited.guarded_move({4, 5, 6}, Pace::travel), (MoveResult{MoveResult::Outcome::reached, {4, 5, 6}}));
    EXPECT_EQ(limited.guarded_move({4, -2, -3}, Pace::touch).position, Point(4, -2, -3));
    const MoveResult touch = limited.guarded_move({-1, -2, -3}, Pace::probe);
    EXPECT_EQ(touch, (MoveResult{MoveResult::Outcome::contact, {1, -2, -3}}));
    EXPECT_EQ(limited.position(), Point(1.5, -2, -3));
    EXPECT_EQ(probe.log.at(1).pace, Pace::touch);
    EXPECT_EQ(probe.log.at(2).pace, Pace::probe);
    limited.stop();
    EXPECT_EQ(probe.stops, 1);
}

TEST(LimitedDevice, TargetsOutsideAreRefusedBeforeAnythingIsSentAndTheMessageSaysWhich) {
    FakeProbe probe(nothing(), Point::Zero(), 0);
    LimitedDevice limited(probe, kLimits);
    const std::string low = refusal(limited, {0, 0, -3.25});
    EXPECT_NE(low.find("(0, 0, -3.25)"), std::string::npos) << low;
    EXPECT_NE(low.find("z = -3.25 mm is below the lower limit -3 mm"), std::string::npos) << low;
    EXPECT_NE(low.find("machine.limits"), std::string::npos) << low;
    const std::string high = refusal(limited, {0, 5.5, 0});
    EXPECT_NE(high.find("y = 5.5 mm is above the upper limit 5 mm"), std::string::npos) << high;
    EXPECT_TRUE(probe.log.empty());
}

TEST(LimitedDevice, TargetsThatAreNotFiniteAreRefused) {
    FakeProbe probe(nothing(), Point::Zero(), 0);
    LimitedDevice limited(probe, kLimits);
    for (const double x : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        for (int axis = 0; axis < 3; ++axis) {
            Point target = Point::Zero();
            target[axis] = x;
            EXPECT_NE(refusal(limited, target).find("not finite"), std::string::npos);
        }
    }
    EXPECT_TRUE(probe.log.empty());
}

TEST(LimitedDevice, AToolThatIsOutsideIsNotMovedEvenInwards) {
    FakeProbe probe(nothing(), {4.5, 0, 0}, 0);
    LimitedDevice limited(probe, kLimits);
    const std::string message = refusal(limited, Point::Zero());
    EXPECT_NE(message.find("x = 4.5 mm is above the upper limit 4 mm"), std::string::npos) << message;
    EXPECT_NE(message.find("the tool is at"), std::string::npos) << message;
    EXPECT_TRUE(probe.log.empty());
}

TEST(LimitedDevice, AToolAtTheLimitMayBeRoundedOverItButTargetsMayNot) {
    FakeProbe probe(nothing(), {4.001, 0, 0}, 0);
    LimitedDevice limited(probe, kLimits, 0.002);
    EXPECT_NE(refusal(limited, {4.001, 1, 0}), "");
    EXPECT_EQ(refusal(limited, {4, 1, 0}), "");
    FakeProbe farther(nothing(), {4.003, 0, 0}, 0);
    LimitedDevice other(farther, kLimits, 0.002);
    EXPECT_NE(refusal(other, {4, 1, 0}), "");
}

TEST(LimitedDevice, RandomTargetsAreRefusedExactlyWhenOutside) {
    const std::uint64_t seed = 11;
    SCOPED_TRACE(seed_text(seed));
    Random random(seed);
    FakeProbe probe(nothing(), Point::Zero(), 0);
    LimitedDevice limited(probe, kLimits);
    const Region box(kLimits);
    std::size_t passed = 0;
    for (int k = 0; k < 2000; ++k) {
        const Point target = random.around(kLimits, 0.1);
        const bool is_inside = box.contains(target);
        EXPECT_EQ(refusal(limited, target).empty(), is_inside) << target.transpose();
        passed += is_inside ? 1 : 0;
        EXPECT_EQ(probe.log.size(), passed);
    }
    EXPECT_GT(passed, 200U);
    EXPECT_LT(passed, 1800U);
}

TEST(LimitedDevice, BoxesWithoutInsideAreRefused) {
    FakeProbe probe(nothing(), Point::Zero(), 0);
    EXPECT_THROW(LimitedDevice(probe, {{0, 0, 0}, {1, 0, 1}}), std::invalid_argument);
    EXPECT_THROW(LimitedDevice(probe, {{0, 0, 0}, {1, std::numeric_limits<double>::infinity(), 1}}), std::invalid_argument);
    EXPECT_THROW(LimitedDevice(probe, kLimits, -0.001), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::limited_device_test
