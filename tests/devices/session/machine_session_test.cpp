// Sessions on a machine of the user's own: all that they need is here, in devices/ and in planner/.
#include "devices/session/machine_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "devices/errors.h"
#include "devices/version.h"
#include "tests/devices/fake_probe.h"
#include "tests/devices/message_of.h"
#include "tests/random.h"

namespace palpate::machine_session_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = PlannedMotion::Kind;

constexpr double kRadius = 5.0;
constexpr double kRetract = 0.2;

// What is still there when a driver is gone: axes with a probe, above a ball, and whether they have been homed.
struct Bench {
    FakeProbe probe{ball(Point::Zero(), kRadius), Point(0, 0, 14), kRetract};
    bool is_homed = true;
    int connections = 0;
    int made_ready = 0;
};

class BenchMachine final : public Machine {
public:
    explicit BenchMachine(Bench& bench) : bench_(bench) { ++bench_.connections; }

    [[nodiscard]] ProbeDevice& device() override { return bench_.probe; }
    [[nodiscard]] MachineReport report() override {
        MachineReport report;
        report.identity = "a ball on a bench";
        report.state = bench_.is_homed ? "ready" : "switched on";
        report.needs_homing = !bench_.is_homed;
        report.position = bench_.probe.position();
        return report;
    }
    void make_ready() override {
        bench_.is_homed = true;
        ++bench_.made_ready;
    }
    void retreat(const Point& target) override { (void)bench_.probe.guarded_move(target, Pace::probe); }
    [[nodiscard]] bool is_probe_closed() override { return false; }
    [[nodiscard]] bool is_position_trusted() override { return bench_.is_homed; }

private:
    Bench& bench_;
};

class SessionOnOwnMachine : public ::testing::Test {
protected:
    SessionOnOwnMachine() {
        std::string name = (fs::temp_directory_path() / "palpate_own_machine_XXXXXX").string();
        folder_ = mkdtemp(name.data());
        settings_.limits = {Point::Constant(-15), Point::Constant(15)};
        settings_.motion.retract_mm = kRetract;
    }
    ~SessionOnOwnMachine() override { fs::remove_all(folder_); }

    [[nodiscard]] SessionPlan plan(const std::string& session) const {
        Options probing;
        probing.epsilon = 2.0;
        probing.reach = 4.9;
        return {settings_, Region(Ball{Point::Zero(), 7.0}), probing, folder_ / session, "of this test", "this test", "of its object"};
    }
    [[nodiscard]] SessionHost host(Bench& bench) {
        SessionHost host;
        host.connect = [&bench] { return std::make_unique<BenchMachine>(bench); };
        host.ask = [this](const PlannedMotion& motion) { asked_.push_back(motion); };
        return host;
    }
    [[nodiscard]] std::vector<Kind> kinds_asked() const {
        std::vector<Kind> kinds;
        for (const PlannedMotion& motion : asked_) kinds.push_back(motion.kind);
        return kinds;
    }

    fs::path folder_;
    MachineSettings settings_;
    std::vector<PlannedMotion> asked_;
};

bool same_mesh(const MachineRun& a, const MachineRun& b) {
    return a.result.mesh.points == b.result.mesh.points && a.result.mesh.triangles == b.result.mesh.triangles;
}

TEST_F(SessionOnOwnMachine, InterruptedResumedAndReplayedItEndsAsOneThatWasNot) {
    constexpr std::uint64_t kSeed = 31;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    Bench undisturbed;
    const MachineRun reference = start_session(plan("reference"), host(undisturbed));
    EXPECT_EQ(reference.result.topology.euler_characteristic, 2);
    EXPECT_EQ(reference.result.certificate.status, Certificate::Status::conditional);
    EXPECT_EQ(reference.machine, "a ball on a bench");
    const Journal whole = read_journal(folder_ / "reference");
    EXPECT_EQ(whole.header.version, program_version());
    EXPECT_EQ(whole.header.object_sha256, "of its object");
    const std::size_t moves = undisturbed.probe.log.size();
    ASSERT_GT(moves, 100U);

    for (int trial = 0; trial < 8; ++trial) {
        const std::size_t last = 1 + random.below(moves * 3 / 4);
        const std::string name = "cut_" + std::to_string(trial);
        SCOPED_TRACE(name + " after " + std::to_string(last) + " moves of " + std::to_string(moves));
        asked_.clear();
        Bench bench;
        bench.probe.fault = [&bench, last] { return bench.connections == 1 && bench.probe.log.size() == last; };
        ASSERT_THROW((void)start_session(plan(name), host(bench)), ConnectionLost);
        EXPECT_THROW((void)replay_session(plan(name), host(bench)), NotFinished);
        const MachineRun resumed = resume_session(plan(name), host(bench));
        EXPECT_THAT(kinds_asked(), ElementsAre(Kind::begin, Kind::go_on));
        EXPECT_EQ(resumed.resumptions.size(), 1U);
        EXPECT_TRUE(same_mesh(resumed, reference));
        const Journal journal = read_journal(folder_ / name);
        ASSERT_EQ(journal.moves.size(), whole.moves.size());
        for (std::size_t k = 0; k < whole.moves.size(); ++k) {
            ASSERT_EQ(journal.moves[k].target, whole.moves[k].target) << k;
            ASSERT_EQ(journal.moves[k].result, whole.moves[k].result) << k;
        }

        SessionHost nobody;
        nobody.connect = []() -> std::unique_ptr<Machine> { throw std::logic_error("a replay connects to nothing"); };
        const MachineRun replayed = replay_session(plan(name), nobody);
        EXPECT_TRUE(same_mesh(replayed, reference));
        EXPECT_EQ(replayed.resumptions, resumed.resumptions);
        EXPECT_EQ(replayed.object_sha256, "of its object");
        EXPECT_TRUE(same_mesh(resume_session(plan(name), nobody), reference)) << "it is finished";
    }
}

TEST_F(SessionOnOwnMachine, NothingMovesUnasked) {
    Bench bench;
    bench.is_homed = false;
    settings_.homing = Homing::run;
    SessionHost refusing = host(bench);
    refusing.ask = [this](const PlannedMotion& motion) {
        asked_.push_back(motion);
        throw SetupError("no");
    };
    EXPECT_THROW((void)start_session(plan("refused"), refusing), SetupError);
    ASSERT_THAT(kinds_asked(), ElementsAre(Kind::begin));
    EXPECT_TRUE(asked_[0].homes_first);
    EXPECT_EQ(asked_[0].report.position, Point(0, 0, 14));
    EXPECT_EQ(bench.made_ready, 0);
    EXPECT_THAT(bench.probe.log, IsEmpty());
    EXPECT_FALSE(fs::exists(folder_ / "refused"));
    settings_.homing = Homing::require;
    EXPECT_THROW((void)start_session(plan("refused"), refusing), SetupError);
    EXPECT_FALSE(asked_[1].homes_first);
}

TEST_F(SessionOnOwnMachine, TheProbeIsPressedByHandAsTheSettingsSay) {
    Bench bench;
    settings_.probe_proof = ProbeProof::hand;
    EXPECT_THROW((void)start_session(plan("unproven"), host(bench)), std::invalid_argument);
    EXPECT_EQ(bench.connections, 0);
    for (const ProbeProof proof : {ProbeProof::hand, ProbeProof::automatic}) {
        settings_.probe_proof = proof;
        SessionHost unseen = host(bench);
        unseen.press = [](Machine& machine) { return machine.is_probe_closed(); };
        EXPECT_THAT(message_of<DeviceError>([&] { (void)start_session(plan("unproven"), unseen); }), HasSubstr("nothing has moved"));
    }
    EXPECT_EQ(bench.made_ready, 0);
    EXPECT_THAT(bench.probe.log, IsEmpty());
    settings_.probe_proof = ProbeProof::first_touch;
    SessionHost unpressed = host(bench);
    unpressed.press = [](Machine&) -> bool { throw std::logic_error("nobody has to press it"); };
    EXPECT_EQ(start_session(plan("proven"), unpressed).result.topology.euler_characteristic, 2);
}

TEST_F(SessionOnOwnMachine, WhatItWasBegunWithCannotBeChanged) {
    Bench bench;
    (void)start_session(plan("session"), host(bench));
    SessionPlan changed = plan("session");
    changed.config_digest = "of another";
    EXPECT_THAT(message_of<SetupError>([&] { (void)replay_session(changed, host(bench)); }), HasSubstr("this test: was changed"));
    EXPECT_THROW((void)start_session(plan("session"), host(bench)), JournalError) << "nor overwritten";
}

TEST_F(SessionOnOwnMachine, NobodyIsAskedAboutASessionThatCannotBegin) {
    Bench bench;
    settings_.limits.max.z() = 6.0;
    EXPECT_THAT(message_of<SetupError>([&] { (void)start_session(plan("narrow"), host(bench)); }),
                HasSubstr("the tool has to get all around the workspace"));
    EXPECT_EQ(bench.connections, 0);
    settings_.limits.max.z() = 13.0;
    EXPECT_THAT(message_of<SetupError>([&] { (void)start_session(plan("outside"), host(bench)); }), HasSubstr("outside machine.limits"));
    EXPECT_THAT(asked_, IsEmpty());
    EXPECT_FALSE(fs::exists(folder_ / "outside"));
}

}  // namespace
}  // namespace palpate::machine_session_test
