#include "devices/device_oracle.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include "devices/errors.h"

namespace palpate::device_oracle_test {
namespace {

// A half-space x >= wall that the probe cannot enter, and a log of what was asked.
class FakeDevice final : public ProbeDevice {
public:
    explicit FakeDevice(double wall) : wall_(wall) {}

    [[nodiscard]] Point position() const override { return position_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        paces.push_back(pace);
        if (moves.size() == fault_at) throw DeviceError("cable pulled");
        moves.push_back(target);
        if (target.x() < wall_) {
            position_ = target;
            return {MoveResult::Outcome::reached, position_};
        }
        position_ += (wall_ - position_.x()) / (target.x() - position_.x()) * (target - position_);
        return {MoveResult::Outcome::contact, position_};
    }
    void stop() override { ++stops; }

    std::vector<Point> moves;
    std::vector<Pace> paces;
    int stops = 0;
    std::size_t fault_at = ~std::size_t{0};

private:
    double wall_;
    Point position_ = Point::Zero();
};

TEST(DeviceOracle, TravelMovesThroughEveryPointInTurn) {
    FakeDevice device(10);
    DeviceOracle oracle(device);
    const std::vector<Point> path = {{1, 0, 0}, {1, 2, 0}, {1, 2, 3}};
    oracle.travel(path, Ground::proven);
    EXPECT_EQ(device.moves, path);
    EXPECT_EQ(device.paces, std::vector<Pace>(3, Pace::travel));
    EXPECT_EQ(oracle.position(), Point(1, 2, 3));
    oracle.travel({}, Ground::proven);
    EXPECT_EQ(device.moves.size(), 3U);
}

TEST(DeviceOracle, ContactDuringTravelThrowsWithThePlaceAndGoesNoFarther) {
    FakeDevice device(2);
    DeviceOracle oracle(device);
    const std::vector<Point> path = {{1, 0, 0}, {3, 4, 0}, {0, 0, 0}};
    try {
        oracle.travel(path, Ground::proven);
        FAIL() << "nothing was thrown";
    } catch (const UnexpectedContact& contact) {
        EXPECT_EQ(contact.where(), Point(2, 2, 0));
        const std::string message = contact.what();
        EXPECT_NE(message.find("(2, 2, 0) mm"), std::string::npos) << message;
        EXPECT_NE(message.find("travel"), std::string::npos) << message;
    }
    // What it tries besides, in case S only grazes the way, is within rounding of it.
    ASSERT_GE(device.moves.size(), 2U);
    for (const Point& move : device.moves | std::views::drop(2)) {
        EXPECT_TRUE((move - Point(2, 2, 0)).norm() < 1e-5 || (move - path[1]).norm() < 1e-5) << move.transpose();
    }
    EXPECT_LT((oracle.position() - Point(2, 2, 0)).norm(), 1e-5);
}

TEST(DeviceOracle, AnUnexpectedContactIsADeviceError) {
    FakeDevice device(2);
    DeviceOracle oracle(device);
    const std::vector<Point> path = {{3, 0, 0}};
    EXPECT_THROW(oracle.travel(path, Ground::proven), DeviceError);
}

TEST(DeviceOracle, ProbeThatReachesItsTargetIsClear) {
    FakeDevice device(2);
    DeviceOracle oracle(device);
    const ProbeAnswer answer = oracle.probe({1, 7, 0});
    EXPECT_EQ(answer.outcome, ProbeAnswer::Outcome::clear);
    EXPECT_EQ(answer.position, Point(1, 7, 0));
    EXPECT_EQ(device.moves, std::vector<Point>({{1, 7, 0}}));
    EXPECT_EQ(device.paces, std::vector<Pace>({Pace::probe}));
}

TEST(DeviceOracle, ProbeThatIsStoppedIsAContactWhereItStopped) {
    FakeDevice device(2);
    DeviceOracle oracle(device);
    const ProbeAnswer answer = oracle.probe({4, 8, 0});
    EXPECT_EQ(answer.outcome, ProbeAnswer::Outcome::contact);
    EXPECT_EQ(answer.position, Point(2, 4, 0));
    EXPECT_EQ(oracle.position(), Point(2, 4, 0));
}

TEST(DeviceOracle, FaultsPassThrough) {
    FakeDevice device(2);
    device.fault_at = 1;
    DeviceOracle oracle(device);
    const std::vector<Point> path = {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}};
    EXPECT_THROW(oracle.travel(path, Ground::proven), DeviceError);
    EXPECT_EQ(device.moves.size(), 1U);
    EXPECT_THROW((void)oracle.probe({0, 0, 0}), DeviceError);
}

// A ball of radius 1 at the origin; stops `retract` before what it touches, and rounds to `resolution`.
class BallDevice final : public ProbeDevice {
public:
    explicit BallDevice(const Point& start) : position_(start) {}

    [[nodiscard]] Point position() const override { return position_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace /*pace*/) override {
        ++moves;
        const Vector way = target - position_;
        const double length = way.norm();
        if (length == 0) return {MoveResult::Outcome::reached, target};
        const Vector u = way / length;
        const double b = position_.dot(u);
        const double root = b * b - position_.squaredNorm() + 1;
        const double at = root < 0 ? length + 1 : -b - std::sqrt(root);
        if (at < 0 || at > length) {
            position_ = target;
            return {MoveResult::Outcome::reached, target};
        }
        const Point touched = position_ + at * u;
        position_ = touched - std::min(at, retract) * u;
        return {MoveResult::Outcome::contact, touched};
    }
    void stop() override {}

    double retract = 0.1;
    int moves = 0;

private:
    Point position_;
};

constexpr double kTouchError = 1e-3;
const OracleTraits kTraits{.touch_error = kTouchError, .retract = 0, .overtravel = {}, .rates = {}};

TEST(DeviceOracle, AWayThatSGrazesWithinTheTouchErrorIsPassedBesideIt) {
    for (const double depth : {1e-6, 0.5e-3, 3e-3, 8e-3}) {
        BallDevice device({-2, 0, 1 - depth});
        DeviceOracle oracle(device, kTraits);
        const std::vector<Point> path = {{2, 0, 1 - depth}, {2, 2, 1}};
        oracle.travel(path, Ground::proven);
        EXPECT_EQ(oracle.position(), path.back()) << depth;
        EXPECT_EQ(device.position(), path.back()) << depth;
        EXPECT_EQ(oracle.grazes(), 1U) << depth;
    }
}

TEST(DeviceOracle, AWayThatLeadsDeeperIntoSIsAContradiction) {
    BallDevice device({-2, 0, 0.95});
    DeviceOracle oracle(device, kTraits);
    const std::vector<Point> path = {{2, 0, 0.95}};
    EXPECT_THROW(oracle.travel(path, Ground::proven), UnexpectedContact);
    EXPECT_LT(device.position().x(), 0) << "it never got to the other side";
}

TEST(DeviceOracle, APlaceThatLiesOnSWithinTheTouchErrorIsReachedAsNearAsItCanBe) {
    BallDevice device({-2, 0, 0});
    DeviceOracle oracle(device, kTraits);
    const std::vector<Point> path = {{-1 + 1e-4, 0, 0}};
    oracle.travel(path, Ground::proven);
    EXPECT_LE((device.position() - path[0]).norm(), 2 * DeviceOracle::kGraze * kTouchError);
    EXPECT_EQ(oracle.position(), path[0]);
    // An exact device has no such excuse.
    BallDevice exact({-2, 0, 0});
    DeviceOracle strict(exact);
    EXPECT_THROW(strict.travel(path, Ground::proven), UnexpectedContact);
}

TEST(DeviceOracle, ATouchIsPutOnTheLineThatWasAskedFor) {
    BallDevice device({-2, 1e-4, 0});  // beside where the planner has it
    DeviceOracle oracle(device, kTraits);
    const std::vector<Point> path = {{-2, 0, 0}};
    oracle.travel(path, Ground::proven);
    const ProbeAnswer answer = oracle.probe({0, 1e-3, 0});
    ASSERT_EQ(answer.outcome, ProbeAnswer::Outcome::contact);
    const Vector line = Point(0, 1e-3, 0) - path[0];
    EXPECT_NEAR((answer.position - path[0]).cross(line).norm(), 0, 1e-15);
    EXPECT_NEAR(answer.position.x(), -1, 1e-6);
}

}  // namespace
}  // namespace palpate::device_oracle_test
