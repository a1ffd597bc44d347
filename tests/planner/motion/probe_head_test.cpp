#include "planner/motion/probe_head.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "planner/errors.h"
#include "tests/planner/support.h"

namespace palpate::probe_head_test {
namespace {

constexpr std::uint64_t kSeed = 20240617;
constexpr double kTolerance = 1e-9;

// Everything the tool may travel on is outside ω or was probed before.
void expect_known(const Segment& travel, const Region& workspace, const std::vector<Segment>& probed) {
    for (const Segment& s : probed) {
        if (distance_to(s, travel.source) <= kTolerance && distance_to(s, travel.target) <= kTolerance) return;
    }
    for (int k = 0; k <= 32; ++k) {
        const Point p = travel.source + k / 32.0 * (travel.target - travel.source);
        ASSERT_LE(depth(workspace, p), kTolerance) << "neither outside nor probed";
    }
}

TEST(ProbeHead, CostEqualsWhatTheOracleSawAndEveryTravelIsOnKnownGround) {
    const std::vector<Region> workspaces = {Region(Ball{{1, 0, 0}, 4}), Region(Box{{-3, -2, -4}, {3, 2, 4}})};
    for (const Region& workspace : workspaces) {
        for (std::uint64_t seed = kSeed; seed < kSeed + 3; ++seed) {
            SCOPED_TRACE(seed_text(seed));
            Random random(seed);
            const Point start = workspace.center() + 2 * workspace.radius() * random.direction();
            SolidOracle oracle(Solid().add(Ball{{0, 0, 0}, 1}).add(Ball{{0.8, 0.5, 0.5}, 0.7}), start);
            Roadmap roadmap(workspace);
            ProbeHead head(oracle, workspace, roadmap);
            std::size_t checked = 0;
            std::size_t contacts = 0;
            for (int k = 0; k < 250; ++k) {
                NodeId from = static_cast<NodeId>(random.below(roadmap.size()));
                if (k % 4 == 0) from = roadmap.add_on_boundary(random.on_boundary(workspace));
                head.go_to(from);
                ASSERT_EQ(head.at(), from);
                ASSERT_LE((oracle.position() - roadmap.at(from)).norm(), 1e-12);
                const bool leave = k % 5 == 0;
                const Point target = leave ? random.on_boundary(workspace)
                                           : workspace.center() + random.uniform(0, 0.5) * workspace.radius() * random.direction();
                const Touch::Role role = k % 2 == 0 ? Touch::Role::seed : Touch::Role::crossing;
                const ProbeHead::Answer answer = head.probe({target, kNoNode, leave}, role);
                ASSERT_EQ(answer.position, oracle.position());
                ASSERT_EQ(answer.is_contact(), oracle.contacts > contacts);
                if (answer.is_contact()) {
                    ++contacts;
                    ASSERT_EQ(answer.touch + 1, head.touches().size());
                    ASSERT_EQ(head.touches().back().position, answer.position);
                    ASSERT_EQ(head.touches().back().from, roadmap.at(from));
                    ASSERT_EQ(head.touches().back().role, role);
                    ASSERT_FALSE(head.touches().back().sample);
                }
                ASSERT_NE(head.at(), from);
                ASSERT_EQ(roadmap.at(head.at()), answer.position);
                ASSERT_EQ(roadmap.on_boundary(head.at()), leave && !answer.is_contact());
                ASSERT_EQ(roadmap.neighbors(head.at()), std::vector<NodeId>{from});
                for (; checked < oracle.travels.size(); ++checked) {
                    expect_known(oracle.travels[checked], workspace, oracle.probes);
                    if (HasFatalFailure()) return;
                }
                const Cost& cost = head.cost();
                ASSERT_NEAR(cost.travel, oracle.travel_length, 1e-9 * oracle.travel_length);
                ASSERT_NEAR(cost.probing, oracle.probing_length, 1e-9 * oracle.probing_length);
                ASSERT_EQ(cost.contact, oracle.contacts);
                ASSERT_EQ(cost.probes(), oracle.probes.size());
                ASSERT_EQ(cost.probes(), cost.contact + cost.clear);
                ASSERT_DOUBLE_EQ(cost.displacement(), cost.travel + cost.probing);
                ASSERT_EQ(head.touches().size(), contacts);
                ASSERT_EQ(cost.seed, 0U);
            }
            EXPECT_GT(contacts, 50U);
            EXPECT_GT(head.cost().clear, 50U);
            head.end_of_seeding();
            EXPECT_EQ(head.cost().seed, head.cost().probes());
        }
    }
}

TEST(ProbeHead, StartInsideTheWorkspaceIsRefused) {
    const Region ball(Ball{{1, 0, 0}, 2});
    const Region box(Box{{0, 0, 0}, {4, 4, 4}});
    for (const Region& workspace : {ball, box}) {
        SolidOracle oracle(Solid(), workspace.center() + Vector(0.5, 0.4, 0.3));
        Roadmap roadmap(workspace);
        EXPECT_THROW(ProbeHead(oracle, workspace, roadmap), std::invalid_argument);
        EXPECT_TRUE(oracle.travels.empty()) << "moved all the same";
    }
    SolidOracle just_inside(Solid(), {2.999, 0, 0});
    Roadmap roadmap(ball);
    EXPECT_THROW(ProbeHead(just_inside, ball, roadmap), std::invalid_argument);
}

TEST(ProbeHead, StartOutsideGoesStraightToTheBoundary) {
    const Region workspace(Ball{{0, 0, 0}, 2});
    SolidOracle oracle(Solid(), {0, 0, 7});
    Roadmap roadmap(workspace);
    const ProbeHead head(oracle, workspace, roadmap);
    EXPECT_EQ(oracle.position(), Point(0, 0, 2));
    EXPECT_EQ(roadmap.at(head.at()), Point(0, 0, 2));
    EXPECT_TRUE(roadmap.on_boundary(head.at()));
    EXPECT_DOUBLE_EQ(head.cost().travel, 5);
    EXPECT_EQ(oracle.travels.size(), 1U);
}

TEST(ProbeHead, StartOnTheBoundaryStays) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Region workspace(Ball{{3, 4, 5}, 2});
    for (int k = 0; k < 100; ++k) {
        SolidOracle oracle(Solid(), random.on_boundary(workspace));  // off by rounding, to either side
        Roadmap roadmap(workspace);
        const ProbeHead head(oracle, workspace, roadmap);
        ASSERT_LE(head.cost().travel, 1e-14);
        ASSERT_DOUBLE_EQ(head.cost().travel, oracle.travel_length);
    }
}

TEST(ProbeHead, AssignSaysWhatATouchBecame) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    SolidOracle oracle(Solid().add(Ball{{0, 0, 0}, 1}), {0, 0, 3});
    Roadmap roadmap(workspace);
    ProbeHead head(oracle, workspace, roadmap);
    const NodeId start = head.at();
    const ProbeHead::Answer first = head.probe({{0, 0, 0}});
    head.go_to(start);
    (void)head.probe({{0.1, 0, 0}});
    head.assign(first.touch, Touch::Role::refinement, 17);
    EXPECT_EQ(head.touches()[0].role, Touch::Role::refinement);
    EXPECT_EQ(head.touches()[0].sample, 17U);
    EXPECT_EQ(head.touches()[1].role, Touch::Role::crossing);
    EXPECT_FALSE(head.touches()[1].sample);
    EXPECT_EQ(head.touches()[0].position, Point(0, 0, 1));
    EXPECT_DOUBLE_EQ(head.cost().travel, 2);
}

TEST(ProbeHead, NoWayLeadsThroughAContactThatWasLiftedFrom) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    SolidOracle oracle(Solid().add(Ball{{0, 0, 0}, 1}), {0, 0, 3});
    Roadmap roadmap(workspace);
    ProbeHead head(oracle, workspace, roadmap);
    const NodeId start = head.at();
    const ProbeHead::Answer touch = head.probe({{0, 0, 0}});
    ASSERT_TRUE(touch.is_contact());
    const NodeId contact = head.at();
    EXPECT_EQ(head.contact().at, contact);
    EXPECT_EQ(head.contact().from, start);
    // The way to the contact is split, as a crossing that is learned splits it.
    const NodeId middle = roadmap.split(start, contact, {0, 0, 2});
    head.lift({0, 0, 1.25});
    EXPECT_EQ(roadmap.at(head.at()), Point(0, 0, 1.25));
    EXPECT_DOUBLE_EQ(head.cost().travel, 0.25);
    EXPECT_DOUBLE_EQ(oracle.travel_length, 0.25);
    for (const Point& p : roadmap.short_path(head.at(), middle).points) EXPECT_NE(p, roadmap.at(contact));
    // A guarded move that meets S ends there, and says so; one that does not leaves the last contact as it was.
    EXPECT_FALSE(head.move_to({0.5, 0, 1.5}));
    EXPECT_EQ(head.contact().at, contact);
    const NodeId from = head.at();
    const auto met = head.move_to({0, 0, 0});
    ASSERT_TRUE(met);
    EXPECT_NEAR(met->position.norm(), 1, 1e-12);
    EXPECT_EQ(head.contact().at, head.at());
    EXPECT_EQ(head.contact().from, from);
    EXPECT_EQ(head.cost().contact, 2U);
    EXPECT_EQ(head.cost().clear, 0U) << "a move asks for no answer";
}

// A probe that triggers where nothing is, or does not trigger any more, at probes that are counted from 0.
class SparkingOracle final : public SurfaceOracle {
public:
    SparkingOracle(const Solid& solid, const Point& start) : solid_(solid, start) {}
    [[nodiscard]] OracleTraits traits() const override { return solid_.traits(); }
    [[nodiscard]] Point position() const override { return solid_.position(); }
    void travel(std::span<const Point> path, Ground ground) override { solid_.travel(path, ground); }
    [[nodiscard]] ProbeAnswer probe(const Point& target) override {
        const int number = count++;
        if (number >= first_spark && number < first_spark + sparks) return {ProbeAnswer::Outcome::vanished, solid_.position()};
        if (number < dies_at) return solid_.probe(target);
        solid_.travel({&target, 1}, Ground::unconfirmed);
        return {ProbeAnswer::Outcome::clear, target};
    }

    int count = 0;
    int first_spark = 0;
    int sparks = 0;
    int dies_at = std::numeric_limits<int>::max();

private:
    SolidOracle solid_;
};

TEST(ProbeHead, AFalseTriggerWhileAKnownPlaceIsTouchedIsNoSignOfADeadProbe) {
    const Region workspace(Ball{{0, 0, 0}, 3});
    const auto run = [&](SparkingOracle& oracle) {
        Roadmap roadmap(workspace);
        ProbeHead head(oracle, workspace, roadmap, ProbeWatch(0.5, 0.2, 1.0));
        const NodeId start = head.at();
        EXPECT_TRUE(head.probe({{0, 0, 0}}).is_contact());
        // Past the ball, until a known place is due.
        for (int k = 0; k < ProbeWatch::kMaxClears + 1; ++k) {
            head.go_to(start);
            EXPECT_FALSE(head.probe({{1.2 + 0.01 * k, 0, 0.5}}).is_contact());
        }
        EXPECT_EQ(oracle.position(), roadmap.at(head.at()));
        return head.cost().checks;
    };
    const Solid solid = Solid().add(Ball{{0, 0, 0}, 1});
    SparkingOracle good(solid, {0, 0, 3});
    EXPECT_GE(run(good), 1U);
    for (int number = 1; number < good.count; ++number) {
        SparkingOracle sparking(solid, {0, 0, 3});
        sparking.first_spark = number;
        sparking.sparks = 3;
        EXPECT_GE(run(sparking), 1U) << number;
        EXPECT_GE(sparking.count, good.count + 3);
        // One that dies while it sparks is noticed all the same.
        SparkingOracle dying(solid, {0, 0, 3});
        dying.first_spark = number;
        dying.sparks = 2;
        dying.dies_at = number;
        EXPECT_THROW((void)run(dying), SilenceError) << number;
    }
}

}  // namespace
}  // namespace palpate::probe_head_test
