#include "tools/progress_display.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace palpate {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

const Progress kHalf{1234, 5678, 0.5214, 0.25, 37, 0.5};

class Display : public testing::Test {
protected:
    [[nodiscard]] ProgressDisplay::Clock clock() {
        return [this] { return now_; };
    }
    [[nodiscard]] DisplayTraits terminal(int columns, bool colours = false) const {
        return {true, colours, false, [columns] { return columns; }};
    }

    nanoseconds now_{0};
    std::ostringstream out_;
};

TEST_F(Display, PipeGetsAWholeLineAtMostEveryTwoSeconds) {
    ProgressDisplay display(out_, {}, clock());
    Progress progress = kHalf;
    for (int i = 0; i < 500; ++i) {
        progress.samples = static_cast<std::uint64_t>(i);
        display.update(progress);
        now_ += milliseconds(10);
    }
    display.finish(kHalf);
    EXPECT_EQ(out_.str(),
              "50 %, 0 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n"
              "50 %, 200 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n"
              "50 %, 400 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n"
              "50 %, 1234 samples, 5678 probes, ball 0.521 of 0.25 mm, 37 open edges\n");
}

TEST_F(Display, TerminalRewritesOneLineAndEndsItOnce) {
    {
        ProgressDisplay display(out_, terminal(100), clock());
        display.update(kHalf);
        display.update(kHalf);
        now_ += milliseconds(100);
        display.update(kHalf);
        display.finish(kHalf);
    }
    const std::string line = "\r[============.............]   50 %  1234 samples  5678 probes  ball 0.521 of 0.25 mm  37 open edges\x1b[K";
    EXPECT_EQ(out_.str(), line + line + line + "\n");
}

TEST_F(Display, EndsItsLineWhenTheRunThrows) {
    try {
        ProgressDisplay display(out_, terminal(80), clock());
        display.update(kHalf);
        throw std::runtime_error("device fault");
    } catch (const std::runtime_error&) {
        EXPECT_EQ(out_.str().back(), '\n');
    }
}

TEST_F(Display, SaysNothingWhenNeverUpdated) {
    { const ProgressDisplay display(out_, terminal(80), clock()); }
    EXPECT_EQ(out_.str(), "");
}

TEST_F(Display, GivesTheLineAwayAndTakesItBack) {
    ProgressDisplay display(out_, terminal(80), clock());
    display.update(kHalf);
    out_.str("");
    display.clear();
    EXPECT_EQ(out_.str(), "\r\x1b[K");
    out_.str("");
    display.update(kHalf);
    EXPECT_EQ(out_.str().front(), '\r');
    display.clear();
    display.clear();
}

TEST_F(Display, FollowsTheWidthOfTheWindow) {
    int columns = 100;
    ProgressDisplay display(out_, {true, false, false, [&columns] { return columns; }}, clock());
    display.update(kHalf);
    columns = 20;
    now_ += milliseconds(100);
    out_.str("");
    display.update(kHalf);
    EXPECT_EQ(out_.str(), "\r[=====.....]   50 %\x1b[K");
}

TEST(ProgressLine, NeverIsWiderThanAsked) {
    for (int columns = 0; columns < 200; ++columns) {
        EXPECT_LE(static_cast<int>(progress_line(kHalf, columns, false, false).size()), columns);
    }
    EXPECT_EQ(progress_line(kHalf, 4, false, false), "");
    EXPECT_EQ(progress_line(kHalf, 5, false, false), " 50 %");
    EXPECT_EQ(progress_line(kHalf, 12, false, false), " 50 %");
    // The usual width, less the last column.
    EXPECT_EQ(progress_line(kHalf, 79, false, false), "[==...]   50 %  1234 samples  5678 probes  ball 0.521 of 0.25 mm  37 open edges");
    EXPECT_EQ(progress_line(kHalf, 30, false, false), "[===....]   50 %  1234 samples");
}

TEST(ProgressLine, DrawsEighthsWhereItCan) {
    Progress progress = kHalf;
    progress.fraction_done = 1.0;
    EXPECT_EQ(progress_line(progress, 32, true, false), "███████████  100 %  1234 samples");
    progress.fraction_done = 0.5;
    EXPECT_EQ(progress_line(progress, 32, true, false), "█████▌        50 %  1234 samples");
    EXPECT_EQ(progress_line(progress, 32, true, true), "\x1b[36m█████▌\x1b[0m        50 %  1234 samples");
    progress.fraction_done = 0.0;
    EXPECT_EQ(progress_line(progress, 32, true, false), "               0 %  1234 samples");
}

TEST(ProgressLine, SurvivesFractionsThatAreNone) {
    Progress progress = kHalf;
    for (const double fraction : {std::numeric_limits<double>::quiet_NaN(), -1.0, -std::numeric_limits<double>::infinity()}) {
        progress.fraction_done = fraction;
        EXPECT_EQ(progress_line(progress, 32, false, false), "[.........]    0 %  1234 samples");
    }
    progress.fraction_done = std::numeric_limits<double>::infinity();
    EXPECT_EQ(progress_line(progress, 32, false, false), "[=========]  100 %  1234 samples");
    progress.fraction_done = 0.9999;
    EXPECT_EQ(progress_line(progress, 32, false, false), "[========.]   99 %  1234 samples");
}

TEST(ProgressDisplayCost, AMillionUpdatesTakeNoTime) {
    std::ostringstream out;
    ProgressDisplay display(out, {});
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
}  // namespace palpate
