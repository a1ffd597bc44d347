#include "tools/terminal/time_left.h"

#include <gtest/gtest.h>

namespace palpate::time_left_test {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(TimeLeft, IsNotGuessedFromLessThanATenth) {
    TimeLeft left;
    left.note(seconds(0), 0.0);
    left.note(seconds(60), 0.09);
    EXPECT_EQ(left.text(), "");
    left.note(seconds(80), 0.1);
    EXPECT_EQ(left.text(), "12 min left");
}

TEST(TimeLeft, OfARunOfConstantSpeedIsExact) {
    TimeLeft left;
    for (int second = 0; second < 100; ++second) {
        left.note(seconds(second), second / 100.0);
        if (second > 10) {
            EXPECT_NEAR(static_cast<double>(left.left().count()) / 1e9, 100 - second, 1e-6);
        }
    }
}

// A facet that was known may be lost.
TEST(TimeLeft, NeverGoesBack) {
    TimeLeft left;
    left.note(seconds(0), 10, 100);
    left.note(seconds(10), 60, 100);
    left.note(seconds(20), 59, 100);
    left.note(seconds(30), 80, 100);
    EXPECT_EQ(left.left(), seconds(20));
}

// What is replayed from a journal takes no time.
TEST(TimeLeft, AfterAReplayItIsThatOfTheMachine) {
    TimeLeft left;
    left.note(seconds(0), 0.0);
    left.note(seconds(1), 0.5);
    for (int second = 2; second <= 20; ++second) left.note(seconds(second), 0.5 + (second - 1) * 0.005);
    EXPECT_NEAR(static_cast<double>(left.left().count()) / 1e9, 81, 1);
}

TEST(TimeLeft, IsSaidAsExactlyAsAnybodyWould) {
    EXPECT_EQ(duration_text(seconds(0)), "0 s");
    EXPECT_EQ(duration_text(seconds(59)), "59 s");
    EXPECT_EQ(duration_text(seconds(90)), "2 min");
    EXPECT_EQ(duration_text(seconds(3600)), "1 h 0 min");
    EXPECT_EQ(duration_text(seconds(7 * 3600 + 125)), "7 h 2 min");
}

}  // namespace
}  // namespace palpate::time_left_test
