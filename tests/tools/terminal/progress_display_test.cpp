#include "tools/terminal/progress_display.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace palpate::progress_display_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

const Progress kHalf{1234, 5678, 0.5214, 0.25, 37, 0, 0, 0.5};

class Display : public testing::Test {
protected:
    [[nodiscard]] ProgressDisplay::Clock clock() {
        return [this] { return now_; };
    }
    [[nodiscard]] DisplayTraits terminal(int columns) const {
        return {true, false, false, [columns] { return columns; }};
    }

    nanoseconds now_{0};
    // What is drawn: a status begins with a carriage return, as on the screen.
    [[nodiscard]] ProgressSink sink() {
        return {[this](const std::string& line) { out_ += line + '\n'; }, [this](const std::string& status) { out_ += '\r' + status; }};
    }
    std::string out_;
};

TEST_F(Display, PipeGetsAWholeLineAtMostEveryTwoSeconds) {
    ProgressDisplay display(sink(), {}, clock());
    Progress progress = kHalf;
    TimeLeft time_left;
    for (int i = 0; i < 500; ++i) {
        progress.samples = static_cast<std::uint64_t>(i);
        time_left.note(now_, i, 2 * i);
        display.update(progress, time_left);
        now_ += milliseconds(10);
    }
    display.finish(kHalf);
    EXPECT_EQ(out_,
              "50 %, 0 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n"
              "50 %, 2 s left, 200 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n"
              "50 %, 4 s left, 400 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n"
              "50 %, 1234 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n");
}

TEST_F(Display, TerminalRewritesOneLineAndEndsItOnce) {
    {
        ProgressDisplay display(sink(), terminal(100), clock());
        display.update(kHalf);
        display.update(kHalf);
        now_ += milliseconds(100);
        display.update(kHalf);
        display.finish(kHalf);
    }
    const std::string line = "[============.............]   50 %  1234 samples  5678 probes  ball 0.521 of 0.25 mm  37 open edges";
    EXPECT_EQ(out_, '\r' + line + '\r' + line + '\r' + line + '\n') << "the status is taken away, and its line stays";
}

TEST_F(Display, EndsItsLineWhenTheRunThrows) {
    try {
        ProgressDisplay display(sink(), terminal(80), clock());
        display.update(kHalf);
        throw std::runtime_error("device fault");
    } catch (const std::runtime_error&) {
        EXPECT_EQ(out_.back(), '\n');
    }
}

TEST_F(Display, SaysNothingWhenNeverUpdated) {
    { const ProgressDisplay display(sink(), terminal(80), clock()); }
    EXPECT_EQ(out_, "");
}

TEST_F(Display, FollowsTheWidthOfTheWindow) {
    int columns = 100;
    ProgressDisplay display(sink(), {true, false, false, [&columns] { return columns; }}, clock());
    display.update(kHalf);
    columns = 20;
    now_ += milliseconds(100);
    out_.clear();
    display.update(kHalf);
    EXPECT_EQ(out_, "\r[=====.....]   50 %");
}

TEST(ProgressLine, NeverIsWiderThanAsked) {
    for (int columns = 0; columns < 200; ++columns) {
        EXPECT_LE(static_cast<int>(progress_line(kHalf, "", columns, false).size()), columns);
    }
    EXPECT_EQ(progress_line(kHalf, "", 4, false), "");
    EXPECT_EQ(progress_line(kHalf, "", 5, false), " 50 %");
    EXPECT_EQ(progress_line(kHalf, "", 12, false), " 50 %");
    // The usual width, less the last column.
    EXPECT_EQ(progress_line(kHalf, "", 79, false), "[==...]   50 %  1234 samples  5678 probes  ball 0.521 of 0.25 mm  37 open edges");
    EXPECT_EQ(progress_line(kHalf, "", 30, false), "[===....]   50 %  1234 samples");
}

TEST(ProgressLine, DrawsEighthsWhereItCan) {
    Progress progress = kHalf;
    progress.fraction_done = 1.0;
    EXPECT_EQ(progress_line(progress, "", 32, true), "███████████  100 %  1234 samples");
    progress.fraction_done = 0.5;
    EXPECT_EQ(progress_line(progress, "", 32, true), "█████▌        50 %  1234 samples");
    progress.fraction_done = 0.0;
    EXPECT_EQ(progress_line(progress, "", 32, true), "               0 %  1234 samples");
}

TEST(ProgressLine, SurvivesFractionsThatAreNone) {
    Progress progress = kHalf;
    for (const double fraction : {std::numeric_limits<double>::quiet_NaN(), -1.0, -std::numeric_limits<double>::infinity()}) {
        progress.fraction_done = fraction;
        EXPECT_EQ(progress_line(progress, "", 32, false), "[.........]    0 %  1234 samples");
    }
    progress.fraction_done = std::numeric_limits<double>::infinity();
    EXPECT_EQ(progress_line(progress, "", 32, false), "[=========]  100 %  1234 samples");
    progress.fraction_done = 0.9999;
    EXPECT_EQ(progress_line(progress, "", 32, false), "[========.]   99 %  1234 samples");
}

TEST(ProgressDisplayCost, AMillionUpdatesTakeNoTime) {
    ProgressDisplay display({[](const std::string&) {}, [](const std::string&) {}}, {});
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 1000000; ++i) {
        display.update(kHalf);
    }
    // Measured: 0.05 s; the rest is for sanitizers and busy machines.
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

// A pseudo-terminal, and the variables that programs are told about terminals by.
class Traits : public testing::Test {
protected:
    void SetUp() override {
        master_ = ::posix_openpt(O_RDWR | O_NOCTTY);
        ASSERT_GE(master_, 0);
        ASSERT_EQ(::grantpt(master_), 0);
        ASSERT_EQ(::unlockpt(master_), 0);
        terminal_ = ::open(::ptsname(master_), O_RDWR | O_NOCTTY);
        ASSERT_GE(terminal_, 0);
        ::setenv("TERM", "xterm", 1);
        ::setenv("LC_ALL", "C.UTF-8", 1);
        ::unsetenv("NO_COLOR");
    }
    void TearDown() override {
        ::close(terminal_);
        ::close(master_);
    }

    int master_ = -1;
    int terminal_ = -1;
};

TEST_F(Traits, ATerminalRewritesAndIsColoured) {
    const DisplayTraits traits = DisplayTraits::of(terminal_);
    EXPECT_TRUE(traits.rewrites);
    EXPECT_TRUE(traits.colours);
    EXPECT_TRUE(traits.unicode);
    ASSERT_TRUE(traits.width);
    EXPECT_EQ(traits.width(), 0);  // nobody has told this pseudo-terminal its size
}

TEST_F(Traits, NoColorAndPlainLocalesAreRespected) {
    ::setenv("NO_COLOR", "1", 1);
    ::setenv("LC_ALL", "C", 1);
    const DisplayTraits traits = DisplayTraits::of(terminal_);
    EXPECT_TRUE(traits.rewrites);
    EXPECT_FALSE(traits.colours);
    EXPECT_FALSE(traits.unicode);
}

TEST_F(Traits, ADumbTerminalGetsPlainLines) {
    ::setenv("TERM", "dumb", 1);
    EXPECT_FALSE(DisplayTraits::of(terminal_).rewrites);
}

TEST_F(Traits, AFileGetsPlainLines) {
    const int file = ::open("/dev/null", O_WRONLY);
    EXPECT_FALSE(DisplayTraits::of(file).rewrites);
    EXPECT_FALSE(DisplayTraits::of(file).colours);
    ::close(file);
    EXPECT_FALSE(DisplayTraits::of(-1).rewrites);
}

}  // namespace
}  // namespace palpate::progress_display_test
