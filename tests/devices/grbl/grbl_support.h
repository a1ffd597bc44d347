// The GRBL driver on a virtual machine in virtual time: a ball of radius 10 mm around the driver's origin, the tool at (20, 0, 0).
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>

#include "devices/errors.h"
#include "devices/grbl/grbl_device.h"
#include "devices/stop_request.h"
#include "sim/machines/grbl/loopback_stream.h"
#include "tests/devices/message_of.h"
#include "tests/sim/machines/grbl/virtual_grbl_support.h"

namespace palpate {

// A wire that loses what it is told to lose, and lets a test act in mid-move.
class DamagedStream final : public ByteStream {
public:
    // `stream` must outlive it.
    explicit DamagedStream(ByteStream& stream) : stream_(stream) {}

    [[nodiscard]] std::string read(std::chrono::milliseconds timeout) override {
        if (before_read) before_read();
        // Short waits, so that the test sees the machine often.
        return to_host.pass(stream_.read(std::min(timeout, kSlice)));
    }
    void write(std::string_view bytes) override { stream_.write(to_machine.pass(bytes)); }
    [[nodiscard]] std::string name() const override { return stream_.name(); }

    // Of the bytes that pass from now on, those from the `first`-th (from 0) get lost.
    class Loss {
    public:
        void lose(std::size_t first, std::size_t count) {
            first_ = first;
            last_ = first + count;
        }
        [[nodiscard]] std::string pass(std::string_view bytes) {
            std::string rest;
            for (const char& c : bytes) {
                if (first_ > 0 || last_ == 0) rest += c;
                first_ -= first_ > 0 ? 1 : 0;
                last_ -= last_ > 0 ? 1 : 0;
            }
            return rest;
        }

    private:
        std::size_t first_ = 0;  // bytes to pass before that
        std::size_t last_ = 0;   // bytes until the loss is over
    };
    Loss to_host;
    Loss to_machine;
    std::function<void()> before_read;

private:
    static constexpr std::chrono::milliseconds kSlice{5};
    ByteStream& stream_;
};

class GrblDeviceTest : public EveryGrblTest {
protected:
    static constexpr double kMicrometre = 0.001;  // mm
    static constexpr double kRadius = 10.0;       // mm
    inline static const Point kOrigin{1, -2, 3};

    GrblDeviceTest() {
        tool_options.origin = kOrigin;
        tool_options.start = Point(20, 0, 0) + kOrigin;
        device_options.origin = kOrigin;
    }
    // What must never happen, whatever the test does.
    void TearDown() override {
        if (!tool) return;
        EXPECT_EQ(tool->audit().unguarded_moves, 0U);
        EXPECT_EQ(tool->audit().unsafe_moves, allowed_unsafe_moves);
        EXPECT_EQ(tool->audit().outside_limits, 0U);
    }

    // Its banner waits for the driver.
    void power_on() {
        device.reset();
        tool = std::make_unique<VirtualTool>(ball, tool_options);
        grbl = std::make_unique<VirtualGrbl>(*tool, options);
        clock = std::make_unique<LoopbackStream>(*grbl);
        stream = std::make_unique<DamagedStream>(*clock);
    }
    GrblDevice& connect() {
        if (!grbl) power_on();
        device.reset();
        device = std::make_unique<GrblDevice>(*stream, *clock, device_options, stop.token());
        return *device;
    }
    GrblDevice& ready() {
        connect().make_ready();
        return *device;
    }
    // What the machine says to another program that shares the wire, unheard by the driver.
    Lines behind_its_back(const std::string& line) {
        grbl->receive(line);
        return rest();
    }
    // Once the tool has come within `x` of the plane x = 0.
    void once_within(double x, std::function<void()> act) {
        stream->before_read = [this, x, act = std::move(act)] {
            if (tool_at().x() >= x) return;
            const auto call = std::exchange(stream->before_read, nullptr);
            act();
        };
    }
    void expect_touch(const MoveResult& result, const Point& at) const {
        EXPECT_EQ(result.outcome, MoveResult::Outcome::contact);
        EXPECT_NEAR((result.position - at).norm(), 0, 2 * kMicrometre) << result.position.transpose();
    }
    // Where the tool is in truth, in the driver's coordinates.
    [[nodiscard]] Point tool_at() const { return tool->true_position() - kOrigin; }
    [[nodiscard]] double seconds() const { return grbl->now().count(); }

    GrblOptions device_options;
    StopSource stop;
    std::uint64_t allowed_unsafe_moves = 0;
    std::unique_ptr<LoopbackStream> clock;
    std::unique_ptr<DamagedStream> stream;
    std::unique_ptr<GrblDevice> device;
};

}  // namespace palpate
