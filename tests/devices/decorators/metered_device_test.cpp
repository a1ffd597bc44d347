#include "devices/decorators/metered_device.h"

#include <gtest/gtest.h>

#include "devices/errors.h"
#include "tests/devices/fake_probe.h"
#include "tests/random.h"

namespace palpate::metered_device_test {
namespace {

using Outcome = MoveResult::Outcome;
using Kind = DeviceEvent::Kind;

// Feeds 20, 5 and 1 mm/s; runs on by 0.0225 mm at 5 mm/s with 2 ms of latency at 1000 mm/s².
MotionModel motion() {
    MotionModel k;
    k.acceleration_mm_per_s2 = 1000;
    k.latency = Seconds(0.002);
    k.retract_mm = 1;
    return k;
}

TEST(MeteredDevice, CountsMovesByPaceAndOutcomeAndEventsByKind) {
    FakeProbe probe(half_space(Vector::UnitX(), 0), {5, 0, 0}, 1);
    probe.events = [] { return std::vector<DeviceEvent>{{Kind::reconnected, {}}, {Kind::scattered_touch, {}}, {Kind::reconnected, {}}}; };
    MeteredDevice metered(probe, motion());
    (void)metered.guarded_move({4, 0, 0}, Pace::travel);
    (void)metered.guarded_move({3, 0, 0}, Pace::travel);
    (void)metered.guarded_move({2, 0, 0}, Pace::probe);
    (void)metered.guarded_move({-1, 0, 0}, Pace::probe);
    (void)metered.guarded_move({-1, 0, 0}, Pace::touch);
    EXPECT_EQ(metered.meter().travel, (MoveCount{2, 0, 0}));
    EXPECT_EQ(metered.meter().probe, (MoveCount{1, 1, 0}));
    EXPECT_EQ(metered.meter().touch, (MoveCount{0, 1, 0}));
    EXPECT_EQ(metered.meter().moves(), 5U);
    EXPECT_EQ(metered.meter().contacts(), 2U);
    EXPECT_EQ(metered.meter().count(Kind::reconnected), 10U);
    EXPECT_EQ(metered.meter().count(Kind::scattered_touch), 5U);
    EXPECT_EQ(metered.meter().count(Kind::spurious_trigger), 0U);
}

TEST(MeteredDevice, DisplacementHasTheWayIntoATouchAndBack) {
    FakeProbe probe(half_space(Vector::UnitX(), 0), {5, 0, 0}, 1);
    MeteredDevice metered(probe, motion());
    (void)metered.guarded_move({5, 3, 4}, Pace::travel);
    EXPECT_DOUBLE_EQ(metered.meter().displacement_mm, 5);
    (void)metered.guarded_move({-1, 3, 4}, Pace::probe);
    EXPECT_DOUBLE_EQ(metered.meter().displacement_mm, 5 + 5 + 1);
    EXPECT_EQ(metered.position(), Point(1, 3, 4));
    (void)metered.guarded_move({-1, 3, 4}, Pace::touch);
    EXPECT_DOUBLE_EQ(metered.meter().displacement_mm, 11 + 1 + 1);
}

TEST(MeteredDevice, RandomMovesAddUpToWhatTheLogOfTheDeviceSays) {
    const std::uint64_t seed = 5;
    SCOPED_TRACE(seed_text(seed));
    Random random(seed);
    FakeProbe probe(ball(Point::Zero(), 2), {5, 0, 0}, 0.25);
    MeteredDevice metered(probe, motion());
    for (int k = 0; k < 500; ++k) {
        (void)metered.guarded_move(random.in_box(Point::Constant(-5), Point::Constant(5)), random.chance(0.5) ? Pace::travel : Pace::probe);
    }
    double length = 0;
    for (std::size_t k = 0; k < probe.log.size(); ++k) {
        const Point rest = k + 1 < probe.log.size() ? probe.log[k + 1].from : probe.position();
        length += (probe.log[k].result.position - probe.log[k].from).norm() + (rest - probe.log[k].result.position).norm();
    }
    EXPECT_NEAR(metered.meter().displacement_mm, length, 1e-9 * length);
    EXPECT_GT(metered.meter().contacts(), 50U);
}

TEST(MeteredDevice, TimeOfMovesIsTheirTrapezoid) {
    FakeProbe probe(nothing(), Point::Zero(), 1);
    MeteredDevice metered(probe, motion());
    (void)metered.guarded_move({20, 0, 0}, Pace::travel);
    EXPECT_NEAR(metered.meter().machine_time.count(), 20 / 20.0 + 0.02, 1e-12);
    (void)metered.guarded_move({21, 0, 0}, Pace::touch);
    EXPECT_NEAR(metered.meter().machine_time.count(), 1.02 + 1 + 0.001, 1e-12);
}

// 5 mm at 5 mm/s; the tool runs on by 5 · 0.002 + 25/2000 = 0.0225 mm, and takes 5 ms to come to speed and to stand.
TEST(MeteredDevice, TimeOfATouchHasRunningOnAndTheWayBack) {
    FakeProbe probe(half_space(Vector::UnitX(), 0), {5, 0, 0}, 1);
    MeteredDevice metered(probe, motion());
    (void)metered.guarded_move({-1, 0, 0}, Pace::probe);
    const double there = 5.0225 / 5 + 0.005;
    const double back = 1.0225 / 5 + 0.005;
    EXPECT_NEAR(metered.meter().machine_time.count(), there + back, 1e-12);
}

TEST(MeteredDevice, CountsOfTouchesTakeTheSameTime) {
    FakeProbe probe(half_space(Vector::UnitX(), 0), {5, 0, 0}, 1);
    MeteredDevice metered(probe, motion());
    (void)metered.guarded_move({-1, 0, 0}, Pace::probe);
    Cost cost;
    cost.probing = 5;
    cost.contact = 1;
    EXPECT_NEAR(estimate_machine_time(cost, machine_rates(motion())).count(), metered.meter().machine_time.count(), 1e-12);
}

TEST(MeteredDevice, ADeviceThatRestsOnTheTouchedPointIsGivenARetractThereAndBack) {
    FakeProbe probe(half_space(Vector::UnitX(), 0), {5, 0, 0}, 0);
    MeteredDevice metered(probe, motion());
    (void)metered.guarded_move({-1, 0, 0}, Pace::probe);
    const double there = 5.0225 / 5 + 0.005;
    const double back = 1.0225 / 5 + 0.005;
    const double again = 1.0 / 5 + 0.005;
    EXPECT_NEAR(metered.meter().machine_time.count(), there + back + again, 1e-12);
    EXPECT_DOUBLE_EQ(metered.meter().displacement_mm, 5);
}

TEST(MeteredDevice, FaultsPassThroughAndAreCounted) {
    FakeProbe probe(nothing(), Point::Zero(), 1);
    probe.fault = [] { return true; };
    MeteredDevice metered(probe, motion());
    EXPECT_THROW((void)metered.guarded_move({1, 0, 0}, Pace::travel), ConnectionLost);
    EXPECT_EQ(metered.meter().faults, 1U);
    EXPECT_EQ(metered.meter().moves(), 0U);
    EXPECT_EQ(metered.meter().displacement_mm, 0);
}

}  // namespace
}  // namespace palpate::metered_device_test
