// Faults on demand and by chance.
#include <cmath>

#include "sim/machines/grbl/virtual_grbl.h"
#include "tests/random.h"
#include "tests/sim/machines/grbl/virtual_grbl_support.h"

namespace palpate::virtual_grbl_faults_test {
namespace {

using Kind = VirtualFault::Kind;
using When = VirtualFault::When;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class VirtualGrblFaultsTest : public VirtualGrblTest {};

TEST_F(VirtualGrblFaultsTest, AStaleLineComesBeforeTheAnswerOfItsLine) {
    options.faults = {{Kind::stale_line, When::line, 2, 0, "ok"}};
    start();
    EXPECT_THAT(command("G21"), ElementsAre("ok"));
    EXPECT_THAT(command("G38.2 X0 F600"), ElementsAre("ok", "[PRB:10.000,0.000,0.000:1]", "ok"));
    EXPECT_THAT(command("G21"), ElementsAre("ok"));
}

TEST_F(VirtualGrblFaultsTest, BytesOfTheOutputAreLost) {
    options.faults = {{Kind::lose_output, When::line, 1, 4}};
    start();
    EXPECT_THAT(command("G38.2 X0 F600"), ElementsAre(":10.000,0.000,0.000:1]", "ok"));
}

TEST_F(VirtualGrblFaultsTest, ALateAnswerComesComplete) {
    options.faults = {{Kind::late_answer, When::line, 1, 3.0}};
    start();
    EXPECT_THAT(send("G21\n"), IsEmpty());
    EXPECT_THAT(after(2.9), IsEmpty());
    EXPECT_THAT(after(0.2), ElementsAre("ok"));
}

TEST_F(VirtualGrblFaultsTest, TheResetButtonForgetsTheCountOfSteps) {
    options.faults = {{Kind::press_reset, When::time, 1.0}};
    start();
    send("G38.2 X0 F300\n");
    EXPECT_THAT(after(1.0), IsEmpty());
    EXPECT_THAT(rest(), ElementsAre("Grbl 1.1h ['$' for help]", kLockMessage));
    EXPECT_THAT(status(), StartsWith("<Alarm|MPos:0.000,0.000,0.000|"));
    EXPECT_GT(tool->true_position().x(), 10);
    EXPECT_EQ(grbl->counts().resets, 1U);
}

TEST_F(VirtualGrblFaultsTest, ASpuriousTriggerOfAProbeMoveComesOnItsWay) {
    options.faults = {{Kind::spurious_trigger, When::probe, 2, 0.5}};
    start();
    EXPECT_THAT(command("G38.3 Y10 F600"), ElementsAre("[PRB:20.000,10.000,0.000:0]", "ok"));
    EXPECT_THAT(command("G38.3 Y0 F600"), ElementsAre("[PRB:20.000,5.000,0.000:1]", "ok"));
    EXPECT_EQ(grbl->counts().spurious, 1U);
}

TEST_F(VirtualGrblFaultsTest, AMissedTriggerGoesDeep) {
    options.faults = {{Kind::missed_trigger, When::probe, 1}};
    start();
    EXPECT_THAT(command("G38.3 X5 F600"), ElementsAre("[PRB:5.000,0.000,0.000:0]", "ok"));
    EXPECT_EQ(tool->audit().unsafe_moves, 1U);
    EXPECT_NEAR(tool->audit().deepest_mm, 5, 1e-6);
}

TEST_F(VirtualGrblFaultsTest, ABouncingProbeMayStillBeClosedAfterARetract) {
    options.faults = {{Kind::bounce, When::probe, 1, 20}};
    start();
    EXPECT_THAT(command("G38.3 X0 F600"), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok"));
    send("G91 G1 X1 F600\n");
    int closed = 0;
    int open = 0;
    for (int i = 0; i < 400; ++i) {
        after(0.001);
        const bool out = tool->true_position().x() > 10;
        (out && tool->is_probe_closed() ? closed : open) += 1;
    }
    EXPECT_GT(closed, 10);
    EXPECT_GT(open, 10);
    rest();
    EXPECT_FALSE(tool->is_probe_closed());
}

TEST_F(VirtualGrblFaultsTest, AnAlarmTakesThePlaceOfTheProbeMove) {
    options.faults = {{Kind::alarm, When::probe, 1, 5}};
    start();
    EXPECT_THAT(command("G38.3 X0 F600"), ElementsAre("ALARM:5", "[PRB:0.000,0.000,0.000:0]", "ok"));
    EXPECT_EQ(tool->audit().moves, 0U);
}

TEST_F(VirtualGrblFaultsTest, ADeadControllerSaysNothingUntilItIsReset) {
    options.faults = {{Kind::silence, When::time, 1.0}};
    start();
    send("G38.2 X0 F300\n");
    EXPECT_THAT(after(10.0), IsEmpty());
    EXPECT_FALSE(tool->is_moving());
    EXPECT_THAT(send("?"), IsEmpty());
    EXPECT_THAT(send("\x18"), IsEmpty());
    EXPECT_THAT(rest(), IsEmpty());
    grbl->press_reset();
    EXPECT_THAT(rest(), Contains("Grbl 1.1h ['$' for help]"));
}

TEST_F(VirtualGrblFaultsTest, ADeadControllerRaisesNoAlarm) {
    for (const double alarm_at : {1.0, 2.0}) {
        options.faults = {{Kind::silence, When::time, 1.0}, {Kind::alarm, When::time, alarm_at, 1.0}};
        start();
        send("G38.2 X0 F300\n");
        EXPECT_THAT(after(10.0), IsEmpty());
    }
}

TEST_F(VirtualGrblFaultsTest, SpuriousTriggersComeAsOftenAsTheirRateSays) {
    constexpr int kMoves = 2000;
    options.spurious_rate = 0.1;
    options.seed = 42;
    SCOPED_TRACE(seed_text(options.seed));
    const auto count = [&] {
        start();
        int contacts = 0;
        for (int i = 0; i < kMoves; ++i) {
            const double y = tool->position().y() > 10 ? 0 : 20;
            const Lines lines = command("G38.3 X20 Y" + std::to_string(y) + " F6000");
            if (lines.size() != 2) return -1;
            contacts += lines[0].ends_with(":1]") ? 1 : 0;
        }
        EXPECT_EQ(grbl->counts().spurious, static_cast<std::uint64_t>(contacts));
        return contacts;
    };
    const int first = count();
    EXPECT_NEAR(first, 0.1 * kMoves, 5 * std::sqrt(0.1 * 0.9 * kMoves));
    EXPECT_EQ(count(), first) << "the same seed, the same faults";
}

TEST_F(VirtualGrblFaultsTest, TouchesAreMissedAsOftenAsTheirRateSays) {
    constexpr int kMoves = 500;
    options.miss_rate = 0.1;
    options.seed = 42;
    SCOPED_TRACE(seed_text(options.seed));
    const auto count = [&] {
        start();
        int misses = 0;
        for (int i = 0; i < kMoves; ++i) {
            const Lines lines = command("G38.3 X9.5 Y0 F3000");
            misses += !lines.empty() && lines[0].ends_with(":0]") ? 1 : 0;
            command("G1 X12");
        }
        return misses;
    };
    const int first = count();
    EXPECT_NEAR(first, 0.1 * kMoves, 5 * std::sqrt(0.1 * 0.9 * kMoves));
    EXPECT_EQ(count(), first) << "the same seed, the same misses";
}

// Whatever comes, in whatever pieces, the machine neither crashes nor hangs, and its account stays true.
TEST_F(VirtualGrblFaultsTest, RandomBytesDoNoHarm) {
    constexpr std::uint64_t kSeed = 9;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const std::vector<std::string> pieces{"?",
                                          "!",
                                          "~",
                                          "\x18",
                                          "\x85",
                                          "\n",
                                          "\r\n",
                                          "$X\n",
                                          "$H\n",
                                          "$C\n",
                                          "$#\n",
                                          "$$\n",
                                          "G0X20\n",
                                          "G38.2X0F600\n",
                                          "G38.3Y30F900\n",
                                          "G38.5X20\n",
                                          "G1Y9\n",
                                          "G91\n",
                                          "$J=X1F60\n",
                                          "G4P0.1\n",
                                          "G1X",
                                          "M3S1(a",
                                          "$20=1\n",
                                          "G20G1Y1F9\n",
                                          "\xff",
                                          "G92X1\n",
                                          "G10L2P1X3\n",
                                          std::string(1, '\0'),
                                          "G0Z99\n",
                                          "$13=1\n",
                                          "\x91\x91\x91\x91",
                                          "\x92",
                                          "\x90",
                                          "\xA0",
                                          "M8\n"};
    for (const auto dialect : {GrblDialect::grbl, GrblDialect::grblhal}) {
        options.dialect = dialect;
        options.spurious_rate = 0.2;
        options.bounce_rate = 0.2;
        start();
        for (int i = 0; i < 20000; ++i) {
            send(random.one_of(pieces));
            if (random.chance(0.5)) after(random.uniform(0, 0.3));
            if (random.chance(0.05)) {  // a full buffer hears nothing else
                grbl->press_reset();
                rest();
                send("$X\n");
            }
        }
        grbl->press_reset();
        EXPECT_THAT(rest(), Contains(StartsWith("Grbl")));
        EXPECT_THAT(status(), StartsWith("<"));
        EXPECT_GT(tool->audit().moves, 100U);
    }
}

}  // namespace
}  // namespace palpate::virtual_grbl_faults_test
