#include "sim/machines/grbl/loopback_stream.h"

#include "devices/errors.h"
#include "tests/sim/machines/grbl/virtual_grbl_support.h"

namespace palpate::loopback_stream_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

class LoopbackStreamTest : public VirtualGrblTest {};

TEST_F(LoopbackStreamTest, ReadWaitsInVirtualTimeUntilTheAnswerComes) {
    start();
    LoopbackStream stream(*grbl);
    stream.write("G38.2 X0 F300\n");
    const auto begin = stream.now();
    std::string answer;
    while (answer.find("ok") == std::string::npos) answer += stream.read(10s);
    EXPECT_THAT(lines_of(answer), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok"));
    const Seconds took = stream.now() - begin;
    EXPECT_NEAR(took.count(), 10.0 / 5 + 5.0 / 400, 0.05);
}

TEST_F(LoopbackStreamTest, ReadEndsAtItsTimeout) {
    start();
    LoopbackStream stream(*grbl);
    const auto begin = stream.now();
    EXPECT_THAT(stream.read(250ms), IsEmpty());
    EXPECT_NEAR(Seconds(stream.now() - begin).count(), 0.25, 1e-3);
    stream.write("G4 P1\n");
    EXPECT_THAT(stream.read(250ms), IsEmpty());
    EXPECT_THAT(lines_of(stream.read(1000ms)), ElementsAre("ok"));
}

TEST_F(LoopbackStreamTest, ALoopOfReadsThatDoNotWaitComesToAnEnd) {
    start();
    LoopbackStream stream(*grbl);
    stream.write("G4 P1\n");
    int reads = 0;
    while (stream.read(0ms).empty() && reads < 100000) ++reads;
    EXPECT_LT(reads, 100000);
    const auto begin = stream.now();
    stream.sleep(2s);
    EXPECT_EQ(stream.now() - begin, 2s);
}

TEST_F(LoopbackStreamTest, APulledCableIsAConnectionLostInEveryCall) {
    for (const auto kind : {VirtualFault::Kind::hang_up, VirtualFault::Kind::io_error}) {
        options.faults = {{kind, VirtualFault::When::time, 1.0}};
        start();
        LoopbackStream stream(*grbl);
        stream.write("G4 P5\n");
        EXPECT_THROW((void)stream.read(10s), ConnectionLost);
        EXPECT_THROW((void)stream.read(0ms), ConnectionLost);
        EXPECT_THROW(stream.write("?"), ConnectionLost);
        grbl->plug_in();
        stream.write("?");
        EXPECT_EQ(stream.read(1s).substr(0, 6), "<Idle|");
    }
}

}  // namespace
}  // namespace palpate::loopback_stream_test
