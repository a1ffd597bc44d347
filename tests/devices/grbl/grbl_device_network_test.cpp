// The driver on a network: every byte comes late, both ways.
#include <deque>

#include "tests/devices/grbl/grbl_support.h"
#include "tests/random.h"

namespace palpate::grbl_device_network_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Kind = VirtualFault::Kind;
using When = VirtualFault::When;
using Outcome = MoveResult::Outcome;

// In order, and each byte at its own time.
class DelayedStream final : public ByteStream {
public:
    using Delay = std::function<std::chrono::nanoseconds()>;
    // `wire` must outlive it. `delay`: one way.
    DelayedStream(LoopbackStream& wire, Delay delay) : wire_(wire), delay_(std::move(delay)) {}

    [[nodiscard]] std::string read(std::chrono::milliseconds timeout) override {
        const auto until = wire_.now() + timeout;
        do {
            for (const std::string& bytes : to_machine_.take(wire_.now())) wire_.write(bytes);
            if (std::string bytes = wire_.read(kSlice); !bytes.empty()) to_host_.add(wire_.now() + delay_(), std::move(bytes));
            std::string come;
            for (const std::string& bytes : to_host_.take(wire_.now())) come += bytes;
            questions_ -= std::ranges::count(come, '<');
            if (!come.empty()) return come;
        } while (wire_.now() < until);
        return {};
    }
    void write(std::string_view bytes) override {
        questions_ += std::ranges::count(bytes, '?');
        most_questions_ = std::max(most_questions_, questions_);
        to_machine_.add(wire_.now() + delay_(), std::string(bytes));
    }
    [[nodiscard]] std::string name() const override { return "tcp://mill:23"; }
    // For a status, under way at one time.
    [[nodiscard]] std::ptrdiff_t most_questions() const { return most_questions_; }

private:
    class Way {
    public:
        void add(std::chrono::nanoseconds due, std::string bytes) {
            last_ = std::max(last_, due);
            under_way_.push_back({last_, std::move(bytes)});
        }
        [[nodiscard]] std::vector<std::string> take(std::chrono::nanoseconds now) {
            std::vector<std::string> come;
            for (; !under_way_.empty() && under_way_.front().due <= now; under_way_.pop_front()) {
                come.push_back(std::move(under_way_.front().bytes));
            }
            return come;
        }

    private:
        struct Piece {
            std::chrono::nanoseconds due;
            std::string bytes;
        };
        std::deque<Piece> under_way_;
        std::chrono::nanoseconds last_{0};
    };

    static constexpr auto kSlice = 1ms;
    LoopbackStream& wire_;
    Delay delay_;
    Way to_machine_;
    Way to_host_;
    std::ptrdiff_t questions_ = 0;
    std::ptrdiff_t most_questions_ = 0;
};

class GrblDeviceNetwork : public GrblDeviceTest {
protected:
    static constexpr std::uint64_t kSeed = 4;
    inline static const Point kTouch{kRadius, 0, 0};

    // ms, one way: from the least to the most.
    void join_network(double least, double most) {
        power_on();
        delayed_ = std::make_unique<DelayedStream>(*clock, [this, least, most] {
            return std::chrono::duration_cast<std::chrono::nanoseconds>(
                std::chrono::duration<double, std::milli>(random_.uniform(least, most)));
        });
        stream = std::make_unique<DamagedStream>(*delayed_);
        device_options.delay = std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double, std::milli>(2 * most));
    }
    MoveResult probe() { return device->guarded_move({0, 0, 0}, Pace::probe); }

    Random random_{kSeed};
    std::unique_ptr<DelayedStream> delayed_;
};

INSTANTIATE_TEST_SUITE_P(Dialects, GrblDeviceNetwork, testing::Values(GrblDialect::grbl, GrblDialect::grblhal), dialect_name);

TEST_P(GrblDeviceNetwork, AnswersThatComeLateAreWaitedFor) {
    for (const auto& [least, most] : {std::pair(2.0, 2.0), std::pair(25.0, 100.0), std::pair(250.0, 250.0), std::pair(0.0, 400.0)}) {
        SCOPED_TRACE(most);
        join_network(least, most);
        ready();
        for (int k = 0; k < 10; ++k) {
            SCOPED_TRACE(k);
            const Vector direction = random_.direction();
            const Point from = 15 * direction;
            // Around the ball, from where it was.
            const Point corner = device->position().norm() > 0 ? Point(device->position().normalized() * 30) : Point(30, 0, 0);
            ASSERT_EQ(device->guarded_move(corner, Pace::travel).outcome, Outcome::reached);
            const Vector across = corner.cross(direction).normalized() * 30;
            ASSERT_EQ(device->guarded_move(across, Pace::travel).outcome, Outcome::reached);
            ASSERT_EQ(device->guarded_move(30 * direction, Pace::travel).outcome, Outcome::reached);
            ASSERT_EQ(device->guarded_move(from, Pace::travel).outcome, Outcome::reached);
            const MoveResult touch = device->guarded_move({0, 0, 0}, Pace::probe);
            ASSERT_EQ(touch.outcome, Outcome::contact);
            EXPECT_NEAR(touch.position.norm(), kRadius, 3 * kMicrometre);
            EXPECT_TRUE(touch.events.empty()) << "nothing was sent twice";
        }
        EXPECT_EQ(delayed_->most_questions(), 1);
    }
}

TEST_P(GrblDeviceNetwork, WhatTheControllerDroppedIsAskedForAgain) {
    // As FluidNC's queue does when it is full: the answer is lost, its `ok` comes.
    for (const double bytes : {1.0, 10.0, 24.0}) {
        SCOPED_TRACE(bytes);
        options.faults = {{Kind::lose_output, When::contact, 1, bytes, {}}};
        join_network(20, 80);
        ready();
        expect_touch(probe(), kTouch);
    }
}

TEST_P(GrblDeviceNetwork, AStopEndsTheMoveInTime) {
    join_network(100, 250);
    ready();
    const double begun = seconds();
    stream->before_read = [&] {
        if (seconds() >= begun + 1) stop.request_stop();
    };
    EXPECT_THROW((void)device->guarded_move({20, 20, 0}, Pace::touch), Stopped);
    EXPECT_LT(seconds(), begun + 1 + 15) << "as far as it had come goes back at the feed of probes";
    EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
}

TEST_P(GrblDeviceNetwork, AStrangersTouchIsNotOurs) {
    // On FluidNC every client hears every [PRB].
    options.faults = {{Kind::stale_line, When::probe, 1, 0, "[PRB:15.000,-2.000,3.000:1]"}};
    join_network(50, 50);
    ready();
    expect_touch(probe(), kTouch);
}

TEST_P(GrblDeviceNetwork, AStrangersResetIsSeen) {
    join_network(50, 50);
    ready();
    const double begun = seconds();
    bool is_reset = false;
    stream->before_read = [&] {
        if (is_reset || seconds() < begun + 0.5) return;
        is_reset = true;
        grbl->receive("\x18");
    };
    EXPECT_THROW((void)device->guarded_move({20, 20, 0}, Pace::touch), DeviceError);
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::touch), PositionLost) << "nothing moves any more";
}

}  // namespace
}  // namespace palpate::grbl_device_network_test
