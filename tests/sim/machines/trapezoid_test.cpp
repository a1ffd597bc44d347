#include "sim/machines/internal/trapezoid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/random.h"

namespace palpate::trapezoid_test {
namespace {

// Step by step, as a controller would: speeds up, never above the feed, and brakes as soon as it must, or is told to.
struct Walk {
    double distance = 0.0;
    double speed = 0.0;
};

Walk walk(double length, double feed, double acceleration, double time, double stop_at, int steps) {
    Walk state;
    const double dt = time / steps;
    bool braking = false;
    for (int i = 0; i < steps; ++i) {
        braking = braking || i * dt >= stop_at || state.distance + state.speed * state.speed / (2 * acceleration) >= length;
        const double next = std::clamp(state.speed + (braking ? -acceleration : acceleration) * dt, 0.0, feed);
        state.distance += 0.5 * (state.speed + next) * dt;
        state.speed = next;
    }
    return state;
}

TEST(TrapezoidTest, AgreesWithStepByStepIntegration) {
    constexpr std::uint64_t kSeed = 3;
    constexpr int kSteps = 20000;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int i = 0; i < 200; ++i) {
        const double length = random.uniform(0.01, 40);
        const double feed = random.uniform(0.1, 60);
        const double acceleration = random.uniform(10, 500);
        const Trapezoid whole(length, feed, acceleration);
        const bool stops = random.chance(0.5);
        const double stop_at = stops ? random.uniform(0, 1.1) * whole.duration().count() : 1e9;
        const Trapezoid profile = stops ? whole.stopped_from(Seconds(stop_at)) : whole;
        const double time = random.uniform(0, 1.2) * whole.duration().count();
        const Walk expected = walk(length, feed, acceleration, time, stop_at, kSteps);
        // One step's worth of braking too late or too early.
        const double dv = 2 * acceleration * time / kSteps;
        const double top = std::min(feed, std::sqrt(length * acceleration));
        EXPECT_NEAR(profile.speed(Seconds(time)), expected.speed, 2 * dv + 0.02 * top) << i;
        EXPECT_NEAR(profile.distance(Seconds(time)), expected.distance, 2e-3 * length + top * time / kSteps) << i;
    }
}

TEST(TrapezoidTest, EndsAtItsLengthAndTakesMoveDuration) {
    const Trapezoid profile(10, 5, 100);
    EXPECT_NEAR(profile.length(), 10, 1e-12);
    EXPECT_NEAR(profile.duration().count(), 10.0 / 5 + 5.0 / 100, 1e-12);
    EXPECT_NEAR(Trapezoid(0.01, 5, 100).duration().count(), 2 * std::sqrt(0.01 / 100), 1e-12);
    EXPECT_EQ(Trapezoid(0, 5, 100).duration().count(), 0);
}

TEST(TrapezoidTest, TimeAtInvertsDistance) {
    constexpr std::uint64_t kSeed = 4;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int i = 0; i < 1000; ++i) {
        Trapezoid profile(random.uniform(0.01, 40), random.uniform(0.1, 60), random.uniform(10, 500));
        if (random.chance(0.5)) profile = profile.stopped_from(random.uniform(0, 1) * profile.duration());
        const double distance = random.uniform(0, 1) * profile.length();
        const auto time = profile.time_at(distance);
        ASSERT_TRUE(time);
        EXPECT_NEAR(profile.distance(*time), distance, 1e-9);
        EXPECT_FALSE(profile.time_at(profile.length() * (1 + 1e-9) + 1e-12));
    }
}

TEST(TrapezoidTest, AStopTakesTheBrakingDistanceAndAStopWhileBrakingChangesNothing) {
    const Trapezoid profile(10, 5, 100);
    const Trapezoid stopped = profile.stopped_from(Seconds(1.0));
    EXPECT_NEAR(stopped.length(), profile.distance(Seconds(1.0)) + 25.0 / 200, 1e-12);
    EXPECT_NEAR(stopped.duration().count(), 1.05, 1e-12);
    EXPECT_NEAR(profile.stopped_from(profile.duration() - Seconds(0.01)).length(), 10, 1e-12);
    EXPECT_NEAR(stopped.stopped_from(Seconds(1.02)).length(), stopped.length(), 1e-12);
}

TEST(TrapezoidTest, FromASpeedItEndsAtItsLengthAndNeverBrakesHarder) {
    constexpr std::uint64_t kSeed = 8;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int i = 0; i < 500; ++i) {
        const double acceleration = random.uniform(10, 500);
        const double feed = random.uniform(0.1, 60);
        const double speed = random.uniform(0, 60);
        const double length = speed * speed / (2 * acceleration) + random.uniform(0, 20);
        const Trapezoid profile(length, feed, acceleration, speed);
        EXPECT_NEAR(profile.length(), length, 1e-9);
        EXPECT_NEAR(profile.speed(Seconds(0)), speed, 1e-9);
        double last = speed;
        constexpr int kSteps = 400;
        const double dt = profile.duration().count() / kSteps;
        for (int k = 1; k <= kSteps; ++k) {
            const double now = profile.speed(Seconds(k * dt));
            EXPECT_LE(std::abs(now - last), acceleration * dt * (1 + 1e-6) + 1e-9);
            EXPECT_LE(now, std::max(speed, feed) + 1e-9);
            last = now;
        }
        const Trapezoid stopped = profile.stopped_from(Seconds(random.uniform(0, 1) * profile.duration().count()));
        EXPECT_LE(stopped.length(), length + 1e-9);
        EXPECT_LE(stopped.duration().count(), profile.duration().count() + 1e-9);
    }
}

}  // namespace
}  // namespace palpate::trapezoid_test
