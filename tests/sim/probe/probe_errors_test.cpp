#include "sim/probe/probe_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <vector>

#include "sim/machines/virtual_tool.h"
#include "sim/objects/hidden_object.h"
#include "sim/simulated_device.h"
#include "sim/tool/tool_obstacle.h"
#include "tests/random.h"

namespace palpate::probe_errors_test {
namespace {

constexpr double kFine = 1e-9;  // mm: resolution of a virtual machine that hides nothing

// One way to touch an obstacle with a probe that errs: the same questions to both devices that do.
class Toucher {
public:
    Toucher() = default;
    virtual ~Toucher() = default;
    Toucher(const Toucher&) = delete;
    Toucher& operator=(const Toucher&) = delete;
    Toucher(Toucher&&) = delete;
    Toucher& operator=(Toucher&&) = delete;

    // What is reported; the tool rests where it then is.
    virtual Point touch(const Point& target) = 0;
    virtual void go(const Point& target) = 0;
    [[nodiscard]] virtual std::uint64_t unsafe_moves() const = 0;
    // From `from` straight to `target`, and back.
    Point touch_from(const Point& from, const Point& target) {
        go(from);
        const Point touched = touch(target);
        go(from);
        return touched;
    }
};

class OnSimulated final : public Toucher {
public:
    OnSimulated(const Obstacle& obstacle, const Point& start, const ProbeErrors& errors, double feed)
        : device_(obstacle, start, {.errors = errors, .motion = motion(feed)}) {}
    Point touch(const Point& target) override {
        const MoveResult result = device_.guarded_move(target, Pace::probe);
        EXPECT_EQ(result.outcome, MoveResult::Outcome::contact);
        return result.position;
    }
    void go(const Point& target) override { EXPECT_EQ(device_.guarded_move(target, Pace::travel).outcome, MoveResult::Outcome::reached); }
    [[nodiscard]] std::uint64_t unsafe_moves() const override { return device_.unsafe_moves(); }

private:
    static MotionModel motion(double feed) {
        MotionModel motion;
        motion.feeds.probe_mm_per_s = feed;
        return motion;
    }
    SimulatedDevice device_;
};

class OnVirtual final : public Toucher {
public:
    OnVirtual(const Obstacle& obstacle, const Point& start, const ProbeErrors& errors, double feed)
        : tool_(obstacle, options(start, errors)), feed_(feed) {}
    Point touch(const Point& target) override {
        tool_.start_move(target, feed_, VirtualTool::Guard::until_contact);
        tool_.finish();
        EXPECT_TRUE(tool_.trigger());
        return tool_.trigger().value_or(Point::Zero());
    }
    void go(const Point& target) override {
        tool_.start_move(target, 20, VirtualTool::Guard::none);
        tool_.finish();
    }
    [[nodiscard]] std::uint64_t unsafe_moves() const override { return tool_.audit().unsafe_moves; }

private:
    static VirtualToolOptions options(const Point& start, const ProbeErrors& errors) {
        VirtualToolOptions options;
        options.start = start;
        options.errors = errors;
        options.motion.resolution_mm = kFine;
        return options;
    }
    VirtualTool tool_;
    double feed_;
};

struct Moments {
    double mean = 0.0;
    double sigma = 0.0;
};
Moments moments_of(const std::vector<double>& values) {
    const auto count = static_cast<double>(values.size());
    Moments m;
    m.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    for (const double v : values) m.sigma += (v - m.mean) * (v - m.mean);
    m.sigma = std::sqrt(m.sigma / (count - 1));
    return m;
}

// On a device of each kind.
class ProbeErrorsTest : public testing::TestWithParam<bool> {
protected:
    std::unique_ptr<Toucher> toucher(const Obstacle& obstacle, const Point& start, double feed = 5) const {
        if (GetParam()) return std::make_unique<OnVirtual>(obstacle, start, errors, feed);
        return std::make_unique<OnSimulated>(obstacle, start, errors, feed);
    }
    // A ball of 2 mm on the sphere, as a machine's reference point sees it.
    HiddenObject ball{ShapeSpec{SphereSpec{13.5}}};
    HiddenObject block{ShapeSpec{RoundedBoxSpec{{20, 20, 20}, 0.0}}};
    ProbeErrors errors;
};
INSTANTIATE_TEST_SUITE_P(Devices, ProbeErrorsTest, testing::Bool(),
                         [](const auto& which) { return which.param ? "VirtualTool" : "SimulatedDevice"; });

TEST_P(ProbeErrorsTest, RepeatedTouchesOfAPlaneHaveTheSpreadThatWasAskedFor) {
    constexpr int kTouches = 2000;
    errors.sigma_mm = 0.002;
    const auto touches = [&](std::uint64_t seed) {
        errors.seed = seed;
        const auto probe = toucher(block, {3, 2, 12});
        std::vector<double> heights;
        for (int i = 0; i < kTouches; ++i) {
            const Point touched = probe->touch_from({3, 2, 12}, {3, 2, 9});
            EXPECT_NEAR((touched - Point(3, 2, touched.z())).norm(), 0, 1e-9);
            heights.push_back(touched.z());
        }
        EXPECT_EQ(probe->unsafe_moves(), 0U);
        return heights;
    };
    const std::vector<double> first = touches(1);
    const Moments m = moments_of(first);
    // chi² of 1999 degrees of freedom lies within ±3.3 of its standard deviations but once in 1000 times.
    EXPECT_NEAR(m.sigma * m.sigma / (errors.sigma_mm * errors.sigma_mm), 1, 3.3 * std::sqrt(2.0 / (kTouches - 1)));
    EXPECT_NEAR(m.mean, 10, 3.3 * errors.sigma_mm / std::sqrt(kTouches));
    // Of a Gaussian 68.3 % lie within one sigma, and 4.6 % beyond two.
    const auto within = [&](double sigmas) {
        return static_cast<double>(std::ranges::count_if(first, [&](double z) { return std::abs(z - 10) < sigmas * errors.sigma_mm; })) /
               kTouches;
    };
    EXPECT_NEAR(within(1), 0.6827, 3.3 * std::sqrt(0.6827 * 0.3173 / kTouches));
    EXPECT_NEAR(within(2), 0.9545, 3.3 * std::sqrt(0.9545 * 0.0455 / kTouches));
    EXPECT_EQ(touches(1), first) << "to the last bit";
    EXPECT_NE(touches(2), first);
}

// mm: by which a touch of the sphere lies within it.
double pretravel_at(Toucher& probe, const Vector& n) { return 13.5 - probe.touch_from(16 * n, 10 * n).norm(); }
Vector on_equator(double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    return {std::cos(angle), std::sin(angle), 0};
}

TEST_P(ProbeErrorsTest, LobesHaveTheirRangeTwiceTheLeastAndThreeOfThem) {
    errors.lobes_mm = 0.04;
    const auto probe = toucher(ball, {0, 0, 20});
    std::vector<double> around;
    for (int degrees = 0; degrees < 360; degrees += 5) {
        probe->go(20 * on_equator(degrees));
        around.push_back(pretravel_at(*probe, on_equator(degrees)));
        probe->go(20 * on_equator(degrees));
    }
    const auto [least, most] = std::ranges::minmax(around);
    EXPECT_NEAR(most - least, 0.04, 1e-6);
    EXPECT_NEAR(most / least, 2, 1e-4);
    for (std::size_t k = 0; k < around.size(); ++k) {
        EXPECT_NEAR(around[k], around[(k + 24) % 72], 1e-6) << "again after 120 degrees";
        EXPECT_NEAR(around[k] + around[(k + 12) % 72], 0.12, 1e-6) << "and the reverse after 60";
    }
    EXPECT_NEAR(around[0], 0.04, 1e-6) << "least along x";
    probe->go({0, 20, 20});
    EXPECT_NEAR(pretravel_at(*probe, Vector::UnitZ()), 0.02, 1e-6);
    EXPECT_EQ(probe->unsafe_moves(), 0U);
}

TEST_P(ProbeErrorsTest, AMapOfHarmonicsIsWhatItsCorrectionTakesAway) {
    errors.harmonics_mm = {0.003, -0.002, 0.001, 0.004, -0.001, 0.002, 0.001, -0.003, 0.002, 0.001, -0.002, 0.003};
    errors.axis = Vector(0.1, -0.2, 1).normalized();
    const auto probe = toucher(ball, {0, 0, 20});
    const LobingMap map{errors.harmonics_mm, errors.axis};
    Random random(3);
    for (int i = 0; i < 50; ++i) {
        Vector n = random.direction();
        n.z() = std::abs(n.z());
        probe->go(30 * Vector::UnitZ());
        probe->go(20 * n);
        const Point touched = probe->touch_from(16 * n, 10 * n);
        EXPECT_NEAR(map.corrected(touched, n).norm(), 13.5, 1e-6);
        probe->go(20 * n);
    }
}

TEST_P(ProbeErrorsTest, LatencyShiftsTouchesByTheFeed) {
    errors.latency = Seconds(0.004);
    for (const double feed : {1.0, 5.0}) {
        const auto probe = toucher(block, {1, 1, 15}, feed);
        EXPECT_NEAR(10 - probe->touch_from({1, 1, 15}, {1, 1, 5}).z(), 0.004 * feed, 1e-6) << feed;
        EXPECT_NEAR(10 - probe->touch_from({1, 1, 15}, {1, 1, 5}).z(), 0.004 * feed, 1e-6) << feed;
        EXPECT_EQ(probe->unsafe_moves(), 0U);
    }
}

TEST_P(ProbeErrorsTest, AStylusBendsAcrossAndIsStiffAlong) {
    errors.trigger_force_n = 0.1;
    errors.compliance_across_mm_per_n = 0.368;  // carbide of 1.4 mm, 50 mm long
    errors.compliance_along_mm_per_n = 0.002;
    const auto probe = toucher(ball, {0, 0, 20});
    EXPECT_NEAR(pretravel_at(*probe, Vector::UnitZ()), 0.0002, 1e-6);
    const Vector slanted = Vector(0, 1, 1).normalized();
    probe->go(20 * slanted);
    EXPECT_NEAR(pretravel_at(*probe, slanted), (0.0368 + 0.0002) / 2, 1e-6);
    probe->go(20 * Vector::UnitY());
    EXPECT_NEAR(pretravel_at(*probe, Vector::UnitY()), 0.0368, 1e-6);
}

// Towards a plane at a slant the tool goes on until it is as deep, which is farther.
TEST_P(ProbeErrorsTest, PretravelIsAlongTheNormal) {
    errors.trigger_force_n = 1;
    errors.compliance_along_mm_per_n = 0.03;
    const auto probe = toucher(block, {0, 0, 20});
    const Point touched = probe->touch_from({-4, 0, 13}, {4, 0, 9});
    EXPECT_NEAR(touched.z(), 10 - 0.03, 1e-6);
}

// mm: how far outside of the block's planes touches lie, round after round.
std::vector<Vector> rounds_of_touches(Toucher& probe, int rounds) {
    std::vector<Vector> off;
    for (int round = 0; round < rounds; ++round) {
        const auto touched = [&](int axis) {
            const Vector away = Vector::Unit(axis);
            const double at = probe.touch_from(15 * away, 8 * away)[axis];
            probe.go({15, 15, 15});
            return at - 10;
        };
        const double x = touched(0);
        const double y = touched(1);
        off.emplace_back(x, y, touched(2));
    }
    return off;
}

TEST_P(ProbeErrorsTest, DriftIsLinearInTouchesAndOfEachAxisItsOwn) {
    errors.drift_mm_per_1000_touches = {0.03, -0.02, 0.05};
    const auto probe = toucher(block, {15, 15, 15});
    const std::vector<Vector> off = rounds_of_touches(*probe, 30);
    for (std::size_t k = 1; k < off.size(); ++k) {
        // Where the tool is less what is said: what is said of a plane goes the other way.
        EXPECT_LT((off[k] - off[k - 1] + 0.003 * errors.drift_mm_per_1000_touches).norm(), 3e-6) << k;
    }
    EXPECT_EQ(probe->unsafe_moves(), 0U);
}

TEST_P(ProbeErrorsTest, DriftIsLinearInTimeAndSwings) {
    errors.drift_mm_per_hour = {1.8, -3.6, 7.2};
    const std::vector<Vector> off = rounds_of_touches(*toucher(block, {15, 15, 15}), 30);
    const Vector step = (off.back() - off.front()) / 29;
    // A round has 3 touches of 1 s each, and some 15 ways of 10 to 20 mm at 20 mm/s.
    const Vector seconds = -step.cwiseQuotient(errors.drift_mm_per_hour / 3600);
    EXPECT_GT(seconds.minCoeff(), 5);
    EXPECT_LT(seconds.maxCoeff(), 15);
    EXPECT_NEAR(seconds.minCoeff() / seconds.maxCoeff(), 1, 0.01);
    for (std::size_t k = 1; k < off.size(); ++k) EXPECT_LT((off[k] - off[k - 1] - step).norm(), 0.02 * step.norm()) << k;
    errors.drift_mm_per_hour.setZero();
    errors.swing_mm = {0, 0, 0.02};
    errors.swing_period = Seconds(20);
    const auto probe = toucher(block, {0, 0, 15});
    std::vector<double> heights;
    for (int k = 0; k < 60; ++k) heights.push_back(probe->touch_from({0, 0, 15}, {0, 0, 9}).z());
    const auto [least, most] = std::ranges::minmax(heights);
    EXPECT_NEAR(least, 10 - 0.02, 0.002);
    EXPECT_NEAR(most, 10 + 0.02, 0.002);
}

TEST_P(ProbeErrorsTest, AnAxisWithBacklashIsFoundOutByTouchingFromBothSides) {
    errors.backlash_mm = {0.03, 0.01, 0.02};
    const auto probe = toucher(block, {-30, 0, 0});
    EXPECT_NEAR(probe->touch_from({-15, 0, 0}, {-8, 0, 0}).x(), -10, 1e-9) << "on its way up it is where it says";
    probe->go({-15, 0, 20});
    probe->go({15, 0, 20});
    probe->go({15, 0, 0});
    EXPECT_NEAR(probe->touch_from({15, 0, 0}, {8, 0, 0}).x(), 10 - 0.03, 1e-9) << "on its way down it is higher than it says";
    probe->go({15, 15, 0});
    probe->go({0, 15, 0});
    EXPECT_NEAR(probe->touch_from({0, 15, 0}, {0, 8, 0}).y(), 10 - 0.01, 1e-9);
    probe->go({0, 15, 20});
    // One axis turns, the other goes on: the way has a kink, the end does not show it.
    const Point slanted = probe->touch_from({-3, 0, 15}, {3, 0, 9});
    EXPECT_NEAR(slanted.z(), 10 - 0.02, 1e-9);
    EXPECT_EQ(probe->unsafe_moves(), 0U);
}

TEST_P(ProbeErrorsTest, EachErrorIsDrawnByItself) {
    errors.sigma_mm = 0.002;
    const auto heights = [&] {
        const auto probe = toucher(block, {0, 0, 15});
        std::vector<double> all;
        for (int k = 0; k < 20; ++k) all.push_back(probe->touch_from({0, 0, 15}, {0, 0, 9}).z());
        return all;
    };
    const std::vector<double> alone = heights();
    errors.misses = 1e-12;
    errors.false_triggers = 1e-12;
    errors.bounces = 1e-12;
    EXPECT_EQ(heights(), alone);
}

TEST(ProbeErrors, WithoutAnyDevicesAreExact) {
    EXPECT_FALSE(ProbeErrors{}.is_any());
    EXPECT_EQ(ProbeErrors{}.touch_error(5), 0.0);
    ProbeErrors stiff;
    stiff.trigger_force_n = 1;
    EXPECT_FALSE(stiff.is_any());
    ProbeErrors moving;
    moving.swing_mm.z() = 0.001;
    EXPECT_TRUE(moving.is_any());
}

TEST(ProbeErrors, PretravelIsWithinTheTouchError) {
    ProbeErrors errors;
    errors.lobes_mm = 0.04;
    errors.trigger_force_n = 0.2;
    errors.compliance_across_mm_per_n = 0.05;
    errors.harmonics_mm = {0.003, -0.002, 0.001, 0.004, -0.001, 0.002, 0.001, -0.003, 0.002, 0.001, -0.002, 0.003};
    Random random(8);
    for (int i = 0; i < 1000; ++i) EXPECT_LE(std::abs(errors.pretravel(random.direction())), errors.touch_error(5));
}

TEST(SimulatedDeviceErrors, FalseTriggersEndMovesWhereNothingIsAndMissesGoThrough) {
    const HiddenObject ball(ShapeSpec{SphereSpec{1.0}});
    ProbeErrors errors;
    errors.false_triggers = 0.2;
    SimulatedDevice sparking(ball, {0, 0, 5}, {.errors = errors});
    int sparks = 0;
    constexpr int kMoves = 1000;
    for (int k = 0; k < kMoves; ++k) {
        const MoveResult result = sparking.guarded_move({0, k % 2 == 0 ? 5.0 : -5.0, 5}, Pace::probe);
        if (result.outcome != MoveResult::Outcome::contact) continue;
        ++sparks;
        EXPECT_FALSE(result.held);
        EXPECT_EQ(result.position, sparking.position());
    }
    EXPECT_NEAR(sparks, 0.2 * kMoves, 3.3 * std::sqrt(0.16 * kMoves));
    EXPECT_EQ(sparking.unsafe_moves(), 0U);
    errors = {};
    errors.misses = 1;
    SimulatedDevice dead(ball, {0, 0, 5}, {.errors = errors});
    EXPECT_EQ(dead.guarded_move({0, 0, -5}, Pace::probe).outcome, MoveResult::Outcome::reached);
    EXPECT_EQ(dead.unsafe_moves(), 1U) << "the account sees where the tool was";
}

TEST(VirtualToolErrors, FalseTriggersMissesAndBouncesHaveTheirShares) {
    const HiddenObject ball(ShapeSpec{SphereSpec{10.0}});
    const auto count = [&](const ProbeErrors& errors, const Point& target) {
        VirtualToolOptions options;
        options.start = {20, 0, 0};
        options.errors = errors;
        int triggers = 0;
        int changes = 0;
        for (std::uint64_t k = 0; k < 500; ++k) {
            options.errors.seed = 10 * k + 1;
            VirtualTool tool(ball, options);
            tool.start_move(target, 20, VirtualTool::Guard::until_contact);
            bool was = tool.is_probe_closed();
            while (const auto next = tool.time_to_event()) {
                tool.advance(*next);
                if (tool.is_probe_closed() != was) ++changes;
                was = tool.is_probe_closed();
            }
            if (tool.trigger()) ++triggers;
        }
        return std::pair(triggers, changes);
    };
    ProbeErrors errors;
    errors.false_triggers = 0.3;
    EXPECT_NEAR(count(errors, {20, 30, 0}).first, 150, 3.3 * std::sqrt(0.21 * 500));
    errors = {};
    errors.misses = 0.3;
    EXPECT_NEAR(count(errors, {9, 0, 0}).first, 350, 3.3 * std::sqrt(0.21 * 500));
    errors = {};
    errors.bounces = 0.3;
    const auto [triggers, changes] = count(errors, {9, 0, 0});
    EXPECT_EQ(triggers, 500);
    EXPECT_NEAR((changes - 500) / 2.0, 150, 3.3 * std::sqrt(0.21 * 500));
}

// What is not pressed as far as the pre-travel has not triggered, and shows nothing as it is left.
TEST(VirtualToolErrors, ATargetWithinThePretravelIsReached) {
    const HiddenObject block(ShapeSpec{RoundedBoxSpec{{20, 20, 20}, 0.0}});
    VirtualToolOptions options;
    options.start = {0, 0, 15};
    options.errors.trigger_force_n = 1;
    options.errors.compliance_along_mm_per_n = 0.02;
    VirtualTool tool(block, options);
    const auto move = [&](double z, VirtualTool::Guard guard) {
        tool.start_move({0, 0, z}, 5, guard);
        tool.finish();
        return tool.trigger();
    };
    EXPECT_FALSE(move(9.99, VirtualTool::Guard::until_contact)) << "pressed by half the pre-travel";
    EXPECT_FALSE(tool.is_probe_closed());
    EXPECT_EQ(tool.audit().deepest_end_mm, tool.position().z() < 10 ? 10 - tool.true_position().z() : 0.0) << "and the account knows";
    EXPECT_FALSE(move(12, VirtualTool::Guard::until_contact)) << "leaves without a touch";
    EXPECT_FALSE(move(9.99, VirtualTool::Guard::until_contact));
    EXPECT_TRUE(move(9.9, VirtualTool::Guard::until_contact)) << "deeper, it triggers";
    EXPECT_TRUE(tool.is_probe_closed());
    const auto opened = move(12, VirtualTool::Guard::until_release);
    ASSERT_TRUE(opened);
    EXPECT_NEAR(opened->z(), 9.98, 1e-9) << "opens where it would close";
    EXPECT_EQ(tool.audit().unsafe_moves, 0U);
}

// The account is of the true place: what is said may lie in the solid while the tool is not, and the other way round.
TEST(VirtualToolErrors, TheAccountIsOfTheTruePlace) {
    const HiddenObject block(ShapeSpec{RoundedBoxSpec{{20, 20, 20}, 0.0}});
    VirtualToolOptions options;
    options.start = {0, 0, 15};
    options.errors.backlash_mm = {0, 0, 0.05};
    std::vector<std::pair<Segment, bool>> told;
    options.on_move = [&](const Segment& way, bool touched) { told.emplace_back(way, touched); };
    VirtualTool tool(block, options);
    tool.start_move({0, 0, 9.96}, 5, VirtualTool::Guard::none);
    tool.finish();
    EXPECT_EQ(tool.position(), Point(0, 0, 9.96));
    EXPECT_NEAR(tool.true_position().z(), 10.01, 1e-12);
    EXPECT_EQ(tool.audit().unsafe_moves, 0U);
    ASSERT_EQ(told.size(), 2U) << "the axis stood, then went";
    EXPECT_EQ(told[0].first.source, told[0].first.target);
    EXPECT_NEAR(told[1].first.target.z(), 10.01, 1e-12);
    tool.start_move({0, 0, 9.94}, 5, VirtualTool::Guard::none);
    tool.finish();
    EXPECT_EQ(tool.audit().unsafe_moves, 1U);
    EXPECT_NEAR(tool.audit().deepest_end_mm, 0.01, 1e-9);
}

// Normals of what a tool touches.
TEST(ObstacleNormal, IsThatOfTheFaceTheEdgeOrTheFixture) {
    const HiddenObject block(ShapeSpec{RoundedBoxSpec{{20, 20, 20}, 0.0}});
    const ToolShape tool{2.0, ToolShape::Shaft{1.4, 30}, std::nullopt, Vector::UnitZ()};
    const ToolObstacle grown(block, tool, {Table{-10}, Box{{20, -5, -10}, {30, 5, 0}}});
    const ToolObstacle bare(block, std::nullopt, {Table{-10}, Box{{20, -5, -10}, {30, 5, 0}}});
    const auto normal = [](const Obstacle& obstacle, const Point& from, const Point& to) {
        const auto hit = obstacle.first_hit({from, to});
        EXPECT_TRUE(hit);
        return obstacle.normal(hit.value_or(to), (to - from).normalized());
    };
    for (const ToolObstacle* obstacle : {&grown, &bare}) {
        EXPECT_LT((normal(*obstacle, {-20, 3, 2}, {0, 1, -1}) - -Vector::UnitX()).norm(), 1e-6);
        EXPECT_LT((normal(*obstacle, {3, 1, 20}, {2, 2, 0}) - Vector::UnitZ()).norm(), 1e-6);
        EXPECT_LT((normal(*obstacle, {-20, 3, 2}, {-17, 1, -20}) - Vector::UnitZ()).norm(), 1e-6) << "the table";
        EXPECT_LT((normal(*obstacle, {25, 1, 10}, {26, 1, -5}) - Vector::UnitZ()).norm(), 1e-6) << "the clamp";
    }
    // A ball that comes down on an edge is pushed away from it.
    const Point touched = *grown.first_hit({{-10.5, 0, 20}, {-10.5, 0, 0}});
    const Vector out = (touched - Point(-10, 0, 10)).normalized();
    EXPECT_LT((grown.normal(touched, -Vector::UnitZ()) - out).norm(), 1e-6);
    // On curved shapes, too.
    const HiddenObject torus(ShapeSpec{TorusSpec{20, 8}});
    EXPECT_LT((normal(torus, {40, 0, 0}, {0, 0, 0}) - Vector::UnitX()).norm(), 1e-6);
    EXPECT_LT((normal(torus, {20, 0, 30}, {20, 0, 0}) - Vector::UnitZ()).norm(), 1e-6);
}

// A tool that rests where it is pressed less than its pre-travel finds the probe open again when it comes back there.
TEST(ErringVirtualTool, OpensOnItsWayBackToWhereItStoodPressedAndOpen) {
    const HiddenObject sphere(ShapeSpec{SphereSpec{5}});
    ProbeErrors errors;
    errors.lobes_mm = 0.04;
    VirtualToolOptions options;
    options.start = {0, 0, 6};
    options.motion.resolution_mm = kFine;
    options.errors = errors;
    VirtualTool tool(sphere, options);
    const double pretravel = errors.pretravel(Vector::UnitZ());
    ASSERT_GT(pretravel, 0.015);
    const Point pressed(0, 0, 5 - 0.4 * pretravel);
    tool.start_move(pressed, 5, VirtualTool::Guard::until_contact);
    tool.finish();
    ASSERT_FALSE(tool.trigger());
    ASSERT_FALSE(tool.is_probe_closed());
    tool.start_move({0, 0, 0}, 5, VirtualTool::Guard::until_contact);
    tool.finish();
    ASSERT_TRUE(tool.trigger());
    ASSERT_TRUE(tool.is_probe_closed());
    ASSERT_LT(tool.position().z(), 5 - 2 * pretravel) << "it ran on";
    tool.start_move(pressed, 5, VirtualTool::Guard::until_release);
    tool.finish();
    EXPECT_FALSE(tool.is_probe_closed());
    ASSERT_TRUE(tool.trigger());
    EXPECT_NEAR(tool.trigger()->z(), 5 - pretravel, 1e-6);
    // One that is still pressed farther stays closed.
    tool.start_move({0, 0, 0}, 5, VirtualTool::Guard::until_contact);
    tool.finish();
    tool.start_move({0, 0, 5 - 1.5 * pretravel}, 5, VirtualTool::Guard::until_release);
    tool.finish();
    EXPECT_TRUE(tool.is_probe_closed());
    EXPECT_FALSE(tool.trigger());
}

}  // namespace
}  // namespace palpate::probe_errors_test
