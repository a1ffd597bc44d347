#include "planner/internal/tool.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/planner/support.h"

namespace palpate {
namespace {

constexpr std::uint64_t kSeed = 20240617;
constexpr double kTolerance = 1e-9;

double distance_to_segment(const Point& p, const Segment& s) {
    const Vector along = s.target - s.source;
    const double squared = along.squaredNorm();
    const double share = squared > 0 ? std::clamp((p - s.source).dot(along) / squared, 0.0, 1.0) : 0;
    return (s.source + share * along - p).norm();
}

// Everything the tool may travel on is outside ω or was probed before.
void expect_known(const Segment& travel, const Workspace& workspace, const std::vector<Segment>& probed) {
    for (const Segment& s : probed) {
        if (distance_to_segment(travel.source, s) <= kTolerance && distance_to_segment(travel.target, s) <= kTolerance) return;
    }
    for (int k = 0; k <= 32; ++k) {
        const Point p = travel.source + k / 32.0 * (travel.target - travel.source);
        ASSERT_LE(depth(workspace, p), kTolerance) << "neither outside nor probed";
    }
}

TEST(Tool, AccountEqualsWhatTheOracleSawAndEveryTravelIsOnKnownGround) {
    const std::vector<Workspace> workspaces = {Workspace(Ball{{1, 0, 0}, 4}), Workspace(Box{{-3, -2, -4}, {3, 2, 4}})};
    for (const Workspace& workspace : workspaces) {
        for (std::uint64_t seed = kSeed; seed < kSeed + 3; ++seed) {
            SCOPED_TRACE(seed_text(seed));
            Random random(seed);
            const Point start = workspace.center() + 2 * workspace.radius() * random.direction();
            SolidOracle oracle(Solid().add(Ball{{0, 0, 0}, 1}).add(Ball{{0.8, 0.5, 0.5}, 0.7}), start);
            Roadmap roadmap(workspace);
            Tool tool(oracle, workspace, roadmap);
            std::size_t checked = 0;
            std::size_t contacts = 0;
            for (int k = 0; k < 250; ++k) {
                NodeId from = static_cast<NodeId>(random.below(roadmap.size()));
                if (k % 4 == 0) from = roadmap.add_on_boundary(random.on_boundary(workspace));
                tool.go_to(from);
                ASSERT_EQ(tool.at(), from);
                ASSERT_LE((oracle.position() - roadmap.at(from)).norm(), 1e-12);
                const bool leave = k % 5 == 0;
                const Point target = leave ? random.on_boundary(workspace)
                                           : workspace.center() + random.uniform(0, 0.5) * workspace.radius() * random.direction();
                const Touch::Role role = k % 2 == 0 ? Touch::Role::seed : Touch::Role::crossing;
                const Tool::Answer answer = tool.probe(target, role);
                ASSERT_EQ(answer.position, oracle.position());
                ASSERT_EQ(answer.contact, oracle.contacts > contacts);
                if (answer.contact) {
                    ++contacts;
                    ASSERT_EQ(answer.touch + 1, tool.touches().size());
                    ASSERT_EQ(tool.touches().back().position, answer.position);
                    ASSERT_EQ(tool.touches().back().from, roadmap.at(from));
                    ASSERT_EQ(tool.touches().back().role, role);
                    ASSERT_FALSE(tool.touches().back().sample);
                }
                if (leave && !answer.contact) {
                    const NodeId out = roadmap.add_on_boundary(answer.position);
                    roadmap.connect(from, out);
                    tool.arrive(out);
                } else {
                    tool.arrive(roadmap.add(from, answer.position));
                }
                for (; checked < oracle.travels.size(); ++checked) {
                    expect_known(oracle.travels[checked], workspace, oracle.probes);
                    if (HasFatalFailure()) return;
                }
                const Account& account = tool.account();
                ASSERT_NEAR(account.travel, oracle.travel_length, 1e-9 * oracle.travel_length);
                ASSERT_NEAR(account.probing, oracle.probing_length, 1e-9 * oracle.probing_length);
                ASSERT_EQ(account.contact, oracle.contacts);
                ASSERT_EQ(account.probes(), oracle.probes.size());
                ASSERT_EQ(account.probes(), account.contact + account.clear);
                ASSERT_DOUBLE_EQ(account.displacement(), account.travel + account.probing);
                ASSERT_EQ(tool.touches().size(), contacts);
                ASSERT_EQ(account.seed, 0U);
            }
            EXPECT_GT(contacts, 50U);
            EXPECT_GT(tool.account().clear, 50U);
            tool.end_of_seeding();
            EXPECT_EQ(tool.account().seed, tool.account().probes());
        }
    }
}

TEST(Tool, StartInsideTheWorkspaceIsRefused) {
    const Workspace ball(Ball{{1, 0, 0}, 2});
    const Workspace box(Box{{0, 0, 0}, {4, 4, 4}});
    for (const Workspace& workspace : {ball, box}) {
        SolidOracle oracle(Solid(), workspace.center() + Vector(0.5, 0.4, 0.3));
        Roadmap roadmap(workspace);
        EXPECT_THROW(Tool(oracle, workspace, roadmap), std::invalid_argument);
        EXPECT_TRUE(oracle.travels.empty()) << "moved all the same";
    }
    SolidOracle just_inside(Solid(), {2.999, 0, 0});
    Roadmap roadmap(ball);
    EXPECT_THROW(Tool(just_inside, ball, roadmap), std::invalid_argument);
}

TEST(Tool, StartOutsideGoesStraightToTheBoundary) {
    const Workspace workspace(Ball{{0, 0, 0}, 2});
    SolidOracle oracle(Solid(), {0, 0, 7});
    Roadmap roadmap(workspace);
    const Tool tool(oracle, workspace, roadmap);
    EXPECT_EQ(oracle.position(), Point(0, 0, 2));
    EXPECT_EQ(roadmap.at(tool.at()), Point(0, 0, 2));
    EXPECT_TRUE(roadmap.on_boundary(tool.at()));
    EXPECT_DOUBLE_EQ(tool.account().travel, 5);
    EXPECT_EQ(oracle.travels.size(), 1U);
}

TEST(Tool, StartOnTheBoundaryStays) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Workspace workspace(Ball{{3, 4, 5}, 2});
    for (int k = 0; k < 100; ++k) {
        SolidOracle oracle(Solid(), random.on_boundary(workspace));  // off by rounding, to either side
        Roadmap roadmap(workspace);
        const Tool tool(oracle, workspace, roadmap);
        ASSERT_LE(tool.account().travel, 1e-14);
        ASSERT_DOUBLE_EQ(tool.account().travel, oracle.travel_length);
    }
}

TEST(Tool, AssignSaysWhatATouchBecame) {
    const Workspace workspace(Ball{{0, 0, 0}, 3});
    SolidOracle oracle(Solid().add(Ball{{0, 0, 0}, 1}), {0, 0, 3});
    Roadmap roadmap(workspace);
    Tool tool(oracle, workspace, roadmap);
    const NodeId start = tool.at();
    const Tool::Answer first = tool.probe({0, 0, 0});
    tool.arrive(roadmap.add(start, first.position));
    tool.go_to(start);
    const Tool::Answer second = tool.probe({0.1, 0, 0});
    tool.arrive(roadmap.add(start, second.position));
    tool.assign(first.touch, Touch::Role::refinement, 17);
    EXPECT_EQ(tool.touches()[0].role, Touch::Role::refinement);
    EXPECT_EQ(tool.touches()[0].sample, 17U);
    EXPECT_EQ(tool.touches()[1].role, Touch::Role::crossing);
    EXPECT_FALSE(tool.touches()[1].sample);
    EXPECT_EQ(tool.touches()[0].position, Point(0, 0, 1));
    EXPECT_DOUBLE_EQ(tool.account().travel, 2);
}

TEST(Tool, NoWayLeadsThroughAContactThatWasLiftedFrom) {
    const Workspace workspace(Ball{{0, 0, 0}, 3});
    SolidOracle oracle(Solid().add(Ball{{0, 0, 0}, 1}), {0, 0, 3});
    Roadmap roadmap(workspace);
    Tool tool(oracle, workspace, roadmap);
    const NodeId start = tool.at();
    const Tool::Answer touch = tool.probe({0, 0, 0});
    const NodeId contact = roadmap.add(start, touch.position);
    tool.arrive(contact);
    EXPECT_EQ(tool.contact().at, contact);
    EXPECT_EQ(tool.contact().from, start);
    // The way to the contact is split, as a crossing that is learned splits it.
    const NodeId middle = roadmap.split(start, contact, {0, 0, 2});
    tool.lift({0, 0, 1.25});
    EXPECT_EQ(roadmap.at(tool.at()), Point(0, 0, 1.25));
    EXPECT_DOUBLE_EQ(tool.account().travel, 0.25);
    EXPECT_DOUBLE_EQ(oracle.travel_length, 0.25);
    for (const Point& p : roadmap.short_path(tool.at(), middle).points) EXPECT_NE(p, roadmap.at(contact));
    // A guarded move that meets S ends there, and says so; one that does not leaves the last contact as it was.
    EXPECT_FALSE(tool.move_to({0.5, 0, 1.5}));
    EXPECT_EQ(tool.contact().at, contact);
    const NodeId from = tool.at();
    const auto met = tool.move_to({0, 0, 0});
    ASSERT_TRUE(met);
    EXPECT_NEAR(met->position.norm(), 1, 1e-12);
    EXPECT_EQ(tool.contact().at, tool.at());
    EXPECT_EQ(tool.contact().from, from);
    EXPECT_EQ(tool.account().contact, 2U);
    EXPECT_EQ(tool.account().clear, 0U) << "a move asks for no answer";
}

}  // namespace
}  // namespace palpate
