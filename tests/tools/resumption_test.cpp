// A resumed session goes on only if part and machine are where they were: it finds every shift that three known places can show, and
// refuses none that is right, whatever the noise of the touches. Sessions wait for answers most of the time: many run at once, each with
// its own machine.
#include "devices/session/resumption.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/reader.h"
#include "devices/session/journal.h"
#include "planner/number_text.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"
#include "tools/machine.h"
#include "tools/session_plan.h"

namespace palpate::resumption_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr double kNoise = 0.01;
constexpr double kTouchError = 2 * 0.001 + kNoise;

VirtualToolOptions noisy_axes(std::uint64_t seed) {
    VirtualToolOptions options = axes();
    options.touch_noise_mm = kNoise;
    options.touch_noise_seed = seed;
    return options;
}

// Calls `use` with 0 to count - 1, some at a time.
template <class Use>
void at_once(int count, const Use& use) {
    constexpr int kThreads = 12;
    std::atomic<int> next = 0;
    std::vector<std::jthread> threads;
    for (int k = 0; k < kThreads; ++k) {
        threads.emplace_back([&] {
            for (int i = next++; i < count; i = next++) use(i);
        });
    }
}

class Resumption : public SessionRig {
protected:
    // A session that the operator stopped when the tool had made so many probing moves.
    void run_until(const std::string& session, std::uint64_t probes, const std::string& epsilon) const {
        PortMachine machine(port(), {}, noisy_axes(1));
        auto words = probe(session);
        words.insert(words.end(), {"--set", "machine.noise=0.01", "--set", "probing.epsilon=" + epsilon});
        Process process = start(words);
        while (machine.probes() < probes) std::this_thread::sleep_for(1ms);
        process.send(SIGINT);
        ASSERT_EQ(process.wait(), 3) << read("out.txt");
        expect_safe(machine);
    }
    // The same session, interrupted when its journal had so many lines.
    void copy_cut(const std::string& from, const std::string& to, std::size_t lines) const {
        fs::copy(folder_ / from, folder_ / to, fs::copy_options::recursive);
        std::istringstream journal(read(from + "/journal.jsonl"));
        std::ofstream cut(folder_ / to / "journal.jsonl", std::ios::binary);
        std::string line;
        for (std::size_t k = 0; k < lines && std::getline(journal, line); ++k) cut << line << '\n';
    }
    [[nodiscard]] Journal journal_of(const fs::path& session) const { return read_journal(folder_ / session / "journal.jsonl"); }

    // A machine that stands where the session ended, and whose part is `shift` from where it was.
    [[nodiscard]] VirtualToolOptions machine_for(const fs::path& session, const Vector& shift, int seed) const {
        VirtualToolOptions options = noisy_axes(static_cast<std::uint64_t>(seed));
        options.start = kOrigin + journal_of(session).last_rest();
        options.origin += shift;
        return options;
    }
    // What a resumed session does before it goes on.
    [[nodiscard]] JournalResumption return_to(const fs::path& session, const fs::path& own_port, int seed) const {
        PortMachine machine(own_port, {}, machine_for(session, Vector::Zero(), seed));
        const SessionConfig config = read_config(folder_ / session / "config.yaml", {"machine.grbl.port=" + own_port.string()});
        const Journal journal = journal_of(session);
        GuardedMachine guarded(connect(*config.machine, {}), *config.machine);
        const Interruption interruption{journal.last_rest(), journal.confirmed_moves(), {}};
        const Return way_back = return_to_work(guarded, journal, machine_workspace(config), *config.machine, interruption);
        EXPECT_EQ(way_back.moves, journal.confirmed_moves());
        expect_safe(machine);
        return way_back.found;
    }
    // A copy of a session is resumed where the part has been shifted.
    void expect_found(const fs::path& session, const Vector& shift, int trial) const {
        const fs::path own = folder_ / ("shifted_" + std::to_string(trial));
        fs::create_directories(own);
        fs::copy(folder_ / session, own / "session", fs::copy_options::recursive);
        PortMachine machine(own / "tty", {}, machine_for(session, shift, trial));
        const std::string own_port = "machine.grbl.port=" + (own / "tty").string();
        const int code = Process(own, {"resume", "session", "--yes", "--set", own_port}).wait();
        const std::string said = read(own / "out.txt");
        EXPECT_EQ(code, 3) << said;
        EXPECT_THAT(said, AnyOf(HasSubstr("has moved"), HasSubstr("have moved"), HasSubstr("where space should be free")));
        EXPECT_EQ(read(own / "session/journal.jsonl"), read(session / "journal.jsonl")) << "nothing was recorded";
        expect_safe(machine);
    }
};

TEST_F(Resumption, FindsEveryShiftOfFiveTouchErrorsAndRefusesNothingRight) {
    constexpr std::uint64_t kSeed = 2027;
    constexpr int kShifts = 50;
    constexpr int kRight = 200;
    SCOPED_TRACE(seed_text(kSeed));
    ASSERT_NO_FATAL_FAILURE(run_until("stopped", 900, "1"));
    const std::size_t lines = journal_of("stopped").lines;
    ASSERT_GT(lines, 330U);
    const std::vector<std::size_t> moments = {200, 260, 330, lines};
    const auto session_of = [&](int k) { return "after_" + std::to_string(moments[static_cast<std::size_t>(k) % moments.size()]); };
    for (const std::size_t moment : moments) copy_cut("stopped", "after_" + std::to_string(moment), moment);

    at_once(kRight, [&](int k) {
        const std::string session = session_of(k);
        SCOPED_TRACE(session + ", noise " + std::to_string(k));
        JournalResumption found;
        ASSERT_NO_THROW(found = return_to(session, folder_ / ("tty_" + std::to_string(k)), 100 + k));
        EXPECT_EQ(found.directions, 3);
        for (const double offset : found.offsets_mm) EXPECT_LE(std::abs(offset), 2 * kTouchError);
    });
    Random random(kSeed);
    std::vector<Vector> shifts;
    for (int k = 0; k < kShifts; ++k) shifts.emplace_back(5 * kTouchError * random.direction());
    at_once(kShifts, [&](int k) {
        const Vector& shift = shifts[static_cast<std::size_t>(k)];
        SCOPED_TRACE(session_of(k) + ", shift " + point_text(shift));
        expect_found(session_of(k), shift, 1000 + k);
    });
}

TEST_F(Resumption, ARightOneGoesOnToTheEndAndSaysThatItSawAllDirections) {
    ASSERT_NO_FATAL_FAILURE(run_until("stopped", 900, "1"));
    PortMachine machine(port(), {}, machine_for("stopped", Vector::Zero(), 5));
    ASSERT_EQ(run(resume("stopped")), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), ::testing::Not(HasSubstr("of 3 directions only")));
    const auto summary = nlohmann::json::parse(read("stopped/summary.json"));
    EXPECT_EQ(summary.at("euler_characteristic"), 2);
    EXPECT_EQ(summary.at("machine").at("datum").at("directions"), 3);
    expect_safe(machine);
}

// ... where no three places with independent normals are known.
TEST_F(Resumption, OfASessionThatHasHardlyBegunSaysWhatItCannotSee) {
    ASSERT_NO_FATAL_FAILURE(run_until("early", 40, "2"));
    ASSERT_FALSE(journal_of("early").moves.empty());
    PortMachine machine(port(), {}, machine_for("early", Vector::Zero(), 5));
    ASSERT_EQ(run(resume("early")), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("of 3 directions only: look whether both are where they were"));
    const Journal journal = journal_of("early");
    ASSERT_EQ(journal.resumptions.size(), 1U);
    EXPECT_LT(journal.resumptions[0].directions, 3);
    const auto datum = nlohmann::json::parse(read("early/summary.json")).at("machine").at("datum");
    EXPECT_EQ(datum.at("directions"), journal.resumptions[0].directions);
    EXPECT_EQ(datum.at("touches"), journal.resumptions[0].contacts.size());
    expect_safe(machine);
}

}  // namespace
}  // namespace palpate::resumption_test
