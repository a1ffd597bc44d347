// Sessions on a machine that drifts: what the datum shows is taken out, what moved is noticed, and the planner notices nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

#include "devices/errors.h"
#include "devices/session/drift_log.h"
#include "devices/session/machine_session.h"
#include "tests/devices/fake_probe.h"
#include "tests/devices/message_of.h"
#include "tests/random.h"

namespace palpate::drift_session_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr double kRadius = 5.0;
constexpr double kRetract = 0.2;
const Box kDatumBox{{10.5, -1, -1}, {12.5, 1, 1}};

FirstHit box(const Box& solid) {
    return [=](const Point& from, const Point& to) -> std::optional<double> {
        const Vector way = to - from;
        Interval in{0.0, 1.0};
        for (int axis = 0; axis < 3; ++axis) {
            if (way[axis] == 0) {
                if (from[axis] < solid.min[axis] || from[axis] > solid.max[axis]) return std::nullopt;
                continue;
            }
            const double a = (solid.min[axis] - from[axis]) / way[axis];
            const double b = (solid.max[axis] - from[axis]) / way[axis];
            in.low = std::max(in.low, std::min(a, b));
            in.high = std::min(in.high, std::max(a, b));
        }
        return in.low < in.high ? std::optional(in.low * way.norm()) : std::nullopt;
    };
}

// A ball, with a block beside it as datum, both of which wander off as moves are made: for a touch that is what a machine that drifts looks
// like.
struct Bench {
    Vector per_second = Vector::Zero();  // mm, of motion
    Vector jump = Vector::Zero();        // mm, besides
    bool has_datum = true;
    std::optional<Box> obstacle{};
    FakeProbe probe{[this](const Point& from, const Point& to) { return hit(from, to); }, Point(0, 0, 14), kRetract};
    int connections = 0;

    // s: of motion, at the feeds of the settings.
    [[nodiscard]] double time() const {
        for (; seen_ < probe.log.size(); ++seen_) {
            const FakeProbe::Move& move = probe.log[seen_];
            time_ += 0.2 + (move.result.position - move.from).norm() / Feeds{}.of(move.pace);
        }
        return time_;
    }
    [[nodiscard]] Vector shift() const { return time() * per_second + jump; }
    [[nodiscard]] std::optional<double> hit(const Point& from, const Point& to) const {
        std::optional<double> nearest;
        const auto meet = [&](const FirstHit& solid) {
            const auto t = solid(from - shift(), to - shift());
            if (t && (!nearest || *t < *nearest)) nearest = t;
        };
        meet(ball(Point::Zero(), kRadius));
        if (has_datum) meet(box(kDatumBox));
        if (obstacle) meet(box(*obstacle));
        return nearest;
    }

private:
    mutable std::size_t seen_ = 0;
    mutable double time_ = 0.0;
};

class BenchMachine final : public Machine {
public:
    explicit BenchMachine(Bench& bench) : bench_(bench) { ++bench_.connections; }

    [[nodiscard]] ProbeDevice& device() override { return bench_.probe; }
    [[nodiscard]] MachineReport report() override {
        MachineReport report;
        report.identity = "a ball and a block on a bench";
        report.state = "ready";
        report.position = bench_.probe.position();
        return report;
    }
    void make_ready() override {}
    void retreat(const Point& target) override { (void)bench_.probe.guarded_move(target, Pace::probe); }
    [[nodiscard]] bool is_probe_closed() override { return false; }
    [[nodiscard]] bool is_position_trusted() override { return true; }

private:
    Bench& bench_;
};

DriftDatum three_faces() { return {10, {{{9, 0, 0}, {11, 0, 0}}, {{11.5, -3, 0}, {11.5, -0.5, 0}}, {{11.5, 0, 3}, {11.5, 0, 0.5}}}, 0.1}; }

class DriftSession : public ::testing::Test {
protected:
    DriftSession() {
        std::string name = (fs::temp_directory_path() / "palpate_drift_XXXXXX").string();
        folder_ = mkdtemp(name.data());
        settings_.limits = {Point::Constant(-15), Point::Constant(15)};
        settings_.motion.retract_mm = kRetract;
        settings_.noise_mm = 0.01;
        settings_.datum = three_faces();
    }
    ~DriftSession() override { fs::remove_all(folder_); }

    [[nodiscard]] SessionPlan plan(const std::string& session) const {
        Options probing;
        probing.epsilon = 1.5;
        probing.reach = 4.9;
        return {settings_, Region(Ball{Point::Zero(), 7.0}), probing, folder_ / session, "of this test", "this test"};
    }
    [[nodiscard]] SessionHost host(Bench& bench) {
        SessionHost host;
        host.connect = [&bench] { return std::make_unique<BenchMachine>(bench); };
        host.ask = [](const PlannedMotion&) {};
        host.say = [this](const std::string& sentence) { said_ += sentence + "\n"; };
        return host;
    }
    [[nodiscard]] SessionHost nobody() const {
        SessionHost host;
        host.connect = []() -> std::unique_ptr<Machine> { throw std::logic_error("a replay connects to nothing"); };
        return host;
    }
    [[nodiscard]] std::string text_of(const std::string& session) const {
        std::ifstream in(folder_ / session, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    // In a second, with which it drifts by 50 µm in a whole session with these settings.
    [[nodiscard]] Vector drift_of_fifty(const std::string& name) {
        Bench still;
        (void)start_session(plan(name), host(still));
        return 0.050 / still.time() * Vector(2, -1, 2).normalized();
    }

    fs::path folder_;
    MachineSettings settings_;
    std::string said_;
};

bool same_result(const MachineRun& a, const MachineRun& b) {
    return a.result.mesh.points == b.result.mesh.points && a.result.mesh.triangles == b.result.mesh.triangles &&
           std::ranges::equal(a.result.touches, b.result.touches,
                              [](const Touch& x, const Touch& y) { return x.position == y.position && x.from == y.from; });
}

// mm: how far a vertex is off the ball, where that was when the session began.
double worst_vertex(const Result& result) {
    double worst = 0;
    for (const Point& p : result.mesh.points) worst = std::max(worst, std::abs(p.norm() - kRadius));
    return worst;
}

TEST_F(DriftSession, OfFiftyMicrometresLeavesFiveOfThemWithADatum) {
    Bench with;
    with.per_second = drift_of_fifty("still");
    const MachineRun run = start_session(plan("with"), host(with));
    EXPECT_LE(worst_vertex(run.result), 0.005);
    for (const Touch& touch : run.result.touches) EXPECT_NEAR(touch.position.norm(), kRadius, 0.005);
    EXPECT_EQ(run.result.topology.euler_characteristic, 2);
    ASSERT_TRUE(run.drift);
    EXPECT_GE(run.drift->visits, 5U);
    EXPECT_EQ(run.drift->touches, 3 * run.drift->visits);
    EXPECT_EQ(run.drift->directions, 3);
    EXPECT_GE(run.drift->largest_shift_mm, 0.04);
    EXPECT_NEAR((run.drift->shift - with.shift()).norm(), 0, 0.005) << "in all of the time";
    EXPECT_GT(run.drift->way_mm, 100);
    EXPECT_TRUE(same_result(replay_session(plan("with"), nobody()), run));

    settings_.datum.reset();
    Bench without;
    without.per_second = drift_of_fifty("still without");
    const MachineRun drifted = start_session(plan("without"), host(without));
    EXPECT_GE(worst_vertex(drifted.result), 0.025);
    EXPECT_FALSE(drifted.drift);
    std::printf("worst vertex %.1f um with the datum, %.1f um without; %zu visits, %.0f mm, %.1f um at most from one to the next\n",
                1e3 * worst_vertex(run.result), 1e3 * worst_vertex(drifted.result), run.drift->visits, run.drift->way_mm,
                1e3 * run.drift->largest_change_mm);
}

// The tool is back where it was after each visit.
TEST_F(DriftSession, WithoutDriftThePlannerDoesNotNoticeVisits) {
    Bench visited;
    const MachineRun run = start_session(plan("visited"), host(visited));
    ASSERT_GE(run.drift->visits, 5U);
    EXPECT_EQ(run.drift->largest_shift_mm, 0);
    settings_.datum.reset();
    Bench alone;
    const MachineRun reference = start_session(plan("alone"), host(alone));
    EXPECT_TRUE(same_result(run, reference));
    EXPECT_EQ(run.meter.displacement_mm, reference.meter.displacement_mm);
    EXPECT_GT(run.meter.machine_time, reference.meter.machine_time);
    // Nor does the journal hide them.
    const Journal journal = read_journal(folder_ / "visited");
    const auto touches = std::ranges::count_if(journal.moves, [](const JournalMove& move) { return move.datum && move.datum->touch; });
    EXPECT_EQ(static_cast<std::uint64_t>(touches), run.drift->touches);
}

TEST_F(DriftSession, InterruptedAnywhereAndResumedEndsWithTheSameMesh) {
    constexpr std::uint64_t kSeed = 12;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    Bench undisturbed;
    const MachineRun reference = start_session(plan("reference"), host(undisturbed));
    const std::size_t moves = undisturbed.probe.log.size();
    std::size_t in_visits = 0;
    for (int trial = 0; trial < 12; ++trial) {
        const std::size_t last = 1 + random.below(moves - 2);
        const std::string name = "cut_" + std::to_string(trial);
        SCOPED_TRACE(name + " after " + std::to_string(last) + " moves of " + std::to_string(moves));
        Bench bench;
        bench.probe.fault = [&bench, last] { return bench.connections == 1 && bench.probe.log.size() == last; };
        EXPECT_THROW((void)start_session(plan(name), host(bench)), ConnectionLost);
        in_visits += read_journal(folder_ / name).moves.empty() || read_journal(folder_ / name).moves.back().datum ? 1 : 0;
        // And once more on its way back.
        const std::size_t again = bench.probe.log.size() + 1 + random.below(20);
        bench.probe.fault = [&bench, again] { return bench.connections == 2 && bench.probe.log.size() == again; };
        bool is_cut = false;
        std::optional<MachineRun> resumed;
        try {
            resumed = resume_session(plan(name), host(bench));
        } catch (const ConnectionLost&) {
            is_cut = true;
        }
        if (is_cut) resumed = resume_session(plan(name), host(bench));
        ASSERT_TRUE(same_result(*resumed, reference));
        ASSERT_TRUE(same_result(replay_session(plan(name), nobody()), reference));
    }
    EXPECT_GE(in_visits, 2U) << "the test cuts no visit";
}

TEST_F(DriftSession, ThatDriftsInterruptedAndResumedIsReplayedToTheSameBits) {
    const Vector drift = drift_of_fifty("still");
    for (const std::size_t last : {40U, 233U, 700U}) {
        const std::string name = "cut_" + std::to_string(last);
        SCOPED_TRACE(name);
        Bench bench;
        bench.per_second = drift;
        bench.probe.fault = [&bench, last] { return bench.connections == 1 && bench.probe.log.size() == last; };
        ASSERT_THROW((void)start_session(plan(name), host(bench)), ConnectionLost);
        const MachineRun run = resume_session(plan(name), host(bench));
        // It drifts while it comes back, too: what was touched since the last visit before that is off by some of it.
        const auto off = std::ranges::count_if(run.result.mesh.points, [](const Point& p) { return std::abs(p.norm() - kRadius) > 0.005; });
        EXPECT_LE(static_cast<std::uint64_t>(off), settings_.datum->every);
        EXPECT_LE(worst_vertex(run.result), 0.010);
        const MachineRun replayed = replay_session(plan(name), nobody());
        EXPECT_TRUE(same_result(replayed, run));
        EXPECT_EQ(replayed.resumptions, run.resumptions);
        EXPECT_EQ(replayed.drift->visits, run.drift->visits);
        EXPECT_EQ(replayed.drift->shift, run.drift->shift);
    }
}

// What drifted overnight is no reason not to go on: the datum tells it from a part that moved.
TEST_F(DriftSession, WhatDriftedBeforeItIsResumedIsSeenFirst) {
    Bench bench;
    bench.probe.fault = [&bench] { return bench.connections == 1 && bench.probe.log.size() == 700; };
    ASSERT_THROW((void)start_session(plan("overnight"), host(bench)), ConnectionLost);
    const std::size_t before = read_journal(folder_ / "overnight").moves.size();
    ASSERT_GT(before, 60U);
    bench.jump = Vector(0.05, -0.04, 0.06);
    const MachineRun run = resume_session(plan("overnight"), host(bench));
    ASSERT_EQ(run.resumptions.size(), 1U);
    EXPECT_EQ(run.resumptions[0].datum.size(), 3U);
    EXPECT_EQ(run.resumptions[0].directions, 3);
    EXPECT_NEAR((run.drift->shift - bench.jump).norm(), 0, 1e-6);
    // When between two visits it went is not known.
    std::uint64_t off = 0;
    for (const Touch& touch : run.result.touches) off += std::abs(touch.position.norm() - kRadius) > 0.002 ? 1 : 0;
    EXPECT_LE(off, settings_.datum->every);
    EXPECT_TRUE(same_result(replay_session(plan("overnight"), nobody()), run));
}

TEST_F(DriftSession, AJumpStopsItAndOnceThatIsMendedItGoesOnFromTheVisitBefore) {
    Bench bench;
    bench.probe.fault = [&bench] {
        if (bench.probe.log.size() == 150) bench.jump = Vector(0, 0.3, 0);
        return false;
    };
    std::string message = message_of<DriftJump>([&] { (void)start_session(plan("jumped"), host(bench)); });
    EXPECT_THAT(message, HasSubstr("the datum is 0.3000 mm from where the visit before found it, 10 touches ago, more than "
                                   "machine.datum.limit, 0.1 mm"));
    EXPECT_THAT(message, HasSubstr("then resume"));
    const std::string journal = text_of("jumped");
    const DriftRecord record = read_drift(read_journal(folder_ / "jumped"), *settings_.datum, settings_.motion);
    EXPECT_LT(record.moves, read_journal(folder_ / "jumped").moves.size());

    bench.probe.fault = {};
    message = message_of<DriftJump>([&] { (void)resume_session(plan("jumped"), host(bench)); });
    EXPECT_THAT(message, HasSubstr("the datum is 0.3000 mm from where"));
    EXPECT_EQ(text_of("jumped"), journal) << "nothing was recorded";

    bench.jump = Vector::Zero();
    const MachineRun run = resume_session(plan("jumped"), host(bench));
    EXPECT_THAT(said_, HasSubstr("the session had stopped: the datum is 0.3000 mm from where"));
    EXPECT_LE(worst_vertex(run.result), 1e-6) << "what was touched since the visit before was touched again";
    EXPECT_TRUE(same_result(replay_session(plan("jumped"), nobody()), run));
}

TEST_F(DriftSession, ADatumThatIsGoneStopsItAndOnceItIsBackItGoesOn) {
    Bench bench;
    bench.probe.fault = [&bench] {
        if (bench.probe.log.size() == 150) bench.has_datum = false;
        return false;
    };
    const auto start = [&] { (void)start_session(plan("gone"), host(bench)); };
    EXPECT_THAT(message_of<DatumFault>(start), HasSubstr("machine.datum.at[0]: nothing was touched from (9, 0, 0) mm to (11, 0, 0) mm"));
    bench.probe.fault = {};
    const auto resume = [&] { (void)resume_session(plan("gone"), host(bench)); };
    EXPECT_THAT(message_of<DatumFault>(resume), HasSubstr("machine.datum.at[0]: nothing was touched"));
    bench.has_datum = true;
    const MachineRun run = resume_session(plan("gone"), host(bench));
    EXPECT_LE(worst_vertex(run.result), 1e-6);
    EXPECT_TRUE(same_result(replay_session(plan("gone"), nobody()), run));
}

TEST_F(DriftSession, WhatStandsInTheWayToTheDatumStopsItAndOnceItIsGoneItGoesOn) {
    Bench bench;
    bench.probe.fault = [&bench] {
        if (bench.probe.log.size() == 150) bench.obstacle = Box{{8.2, -0.5, -0.5}, {8.6, 0.5, 0.5}};
        return false;
    };
    const auto start = [&] { (void)start_session(plan("blocked"), host(bench)); };
    EXPECT_THAT(message_of<DatumFault>(start), HasSubstr("something was touched at (8.2, 0, 0) mm on the way to the datum or back"));
    bench.probe.fault = {};
    bench.obstacle.reset();
    const MachineRun run = resume_session(plan("blocked"), host(bench));
    EXPECT_LE(worst_vertex(run.result), 1e-6);
    EXPECT_TRUE(same_result(replay_session(plan("blocked"), nobody()), run));
}

TEST_F(DriftSession, OneTouchShowsOneDirection) {
    settings_.datum->touches.resize(1);
    Bench bench;
    bench.per_second = Vector(1e-4, 0, 1e-4);
    const MachineRun run = start_session(plan("one"), host(bench));
    EXPECT_EQ(run.drift->directions, 1);
    EXPECT_EQ(run.drift->touches, run.drift->visits);
    EXPECT_NEAR((run.drift->shift - Vector(bench.shift().x(), 0, 0)).norm(), 0, 0.002);
}

TEST_F(DriftSession, ADatumThatCannotBeTouchedIsRefusedBeforeAnythingMoves) {
    Bench bench;
    const auto complaint = [&](const Point& from, const Point& to) {
        settings_.datum->touches[1] = {from, to};
        return message_of<SetupError>([&] { (void)start_session(plan("refused"), host(bench)); });
    };
    EXPECT_THAT(complaint({9, 0, 0}, {5, 0, 0}), HasSubstr("machine.datum.at[1]: from (9, 0, 0) mm to (5, 0, 0) mm it leads through the "
                                                           "workspace, where the part is: the datum has to stand beside it"));
    EXPECT_THAT(complaint({9, 0, 0}, {-9, 0, 0}), HasSubstr("it leads through the workspace"));
    EXPECT_THAT(complaint({9, 0, 0}, {16, 0, 0}), HasSubstr("`to`, (16, 0, 0) mm, is outside machine.limits"));
    EXPECT_THAT(complaint({9, 0, 0}, {9.1, 0, 0}), HasSubstr("the tool needs more than machine.retract, 0.2 mm, before a touch"));
    settings_.datum->touches.clear();
    EXPECT_THAT(message_of<SetupError>([&] { (void)start_session(plan("refused"), host(bench)); }),
                HasSubstr("machine.datum.at: holds no touch"));
    EXPECT_TRUE(bench.probe.log.empty());
}

TEST(DriftLog, TellsAJumpAndCountsEveryVisit) {
    DriftLog log(three_faces());
    const std::vector<Point> first{{10.5, 0, 0}, {11.5, -1, 0}, {11.5, 0, 1}};
    const auto moved = [&](const Vector& shift) {
        std::vector<Point> touched = first;
        for (int axis = 0; axis < 3; ++axis) touched[static_cast<std::size_t>(axis)][axis] += shift[axis];
        return touched;
    };
    EXPECT_FALSE(log.has_reading());
    log.add(first, {0, Seconds(0)});
    log.add(moved({0.03, -0.02, 0.05}), {10, Seconds(60)});
    EXPECT_NEAR((log.shift() - Vector(0.03, -0.02, 0.05)).norm(), 0, 1e-12);
    EXPECT_NEAR((log.at(Seconds(30)) - Vector(0.015, -0.01, 0.025)).norm(), 0, 1e-12);
    EXPECT_THROW(log.add(moved({0.03, -0.02, 0.16}), {20, Seconds(120)}), DriftJump);
    EXPECT_NEAR((log.shift() - Vector(0.03, -0.02, 0.05)).norm(), 0, 1e-12) << "as before";
    log.add(moved({0.03, 0, 0.05}), {10, Seconds(60)});
    EXPECT_NEAR((log.at(Seconds(60)) - Vector(0.03, 0, 0.05)).norm(), 0, 1e-12) << "the last of a moment counts";
    EXPECT_EQ(log.visits(), 3U);
    EXPECT_NEAR(log.largest_shift_mm(), std::sqrt(0.0038), 1e-12);
    EXPECT_THROW(log.add({first[0]}, {30, Seconds(90)}), BadAnswer);
}

}  // namespace
}  // namespace palpate::drift_session_test
