#include "tools/terminal/console.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <sstream>
#include <thread>

namespace palpate::console_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class Piped : public ::testing::Test {
protected:
    Piped() {
        std::array<int, 2> ends{};
        if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
        from_ = ends[0];
        to_ = ends[1];
    }
    ~Piped() override {
        if (from_ >= 0) close(from_);
        close(to_);
    }
    // What waits in the pipe, and what comes within `patience` after it.
    std::string read_all(std::chrono::milliseconds patience = 50ms) {
        std::string text;
        pollfd waiting{from_, POLLIN, 0};
        while (poll(&waiting, 1, static_cast<int>(patience.count())) > 0) {
            std::array<char, 4096> bytes{};
            const ssize_t count = read(from_, bytes.data(), bytes.size());
            if (count <= 0) break;
            text.append(bytes.data(), static_cast<std::size_t>(count));
        }
        return text;
    }

    int from_ = -1;
    int to_ = -1;
};

TEST_F(Piped, WhatIsWrittenArrivesInOrder) {
    Console console(to_);
    std::string expected;
    for (int k = 0; k < 200; ++k) {
        const std::string line = "line " + std::to_string(k) + '\n';
        console.write(line);
        expected += line;
    }
    EXPECT_TRUE(console.flush(1s));
    EXPECT_EQ(read_all(), expected);
}

TEST_F(Piped, APipeThatNobodyReadsLosesLinesNotTime) {
    const std::string line = std::string(99, 'x') + '\n';
    const auto begin = Clock::now();
    {
        Console console(to_);
        for (int k = 0; k < 5000; ++k) console.write(line);
        EXPECT_LT(Clock::now() - begin, 500ms);
        EXPECT_FALSE(console.flush(10ms));
        // Somebody reads again: whole lines, and how many are missing.
        std::string text = read_all();
        console.write("the last\n");
        text += read_all();
        EXPECT_TRUE(text.ends_with("the last\n"));
        int lost = 0;
        int kept = -1;  // the last
        std::istringstream lines(text);
        for (std::string one; std::getline(lines, one);) {
            if (one.starts_with("palpate: ")) {
                lost += std::stoi(one.substr(9));
            } else {
                ++kept;
            }
        }
        EXPECT_EQ(kept + lost, 5000);
        EXPECT_GT(lost, 1000);
        EXPECT_EQ(text.find_first_not_of('x'), 99U);
        for (int k = 0; k < 5000; ++k) console.write(line);
    }
    EXPECT_LT(Clock::now() - begin, 3s) << "nor does the end wait";
}

TEST_F(Piped, AReaderThatIsGoneIsNoTrouble) {
    signal(SIGPIPE, SIG_IGN);
    Console console(to_);
    close(from_);
    from_ = -1;
    for (int k = 0; k < 1000 && !console.is_dead(); ++k) {
        console.write("nobody hears that\n");
        std::this_thread::sleep_for(1ms);
    }
    EXPECT_TRUE(console.is_dead());
    EXPECT_FALSE(console.flush(10s));
}

// What a terminal shows: a carriage return goes to the begin of the line, ESC [ K erases what follows.
std::vector<std::string> screen_of(const std::string& text) {
    std::vector<std::string> lines(1);
    std::size_t column = 0;
    for (std::size_t k = 0; k < text.size(); ++k) {
        if (text[k] == '\n') {
            lines.emplace_back();
            column = 0;
        } else if (text[k] == '\r') {
            column = 0;
        } else if (text.substr(k, 3) == "\x1b[K") {
            lines.back().resize(column);
            k += 2;
        } else {
            lines.back().resize(std::max(lines.back().size(), column + 1), ' ');
            lines.back()[column++] = text[k];
        }
    }
    return lines;
}

TEST_F(Piped, TextNeverMixesWithTheStatus) {
    Console console(to_);
    std::string seen;
    std::vector<std::string> expected;
    for (int k = 0; k < 50; ++k) {
        console.set_status("a long status that would be seen below short lines " + std::to_string(k));
        if (k % 3 == 0) {
            EXPECT_TRUE(console.flush(1s));
        }
        console.write("line " + std::to_string(k) + '\n');
        expected.push_back("line " + std::to_string(k));
        if (k % 2 == 0) {
            EXPECT_TRUE(console.flush(1s));
        }
    }
    EXPECT_TRUE(console.flush(1s));
    seen += read_all();
    expected.emplace_back("a long status that would be seen below short lines 49");
    EXPECT_EQ(screen_of(seen), expected);
    console.set_status({});
    EXPECT_TRUE(console.flush(1s));
    seen += read_all();
    expected.back() = "";
    EXPECT_EQ(screen_of(seen), expected);
}

TEST_F(Piped, AStreamHandsOverWholeLines) {
    Console console(to_);
    ConsoleStream stream(console);
    stream << "one " << 1 << '\n' << "two";
    EXPECT_TRUE(console.flush(1s));
    EXPECT_EQ(read_all(), "one 1\n");
    stream << std::flush;
    EXPECT_TRUE(console.flush(1s));
    EXPECT_EQ(read_all(), "two");
}

}  // namespace
}  // namespace palpate::console_test
