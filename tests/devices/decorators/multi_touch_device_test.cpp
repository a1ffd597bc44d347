#include "devices/decorators/multi_touch_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "devices/errors.h"
#include "tests/devices/fake_probe.h"
#include "tests/random.h"

namespace palpate::multi_touch_device_test {
namespace {

using Outcome = MoveResult::Outcome;
using Kind = DeviceEvent::Kind;

constexpr double kRetract = 1;
constexpr double kWall = 3;  // x of the wall that is touched, going down from x = 10
const Point kStart{10, 0, 0};
const Point kBehind{0, 0, 0};

MultiTouchOptions touches(int samples, double tolerance_mm = 0.02, int retries = 3) {
    MultiTouchOptions options;
    options.samples = samples;
    options.tolerance_mm = tolerance_mm;
    options.retries = retries;
    return options;
}

FakeProbe wall(double retract = kRetract) { return {half_space(Vector::UnitX(), kWall), kStart, retract}; }

// The n-th touch of S is off by the n-th number (mm along the way), further ones by nothing.
void script_noise(FakeProbe& probe, std::vector<double> offsets) {
    probe.noise = [offsets = std::move(offsets), k = std::size_t{0}](Pace) mutable { return k < offsets.size() ? offsets[k++] : 0.0; };
}

// Triggers falsely in the moves with these numbers, so far along the way (mm).
void script_false_triggers(FakeProbe& probe, std::vector<std::pair<std::size_t, double>> triggers) {
    probe.false_trigger = [triggers = std::move(triggers), &probe](const FakeProbe::Move&) -> std::optional<double> {
        for (const auto& [move, place] : triggers) {
            if (move == probe.log.size()) return place;
        }
        return std::nullopt;
    };
}

std::vector<Kind> kinds(const MoveResult& result) {
    std::vector<Kind> all;
    for (const DeviceEvent& event : result.events) all.push_back(event.kind);
    return all;
}

std::vector<Pace> paces(const FakeProbe& probe) {
    std::vector<Pace> all;
    for (const auto& move : probe.log) all.push_back(move.pace);
    return all;
}

std::size_t slow_touches(const FakeProbe& probe) { return static_cast<std::size_t>(std::ranges::count(paces(probe), Pace::touch)); }

// --- one sample ------------------------------------------------------------------------------------------------------

TEST(MultiTouchDevice, MovesThatTouchNothingPassAsTheyAre) {
    FakeProbe probe = wall();
    MultiTouchDevice device(probe, touches(3), kRetract);
    EXPECT_EQ(device.guarded_move({4, 1, 0}, Pace::probe), (MoveResult{Outcome::reached, {4, 1, 0}}));
    EXPECT_EQ(device.guarded_move({5, 1, 0}, Pace::travel), (MoveResult{Outcome::reached, {5, 1, 0}}));
    EXPECT_EQ(device.guarded_move({5, 1, 0}, Pace::travel), (MoveResult{Outcome::reached, {5, 1, 0}}));
    EXPECT_EQ(paces(probe), std::vector<Pace>({Pace::probe, Pace::travel, Pace::travel}));
    device.stop();
    EXPECT_EQ(probe.stops, 1);
}

TEST(MultiTouchDevice, WithOneSampleTheFirstTouchCountsOnceASlowOneAgrees) {
    FakeProbe probe = wall();
    script_noise(probe, {0.01, -0.005});
    MultiTouchDevice device(probe, touches(1), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), 2.99, 1e-12);
    EXPECT_TRUE(result.events.empty());
    EXPECT_EQ(paces(probe), std::vector<Pace>({Pace::probe, Pace::touch}));
    EXPECT_NEAR(probe.log.at(1).target.x(), 2.99 - MultiTouchDevice::kOverreach, 1e-12);
    EXPECT_NEAR(device.position().x(), 2.99 + kRetract, 1e-12);
}

TEST(MultiTouchDevice, WithoutConfirmationOneTouchIsEnough) {
    FakeProbe probe = wall();
    script_noise(probe, {0.01});
    MultiTouchOptions options = touches(1);
    options.confirm = false;
    MultiTouchDevice device(probe, options, kRetract);
    EXPECT_NEAR(device.guarded_move(kBehind, Pace::probe).position.x(), 2.99, 1e-12);
    EXPECT_EQ(probe.log.size(), 1U);
}

TEST(MultiTouchDevice, AFirstTouchThatTheSlowOnesDoNotAgreeWithIsDropped) {
    FakeProbe probe = wall();
    script_noise(probe, {0.05, 0.001, 0.002});
    MultiTouchDevice device(probe, touches(1), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), 2.999, 1e-12);
    ASSERT_EQ(kinds(result), std::vector<Kind>({Kind::scattered_touch}));
    EXPECT_NEAR(result.events.at(0).position.x(), 2.95, 1e-12);
    EXPECT_EQ(slow_touches(probe), 2U);
}

TEST(MultiTouchDevice, ADiscardedTouchIsTheFirstSlowOne) {
    FakeProbe probe = wall();
    script_noise(probe, {0.1, 0.06, 0.002});
    MultiTouchOptions options = touches(1);
    options.discard_first = true;
    MultiTouchDevice device(probe, options, kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_NEAR(result.position.x(), 2.998, 1e-12);
    EXPECT_TRUE(result.events.empty());
    EXPECT_EQ(slow_touches(probe), 2U);
}

// --- several samples -------------------------------------------------------------------------------------------------

TEST(MultiTouchDevice, TheAnswerIsTheMedianOfTheSlowTouches) {
    FakeProbe probe = wall();
    script_noise(probe, {0.1, 0.004, -0.003, 0.001});
    MultiTouchDevice device(probe, touches(3), kRetract);
    EXPECT_NEAR(device.guarded_move(kBehind, Pace::probe).position.x(), 2.999, 1e-12);
    EXPECT_EQ(slow_touches(probe), 3U);
}

TEST(MultiTouchDevice, TheMedianOfTwoIsTheirMean) {
    FakeProbe probe = wall();
    script_noise(probe, {0, 0.004, -0.006});
    MultiTouchDevice device(probe, touches(2), kRetract);
    EXPECT_NEAR(device.guarded_move(kBehind, Pace::probe).position.x(), 3.001, 1e-12);
}

TEST(MultiTouchDevice, TheFarthestTouchIsDroppedAndTheGoodOnesAreKept) {
    FakeProbe probe = wall();
    script_noise(probe, {0, 0.004, 0.1, -0.003, 0.001});
    MultiTouchDevice device(probe, touches(3), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), 2.999, 1e-12);
    ASSERT_EQ(kinds(result), std::vector<Kind>({Kind::scattered_touch}));
    EXPECT_NEAR(result.events.at(0).position.x(), 2.9, 1e-12);
    EXPECT_EQ(slow_touches(probe), 4U);
}

TEST(MultiTouchDevice, TouchesThatNeverAgreeFailAfterTheRetriesAndLeaveTheToolOnTheWay) {
    FakeProbe probe = wall();
    script_noise(probe, {0, 0.00, 0.10, 0.05, 0.15, 0.01, 0.12});
    MultiTouchDevice device(probe, touches(3, 0.02, 2), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::failed);
    EXPECT_EQ(kinds(result), std::vector<Kind>(3, Kind::scattered_touch));
    EXPECT_EQ(slow_touches(probe), 5U);
    EXPECT_NEAR(result.position.x(), kWall, 0.15);
    EXPECT_GT(device.position().x(), kWall);
}

TEST(MultiTouchDevice, ADeviceThatRestsOnWhatItTouchesIsTakenBackBeforeEveryTouch) {
    FakeProbe probe = wall(0);
    script_noise(probe, {0, 0.001, 0.003, 0.002});
    MultiTouchDevice device(probe, touches(3), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_NEAR(result.position.x(), 2.998, 1e-12);
    EXPECT_EQ(paces(probe), std::vector<Pace>({Pace::probe, Pace::probe, Pace::touch, Pace::probe, Pace::touch, Pace::probe, Pace::touch}));
    EXPECT_NEAR(probe.log.at(1).target.x(), kWall + kRetract, 1e-12);
    EXPECT_NEAR(device.position().x(), 2.998, 1e-12);
}

TEST(MultiTouchDevice, ATouchDeeperThanTheAnswerIsNotWhereTheToolRests) {
    FakeProbe probe = wall(0);
    script_noise(probe, {0, 0.001, 0.002, 0.003});
    MultiTouchDevice device(probe, touches(3), kRetract);
    EXPECT_NEAR(device.guarded_move(kBehind, Pace::probe).position.x(), 2.998, 1e-12);
    EXPECT_NEAR(device.position().x(), 2.998 + kRetract, 1e-12);
}

TEST(MultiTouchDevice, ATouchWhereTheMoveBeganIsMeasuredFromThere) {
    FakeProbe probe(half_space(Vector::UnitX(), kWall), {kWall, 0, 0}, kRetract);
    MultiTouchDevice device(probe, touches(3), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result, (MoveResult{Outcome::contact, {kWall, 0, 0}}));
    EXPECT_EQ(device.position(), Point(kWall, 0, 0));
}

// --- false triggers --------------------------------------------------------------------------------------------------

TEST(MultiTouchDevice, AfterAFalseTriggerTravelGoesOnToWhatIsReallyThere) {
    FakeProbe probe = wall();
    script_false_triggers(probe, {{0, 2.5}});
    MultiTouchDevice device(probe, touches(3), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::travel);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), kWall, 1e-12);
    ASSERT_EQ(kinds(result), std::vector<Kind>({Kind::spurious_trigger}));
    EXPECT_NEAR(result.events.at(0).position.x(), 7.5, 1e-12);
    EXPECT_EQ(slow_touches(probe), 3U) << "two after the false one, one after the true one";
    EXPECT_EQ(probe.log.back().pace, Pace::touch);
}

TEST(MultiTouchDevice, AfterAFalseTriggerInEmptySpaceTheTargetOfTravelIsReached) {
    FakeProbe probe(nothing(), kStart, kRetract);
    script_false_triggers(probe, {{0, 2.5}, {4, 4.0}});
    MultiTouchDevice device(probe, touches(1), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::travel);
    EXPECT_EQ(result.outcome, Outcome::reached);
    EXPECT_EQ(result.position, kBehind);
    EXPECT_EQ(device.position(), kBehind);
    EXPECT_EQ(kinds(result), std::vector<Kind>(2, Kind::spurious_trigger));
}

// What closed it may have been S, and the probe have died: a touch elsewhere has to tell before the tool goes on.
TEST(MultiTouchDevice, WhatIsNotMetAgainTwiceEndsAProbeBeforeIt) {
    for (const int samples : {1, 3}) {
        FakeProbe probe(nothing(), kStart, kRetract);
        script_false_triggers(probe, {{0, 2.5}});
        MultiTouchDevice device(probe, touches(samples), kRetract);
        const MoveResult result = device.guarded_move(kBehind, Pace::probe);
        EXPECT_EQ(result.outcome, Outcome::vanished);
        EXPECT_NEAR(result.position.x(), 7.5, 1e-12);
        EXPECT_NEAR(device.position().x(), 7.5 + kRetract, 1e-12);
        EXPECT_EQ(slow_touches(probe), 2U);
        EXPECT_EQ(kinds(result), std::vector<Kind>({Kind::spurious_trigger}));
        for (const auto& move : probe.log) {
            EXPECT_TRUE(&move == &probe.log.front() || move.target.x() >= 7.5 - MultiTouchDevice::kOverreach - 1e-12) << "no deeper";
        }
    }
}

TEST(MultiTouchDevice, ATouchThatTheProbeMissesOnceIsMetTheNextTime) {
    FakeProbe probe(half_space(Vector::UnitX(), kWall), kStart, kRetract);
    script_noise(probe, {0.0, 1.0});  // the second touch is past the end of its way
    MultiTouchDevice device(probe, touches(1), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), kWall, 1e-12);
    EXPECT_EQ(slow_touches(probe), 3U) << "the one that was missed, and two that agree with the first";
}

TEST(MultiTouchDevice, ARealTouchDuringTravelIsAContact) {
    FakeProbe probe = wall();
    MultiTouchDevice device(probe, touches(5), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::travel);
    EXPECT_EQ(result, (MoveResult{Outcome::contact, {kWall, 0, 0}}));
    EXPECT_EQ(paces(probe), std::vector<Pace>({Pace::travel, Pace::touch}));
}

TEST(MultiTouchDevice, TravelIsNotLookedAtAgainUnlessAskedFor) {
    FakeProbe probe(nothing(), kStart, kRetract);
    script_false_triggers(probe, {{0, 2.5}});
    MultiTouchOptions options = touches(3);
    options.confirm_travel = false;
    MultiTouchDevice device(probe, options, kRetract);
    EXPECT_EQ(device.guarded_move(kBehind, Pace::travel).outcome, Outcome::contact);
    EXPECT_EQ(probe.log.size(), 1U);
}

TEST(MultiTouchDevice, SlowTouchesOfSomebodyElsePassAsTheyAre) {
    FakeProbe probe = wall();
    MultiTouchDevice device(probe, touches(3), kRetract);
    EXPECT_EQ(device.guarded_move(kBehind, Pace::touch), (MoveResult{Outcome::contact, {kWall, 0, 0}}));
    EXPECT_EQ(probe.log.size(), 1U);
}

// The slow touch begins 1 mm before the wall and triggers at once.
TEST(MultiTouchDevice, AFalseTriggerOfASlowTouchDoesNotCount) {
    FakeProbe probe = wall();
    script_false_triggers(probe, {{1, 0.25}});
    MultiTouchDevice device(probe, touches(3), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_NEAR(result.position.x(), kWall, 1e-12);
    ASSERT_EQ(kinds(result), std::vector<Kind>({Kind::spurious_trigger}));
    EXPECT_NEAR(result.events.at(0).position.x(), kWall + 0.75, 1e-12);
    EXPECT_EQ(slow_touches(probe), 4U);
}

// The first touch of nothing, and one slow one near it; then two that meet nothing.
TEST(MultiTouchDevice, WhatMoreTouchesMissThanMeetIsNotThere) {
    FakeProbe probe(nothing(), kStart, kRetract);
    script_false_triggers(probe, {{0, 5.0}, {1, 1.05}});
    MultiTouchDevice device(probe, touches(3), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::vanished);
    EXPECT_NEAR(device.position().x(), 5.0 + kRetract, 1e-12);
    EXPECT_EQ(kinds(result), std::vector<Kind>({Kind::scattered_touch, Kind::spurious_trigger}));
}

TEST(MultiTouchDevice, AProbeThatChattersFailsTheMove) {
    FakeProbe probe(nothing(), kStart, kRetract);
    probe.false_trigger = [](const FakeProbe::Move& move) { return move.target.x() == -90 ? std::optional(0.25) : std::nullopt; };
    MultiTouchDevice device(probe, touches(1), kRetract);
    const MoveResult result = device.guarded_move({-90, 0, 0}, Pace::travel);
    EXPECT_EQ(result.outcome, Outcome::failed);
    EXPECT_EQ(result.events.size(), static_cast<std::size_t>(kMaxFalseTriggers) + 1);
}

TEST(MultiTouchDevice, ATriggerOnTheWayBackIsFalseAndManyAreAFault) {
    FakeProbe once = wall(0);
    script_false_triggers(once, {{1, 0.25}});
    MultiTouchDevice device(once, touches(1), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    EXPECT_EQ(result.outcome, Outcome::contact);
    EXPECT_EQ(kinds(result), std::vector<Kind>({Kind::spurious_trigger}));

    FakeProbe always = wall(0);
    always.false_trigger = [](const FakeProbe::Move& move) { return move.target.x() > move.from.x() ? std::optional(0.01) : std::nullopt; };
    MultiTouchDevice other(always, touches(1), kRetract);
    EXPECT_THROW((void)other.guarded_move(kBehind, Pace::probe), UnexpectedContact);
}

// --- bounds, faults, options -----------------------------------------------------------------------------------------

TEST(MultiTouchDevice, NoTouchIsAimedPastTheTarget) {
    FakeProbe probe = wall();
    MultiTouchDevice device(probe, touches(3), kRetract);
    const Point target{kWall - 0.05, 0, 0};
    EXPECT_EQ(device.guarded_move(target, Pace::probe).outcome, Outcome::contact);
    for (const auto& move : probe.log) EXPECT_EQ(move.target, target);
}

TEST(MultiTouchDevice, EventsOfTheDeviceAreKeptInOrder) {
    FakeProbe probe = wall();
    int asked = 0;
    probe.events = [&] { return std::vector<DeviceEvent>{{Kind::repeated_command, {static_cast<double>(asked++), 0, 0}}}; };
    MultiTouchDevice device(probe, touches(2), kRetract);
    const MoveResult result = device.guarded_move(kBehind, Pace::probe);
    ASSERT_EQ(result.events.size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(result.events[k].position.x(), static_cast<double>(k));
}

TEST(MultiTouchDevice, FaultsPassThrough) {
    FakeProbe probe = wall();
    probe.fault = [&] { return probe.log.size() == 2; };
    MultiTouchDevice device(probe, touches(3), kRetract);
    EXPECT_THROW((void)device.guarded_move(kBehind, Pace::probe), ConnectionLost);
}

TEST(MultiTouchDevice, OptionsOutOfRangeAreRefused) {
    FakeProbe probe = wall();
    EXPECT_THROW(MultiTouchDevice(probe, touches(0), kRetract), std::invalid_argument);
    EXPECT_THROW(MultiTouchDevice(probe, touches(1, 0.0), kRetract), std::invalid_argument);
    EXPECT_THROW(MultiTouchDevice(probe, touches(1, std::numeric_limits<double>::quiet_NaN()), kRetract), std::invalid_argument);
    EXPECT_THROW(MultiTouchDevice(probe, touches(1, 0.02, -1), kRetract), std::invalid_argument);
    EXPECT_THROW(MultiTouchDevice(probe, touches(1), -1), std::invalid_argument);
}

// --- against brute force ---------------------------------------------------------------------------------------------

double median_of(std::vector<double> values) {
    std::ranges::sort(values);
    return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

// Whether some `n` of the values lie within `tolerance` of each other and have that median: by trying all subsets.
bool some_agree(const std::vector<double>& values, std::size_t n, double tolerance, double median) {
    for (std::size_t mask = 0; mask < (std::size_t{1} << values.size()); ++mask) {
        std::vector<double> chosen;
        for (std::size_t k = 0; k < values.size(); ++k) {
            if ((mask >> k & 1U) != 0) chosen.push_back(values[k]);
        }
        if (chosen.size() != n) continue;
        const auto [low, high] = std::ranges::minmax(chosen);
        if (high - low <= tolerance + 1e-12 && std::abs(median_of(chosen) - median) < 1e-9) return true;
    }
    return false;
}

TEST(MultiTouchDevice, RandomNoiseEveryContactIsTheMedianOfTouchesThatAgreeAndEveryFailureHadItsRetries) {
    const std::uint64_t seed = 20;
    SCOPED_TRACE(seed_text(seed));
    Random random(seed);
    int contacts = 0;
    int failures = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        MultiTouchOptions options = touches(2 + static_cast<int>(random.below(4)), 0.02, static_cast<int>(random.below(4)));
        options.discard_first = random.chance(0.5);
        const double outliers = random.uniform(0, 0.6);
        FakeProbe probe = wall(random.chance(0.5) ? kRetract : 0);
        probe.noise = [&](Pace) { return random.chance(outliers) ? random.uniform(-0.08, 0.08) : random.uniform(-0.008, 0.008); };
        MultiTouchDevice device(probe, options, kRetract);
        const MoveResult result = device.guarded_move(kBehind, Pace::probe);

        std::vector<double> slow;
        for (const auto& move : probe.log) {
            if (move.pace == Pace::touch) slow.push_back(move.result.position.x());
        }
        if (options.discard_first) slow.erase(slow.begin());
        const auto n = static_cast<std::size_t>(options.samples);
        ASSERT_EQ(slow.size() + (result.outcome == Outcome::failed ? 1 : 0), n + result.events.size()) << "a good touch was thrown away";
        if (result.outcome == Outcome::contact) {
            ++contacts;
            ASSERT_LE(result.events.size(), static_cast<std::size_t>(options.retries));
            ASSERT_TRUE(some_agree(slow, n, options.tolerance_mm, result.position.x())) << "trial " << trial;
            ASSERT_GE(device.position().x(), result.position.x() - 1e-6) << "rests behind what it touched";
        } else {
            ++failures;
            ASSERT_EQ(result.outcome, Outcome::failed);
            ASSERT_EQ(result.events.size(), static_cast<std::size_t>(options.retries) + 1);
        }
    }
    EXPECT_GT(contacts, 500);
    EXPECT_GT(failures, 300);
}

TEST(MultiTouchDevice, RandomFalseTriggersNeverChangeWhatIsThere) {
    const std::uint64_t seed = 21;
    SCOPED_TRACE(seed_text(seed));
    Random random(seed);
    constexpr double kNoise = 0.004;
    constexpr double kRadius = 4;
    const FirstHit truth = ball(Point::Zero(), kRadius);
    std::size_t false_triggers = 0;
    int contacts = 0;
    int failures = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        const Point start = 8 * random.direction();
        const Point target = random.around(Box{Point::Constant(-4), Point::Constant(4)}, 0.2);
        FakeProbe probe(truth, start, random.chance(0.5) ? kRetract : 0);
        probe.noise = [&](Pace) { return random.uniform(-kNoise, kNoise); };
        probe.false_trigger = [&](const FakeProbe::Move& move) {
            return random.chance(0.1) ? std::optional(random.uniform(0, (move.target - move.from).norm())) : std::nullopt;
        };
        MultiTouchOptions options = touches(1 + static_cast<int>(random.below(3)), 0.02, 6);
        MultiTouchDevice device(probe, options, kRetract);
        const Pace pace = random.chance(0.7) ? Pace::probe : Pace::travel;
        MoveResult result = device.guarded_move(target, pace);
        while (result.outcome == Outcome::vanished) result = device.guarded_move(target, pace);

        const Vector way = (target - start).normalized();
        const auto hit = truth(start, target);
        const double length = (target - start).norm();
        // Near the target, noise decides; what grazes the ball has no place.
        if (std::abs(hit.value_or(length) - length) < 2 * kNoise && hit) continue;
        if (result.outcome == Outcome::failed) {
            ++failures;  // nothing is claimed
            continue;
        }
        ASSERT_EQ(result.outcome, hit ? Outcome::contact : Outcome::reached) << "trial " << trial;
        if (hit) {
            ++contacts;
            // A false trigger that near to S cannot be told from a touch.
            ASSERT_NEAR((result.position - start).norm(), *hit, kNoise + options.tolerance_mm) << "trial " << trial;
            ASSERT_LE((device.position() - start).norm(), (result.position - start).norm() + 1e-6);
        }
        for (const auto& move : probe.log) {
            false_triggers += move.is_false ? 1 : 0;
            for (const Point& p : {move.target, move.result.position}) {
                ASSERT_LT((p - start - (p - start).dot(way) * way).norm(), 1e-9) << "left the line";
                ASSERT_LE((p - start).dot(way), length + 1e-9) << "went past the target";
                ASSERT_GE((p - start).dot(way), -1e-9) << "went back past the start";
            }
        }
    }
    EXPECT_GT(contacts, 1000);
    EXPECT_LT(failures, 10);
    EXPECT_GT(false_triggers, 500U);
}

}  // namespace
}  // namespace palpate::multi_touch_device_test
