// Numbered questions to a program that drives a machine, and its answers in order.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "devices/byte_stream.h"
#include "devices/clock.h"
#include "devices/external/internal/external_message.h"

namespace palpate::external {

// Every call throws ConnectionLost, and BadAnswer on what is malformed or answers what was not asked.
class Talk {
public:
    // Both must outlive it. `answer_time`: what an answer may take that waits for no motion.
    Talk(ByteStream& stream, Clock& clock, std::chrono::nanoseconds answer_time)
        : stream_(stream), clock_(clock), answer_time_(answer_time) {}

    // Asks and waits. Throws DeviceTimeout, and DeviceRefused if the answer is a refusal.
    [[nodiscard]] Line ask(std::string_view what) {
        return wait_for(send([&](std::uint64_t id) { return external::ask(id, what); }), what);
    }
    // A program that has just been started takes `start_time`.
    [[nodiscard]] Line ask_hello(double silence_s, std::chrono::nanoseconds start_time) {
        return wait_for(send([&](std::uint64_t id) { return external::ask_hello(id, silence_s); }), "hello", start_time);
    }
    // The number of the question. `text`: given that number.
    [[nodiscard]] std::uint64_t send(const std::function<std::string(std::uint64_t)>& text);
    void say_alive();
    // The next line by then, or nothing; whose it is, is for the caller.
    [[nodiscard]] std::optional<Line> receive(std::chrono::nanoseconds until);
    // The answer to that question. Signs of life are passed over; an answer to any other is a fault.
    [[nodiscard]] Line wait_for(std::uint64_t id, std::string_view what, std::chrono::nanoseconds patience = {});
    // Throws BadAnswer: what was said cannot be true.
    [[noreturn]] void refuse(const std::string& what) const;
    [[noreturn]] void fail_silent(const std::string& awaited) const;

    [[nodiscard]] std::chrono::nanoseconds now() const { return clock_.now(); }
    [[nodiscard]] std::chrono::nanoseconds answer_time() const { return answer_time_; }
    [[nodiscard]] std::string name() const { return stream_.name(); }
    [[nodiscard]] std::string history() const;

private:
    void remember(char direction, std::string_view line);

    ByteStream& stream_;
    Clock& clock_;
    const std::chrono::nanoseconds answer_time_;
    std::uint64_t last_ = 0;
    std::string bytes_;
    std::deque<std::string> history_;
};

}  // namespace palpate::external
