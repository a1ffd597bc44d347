// A probe that dies in mid-session, or misses touches: the planner on the real GRBL driver, which drives a virtual machine whose own
// account says how deep and how fast the tool went (devices/FACTS.md, "Safety floor").
#include "planner/motion/probe_watch.h"

#include <gmock/gmock.h>

#include "devices/decorators/multi_touch_device.h"
#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/grbl/grbl_device.h"
#include "planner/errors.h"
#include "sim/machines/grbl/loopback_stream.h"
#include "sim/machines/virtual_tool.h"
#include "tests/end_to_end/subjects.h"
#include "tests/random.h"

namespace palpate::probe_watch_test {
namespace {

using ::testing::HasSubstr;
using Outcome = ProbeAnswer::Outcome;

constexpr double kRadius = 5.0;
constexpr double kOvertravel = 2.0;
constexpr double kTouchError = 0.002;

// What was asked of the machine since it was told to die.
class LoggedOracle final : public SurfaceOracle {
public:
    explicit LoggedOracle(SurfaceOracle& oracle) : oracle_(oracle) {}
    [[nodiscard]] Point position() const override { return oracle_.position(); }
    [[nodiscard]] OracleTraits traits() const override { return oracle_.traits(); }
    void travel(std::span<const Point> path, Ground ground) override { oracle_.travel(path, ground); }
    [[nodiscard]] ProbeAnswer probe(const Point& target) override {
        asked.push_back({target, oracle_.probe(target)});
        return asked.back().answer;
    }
    [[nodiscard]] bool prove_alive() override {
        ++proofs;
        return false;
    }
    // Clears at the end.
    [[nodiscard]] std::size_t silence() const {
        std::size_t count = 0;
        while (count < asked.size() && asked[asked.size() - 1 - count].answer.outcome == Outcome::clear) ++count;
        return count;
    }

    struct Asked {
        Point target;
        ProbeAnswer answer;
    };
    std::vector<Asked> asked;
    int proofs = 0;

private:
    SurfaceOracle& oracle_;
};

// A session without a journal: all of the machine, and what came of it.
struct Rig {
    HiddenObject object{ShapeSpec{SphereSpec{kRadius}}};
    VirtualTool tool;
    VirtualGrbl grbl;
    LoopbackStream stream{grbl};
    GrblDevice device;
    MultiTouchDevice touching;
    DeviceOracle machine;
    LoggedOracle oracle;
    Options options;
    Result result;

    Rig(const Strategy& strategy, VirtualGrblOptions controller, bool watches = true)
        : tool(object, axes()),
          grbl(tool, std::move(controller)),
          device(stream, stream, {motion(), Point::Zero(), Homing::skip}),
          touching((device.make_ready(), device), MultiTouchOptions{}, motion().retract_mm),
          machine(touching, traits(watches)),
          oracle(machine) {
        options.epsilon = strategy.infer == Strategy::Infer::none ? 2 : 1;
        options.strategy = strategy;
        if (strategy.infer == Strategy::Infer::automatic) options.reach = kRadius;
    }
    void run() { result = probe_surface(oracle, Region(Ball{Point::Zero(), 7}), options); }

    static OracleTraits traits(bool watches) {
        OracleTraits traits;
        traits.touch_error = kTouchError;
        traits.retract = motion().retract_mm;
        if (watches) traits.overtravel = kOvertravel;
        return traits;
    }
    static MotionModel motion() {
        MotionModel k;
        k.retract_mm = 0.2;
        k.overtravel_mm = kOvertravel;
        return k;
    }
    static VirtualToolOptions axes() {
        VirtualToolOptions axes;
        axes.motion = motion();
        axes.start = {0, 0, 14};
        axes.limits = {Point::Constant(-16), Point::Constant(16)};
        axes.probe_feed_mm_per_s = axes.motion.feeds.probe_mm_per_s;
        return axes;
    }
};

VirtualGrblOptions dying_at(std::uint64_t probe) {
    VirtualGrblOptions options;
    options.faults = {{VirtualFault::Kind::dead_probe, VirtualFault::When::probe, static_cast<double>(probe), 0, {}}};
    return options;
}

void expect_safe(const Rig& rig) {
    const VirtualToolAudit& audit = rig.tool.audit();
    EXPECT_EQ(audit.fast_moves_inside, 0U);
    EXPECT_EQ(audit.unguarded_moves, 0U);
    EXPECT_EQ(audit.outside_limits, 0U);
}

// How deep a place lies in the ball, mm.
double depth(const Point& p) { return kRadius - p.norm(); }

TEST(ProbeWatch, AProbeThatDiesAtAnyMomentIsNoticedBeforeItCostsMore) {
    constexpr std::uint64_t kSeed = 19;
    constexpr int kMoments = 34;             // of each of six strategies
    constexpr std::uint64_t kLastTouch = 8;  // moves of the contact that a run ends with, after which nothing relies on the probe
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (const Strategy& strategy : all_strategies()) {
        Rig whole(strategy, {});
        whole.run();
        const std::uint64_t probes = whole.grbl.counts().probes;
        int expected = 0;
        std::string silences;
        for (int k = 0; k < kMoments; ++k) {
            const std::uint64_t at = 1 + random.below(probes - kLastTouch);
            SCOPED_TRACE(strategy_name(strategy) + ", at move " + std::to_string(at) + " of " + std::to_string(probes));
            Rig rig(strategy, dying_at(at));
            std::string said;
            try {
                rig.run();
                ADD_FAILURE() << "not noticed";
            } catch (const SilenceError& error) {
                said = error.what();
            }
            expect_safe(rig);
            const std::size_t silence = rig.oracle.silence();
            ASSERT_GE(silence, 1U);
            // The last one is the known place; before it the contact that stayed away, twice, or a touch that could not be made again.
            const bool is_expected = said.find("was expected") != std::string::npos;
            const bool is_announced = is_expected || said.find("twice, not again") != std::string::npos;

            EXPECT_LE(silence, static_cast<std::size_t>(ProbeWatch::kMaxClears) + 3) << said;
            for (std::size_t n = 0; n < std::min<std::size_t>(silence, is_expected ? 3 : 1); ++n) {
                const Point& end = rig.oracle.asked[rig.oracle.asked.size() - 1 - n].target;
                EXPECT_LE(depth(end), kOvertravel + 0.3) << "deeper than one overtravel beyond what was expected: " << said;
            }
            expected += is_announced ? 1 : 0;
            silences += std::to_string(silence) + (is_expected ? " " : "! ");
        }
        // Where a bound shows where S is, next to every contact is expected.
        if (strategy.infer == Strategy::Infer::automatic) {
            EXPECT_GE(expected, kMoments * 3 / 4) << silences;
        }
    }
}

TEST(ProbeWatch, NothingMovesFasterThanAProbeBeforeTheFirstContact) {
    for (const Strategy& strategy : all_strategies()) {
        Rig rig(strategy, dying_at(1));
        EXPECT_THROW(rig.run(), SilenceError);
        EXPECT_EQ(rig.oracle.silence(), static_cast<std::size_t>(ProbeWatch::kMaxClears));
        EXPECT_EQ(rig.oracle.proofs, 1) << "somebody is asked";
        expect_safe(rig);
    }
}

// A seed ray that the user vouches for announces a contact.
TEST(ProbeWatch, ASeedRayThatTouchesNothingIsAskedTwiceAndThenWhetherTheProbeWorks) {
    Rig rig({}, dying_at(1));
    rig.options.seed_rays = {{{0, 0, 9}, {0, 0, 4}}};
    try {
        rig.run();
        FAIL();
    } catch (const SilenceError& error) {
        EXPECT_THAT(error.what(), HasSubstr("nothing shows that the probe works"));
    }
    EXPECT_EQ(rig.oracle.asked.size(), 2U);
    EXPECT_EQ(rig.oracle.proofs, 1);
    EXPECT_LE(rig.tool.audit().deepest_end_mm, 1.001) << "no deeper than the ray ends";
}

TEST(ProbeWatch, ARunEndsWithAContact) {
    for (const Strategy& strategy : all_strategies()) {
        Rig rig(strategy, {});
        rig.run();
        EXPECT_EQ(rig.oracle.silence(), 0U) << strategy_name(strategy);
        expect_safe(rig);
    }
}

// A touch that is missed is found when it is asked for again; what the planner could not expect, the session finds out (MachineSession).
TEST(ProbeWatch, TouchesThatAreMissedNowAndThenAreAskedForAgain) {
    int right = 0;
    int runs = 0;
    for (const double rate : {0.01, 0.05}) {
        for (std::uint64_t seed = 1; seed <= 10; ++seed) {
            VirtualGrblOptions controller;
            controller.miss_rate = rate;
            controller.seed = seed;
            Rig rig({}, controller);
            ++runs;
            try {
                rig.run();
            } catch (const UnexpectedContact&) {
                continue;  // a clear that nothing had announced to be wrong
            }
            expect_safe(rig);
            EXPECT_EQ(rig.result.topology.euler_characteristic, 2);
            EXPECT_EQ(rig.result.topology.boundary_edges + rig.result.topology.nonmanifold_edges, 0U);
            ++right;
        }
    }
    EXPECT_GE(right, runs * 3 / 4);
}

TEST(ProbeWatch, CostsLittle) {
    for (const Strategy& strategy : {Strategy{}, Strategy::adaptive()}) {
        Rig with(strategy, {});
        with.run();
        Rig without(strategy, {}, false);
        without.run();
        const auto touches = [](const Rig& rig) { return static_cast<double>(rig.result.cost.contact); };
        EXPECT_LE(touches(with), 1.05 * touches(without) + 1) << strategy_name(strategy);
        EXPECT_LE(with.grbl.now().count(), 1.08 * without.grbl.now().count() + 5) << strategy_name(strategy);
    }
}

}  // namespace
}  // namespace palpate::probe_watch_test
