// Ctrl-C, SIGTERM and a terminal that is gone (SIGHUP) as a stop request: what moves is stopped in an orderly way instead of being left to
// itself.
#pragma once

#include <csignal>
#include <stop_token>
#include <thread>

namespace palpate {

// While it lives these signals no longer end the process. A SIGHUP that is ignored (nohup) stays so. To be made before any other thread,
// which inherits that.
class StopSignals {
public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;
    StopSignals(StopSignals&&) = delete;
    StopSignals& operator=(StopSignals&&) = delete;

    [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }

private:
    sigset_t signals_{};
    sigset_t before_{};
    std::stop_source stop_;
    std::jthread waiter_;
};

}  // namespace palpate
