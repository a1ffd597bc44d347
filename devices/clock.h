// The seam between logic and time: drivers never look at a clock of their own.
#pragma once

#include <chrono>
#include <thread>

#include "planner/machine_time.h"

namespace palpate {

[[nodiscard]] constexpr std::chrono::nanoseconds to_nanoseconds(Seconds time) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(time);
}

class Clock {
public:
    virtual ~Clock() = default;

    // Since any fixed moment; never falls.
    [[nodiscard]] virtual std::chrono::nanoseconds now() const = 0;
    virtual void sleep(std::chrono::nanoseconds duration) = 0;
};

class SteadyClock final : public Clock {
public:
    [[nodiscard]] std::chrono::nanoseconds now() const override { return std::chrono::steady_clock::now().time_since_epoch(); }
    void sleep(std::chrono::nanoseconds duration) override { std::this_thread::sleep_for(duration); }
};

}  // namespace palpate
