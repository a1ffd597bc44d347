#include "sim/simulated_device.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "devices/errors.h"
#include "sim/objects/hidden_object.h"
#include "tests/sim/support.h"

namespace palpate::simulated_device_test {
namespace {

using Outcome = MoveResult::Outcome;

TEST(SimulatedDeviceTest, StopsAtTheFirstContactAndRestsThere) {
    const HiddenObject object(ShapeSpec{SphereSpec{1.0}});
    SimulatedDevice device(object, {3, 0, 0});
    const MoveResult touch = device.guarded_move({-3, 0, 0}, Pace::probe);
    EXPECT_EQ(touch.outcome, Outcome::contact);
    EXPECT_NEAR(touch.position.x(), 1.0, 1e-15);
    EXPECT_EQ(device.position(), touch.position);
    const MoveResult away = device.guarded_move({4.0, 4.0, 0.0}, Pace::probe);
    EXPECT_EQ(away.outcome, Outcome::reached);
    EXPECT_EQ(away.position, Point(4.0, 4.0, 0.0));
    EXPECT_EQ(device.moves(), 2U);
    EXPECT_NEAR(device.distance(), 7.0, 1e-12);
    EXPECT_EQ(device.unsafe_moves(), 0U);
}

TEST(SimulatedDeviceTest, AMoveIntoTheSolidFromAContactIsAContactWhereItStarted) {
    const HiddenObject object(ShapeSpec{SphereSpec{1.0}});
    SimulatedDevice device(object, {3, 0, 0});
    const Point touch = device.guarded_move(Point::Zero(), Pace::probe).position;
    for (const Point& target : {Point(-3, 0, 0), Point(0.5, 0.5, 0), Point(1.0 - 1e-12, 0, 0)}) {
        const MoveResult again = device.guarded_move(target, Pace::probe);
        EXPECT_EQ(again.outcome, Outcome::contact);
        EXPECT_EQ(again.position, touch);
    }
    EXPECT_EQ(device.unsafe_moves(), 0U);
    EXPECT_EQ(device.guarded_move({1.0 + 1e-12, 0, 0}, Pace::probe).outcome, Outcome::reached);
    EXPECT_EQ(device.guarded_move({3, 0, 0}, Pace::probe).outcome, Outcome::reached);
}

TEST(SimulatedDeviceTest, LeavesAPointOfTheSurfaceThatItReachedWithoutContact) {
    const HiddenObject object(ShapeSpec{RoundedBoxSpec{{2, 2, 2}, 0.0}});
    SimulatedDevice device(object, {3, 0, 0});
    EXPECT_NEAR(device.guarded_move({1, 0, 0}, Pace::probe).position.x(), 1.0, 1e-15);
    EXPECT_EQ(device.guarded_move({3, 0, 0}, Pace::probe).outcome, Outcome::reached);
    SimulatedDevice starting(object, {1, 0, 0});
    EXPECT_EQ(starting.guarded_move({3, 0, 0}, Pace::probe).outcome, Outcome::reached);
    EXPECT_EQ(device.unsafe_moves() + starting.unsafe_moves(), 0U);
}

TEST(SimulatedDeviceTest, RefusesAStartInsideAndPositionsThatAreNotFinite) {
    const HiddenObject object(ShapeSpec{SphereSpec{1.0}});
    EXPECT_THROW(SimulatedDevice(object, Point(0.5, 0, 0)), DeviceError);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(SimulatedDevice(object, Point(nan, 0, 0)), DeviceError);
    SimulatedDevice device(object, {3, 0, 0});
    EXPECT_THROW((void)device.guarded_move({nan, 0, 0}, Pace::probe), DeviceError);
    EXPECT_EQ(device.moves(), 0U);
    EXPECT_EQ(device.guarded_move({3, 0, 0}, Pace::probe).outcome, Outcome::reached);
    device.stop();
    EXPECT_EQ(device.position(), Point(3, 0, 0));
}

// A long walk with touches: it never enters, never jumps through, and every contact is on S.
TEST(SimulatedDeviceTest, RandomWalksStayOutsideEveryObject) {
    constexpr std::uint64_t kSeed = 3;
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    std::vector<std::pair<std::string, HiddenObject>> objects;
    for (const auto& [name, spec] : all_shapes()) objects.emplace_back(name, HiddenObject(spec));
    objects.emplace_back("bunny", HiddenObject(MeshSpec{std::filesystem::path(PALPATE_TEST_DATA) / "bunny.off"}));
    for (const auto& [name, object] : objects) {
        SCOPED_TRACE(name);
        Random random(kSeed);
        SimulatedDevice device(object, object.bounds().max + Vector::Ones());
        int contacts = 0;
        int stuck = 0;
        double path = 0.0;
        for (int i = 0; i < 5000; ++i) {
            const Point before = device.position();
            const Point target = random.around(object.bounds(), 0.3);
            const MoveResult result = device.guarded_move(target, Pace::probe);
            path += (result.position - before).norm();
            ASSERT_FALSE(object.contains(result.position) && object.distance(result.position) > 1e-12 * object.scale());
            if (result.outcome == Outcome::reached) {
                ASSERT_EQ(result.position, target);
                continue;
            }
            ++contacts;
            ASSERT_LE(object.distance(result.position), 1e-13 * object.scale());
            if (result.position == before) ++stuck;
        }
        EXPECT_GT(contacts, 300);
        EXPECT_LT(stuck, contacts);
        EXPECT_EQ(device.unsafe_moves(), 0U);
        EXPECT_EQ(device.moves(), 5000U);
        EXPECT_NEAR(device.distance(), path, 1e-9 * path);
    }
}

}  // namespace
}  // namespace palpate::simulated_device_test
