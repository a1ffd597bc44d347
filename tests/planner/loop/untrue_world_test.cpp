// Worlds that no solid explains: a run ends all the same, and says that it cannot be right.
#include <gtest/gtest.h>

#include "planner/errors.h"
#include "planner/loop/effort.h"
#include "planner/probe_surface.h"
#include "tests/planner/support.h"

namespace palpate::untrue_world_test {
namespace {

// A solid that is gone after so many probes.
class VanishingOracle final : public SurfaceOracle {
public:
    VanishingOracle(Solid solid, const Point& start, std::size_t stays) : there_(std::move(solid), start), stays_(stays) {}

    [[nodiscard]] OracleTraits traits() const override { return {}; }
    [[nodiscard]] Point position() const override { return gone() ? position_ : there_.position(); }
    void travel(std::span<const Point> path, Ground ground) override {
        there_.travel(path, ground);
        position_ = path.back();
    }
    [[nodiscard]] ProbeAnswer probe(const Point& target) override {
        ++probes_;
        if (!gone()) return there_.probe(target);
        position_ = target;
        there_.travel({&target, 1}, Ground::proven);
        return {ProbeAnswer::Outcome::clear, target};
    }

private:
    [[nodiscard]] bool gone() const { return probes_ > stays_; }
    SolidOracle there_;
    std::size_t stays_;
    std::size_t probes_ = 0;
    Point position_ = Point::Zero();
};

TEST(UntrueWorld, AnObjectThatIsGoneIsNoticed) {
    const Region workspace(Ball{Point::Zero(), 1.5});
    Options options;
    options.epsilon = 0.2;
    options.strategy = Strategy::thesis();
    for (const std::size_t stays : {60U, 200U, 500U}) {
        SCOPED_TRACE(stays);
        VanishingOracle oracle(Solid().add(Ball{Point::Zero(), 1}), {0, 0, 3}, stays);
        EXPECT_THROW((void)probe_surface(oracle, workspace, options), ContradictionError);
    }
}

// Touches somewhere, or nowhere, as it likes.
class RandomOracle final : public SurfaceOracle {
public:
    explicit RandomOracle(std::uint64_t seed) : random_(seed) {}
    [[nodiscard]] Point position() const override { return position_; }
    void travel(std::span<const Point> path, Ground /*ground*/) override { position_ = path.back(); }
    [[nodiscard]] ProbeAnswer probe(const Point& target) override {
        ++probes;
        const bool touches = random_.chance(0.5);
        position_ = touches ? Point(position_ + random_.uniform(0.05, 0.95) * (target - position_)) : target;
        return {touches ? ProbeAnswer::Outcome::contact : ProbeAnswer::Outcome::clear, position_};
    }
    [[nodiscard]] OracleTraits traits() const override { return {.touch_error = 1e-6, .retract = 0, .overtravel = {}, .rates = {}}; }
    std::uint64_t probes = 0;

private:
    Random random_;
    Point position_{0, 0, 3};
};

TEST(UntrueWorld, RandomAnswersEndWithinTheBoundThatIsStated) {
    const Region workspace(Ball{Point::Zero(), 1});
    for (const Strategy& strategy : {Strategy::thesis(), Strategy{}, Strategy::adaptive()}) {
        for (std::uint64_t seed = 1; seed <= 5; ++seed) {
            SCOPED_TRACE(seed_text(seed));
            RandomOracle oracle(seed);
            Options options;
            options.epsilon = 0.4;
            options.refinement_floor = 1.0;
            options.strategy = strategy;
            Result result;
            ASSERT_NO_THROW(result = probe_surface(oracle, workspace, options));
            EXPECT_EQ(result.certificate.status, Certificate::Status::incomplete);
            EXPECT_FALSE(result.bad_places.empty());
            EXPECT_LE(oracle.probes, (Effort::kTries + Effort::kPerSample) * result.samples);
        }
    }
}

}  // namespace
}  // namespace palpate::untrue_world_test
