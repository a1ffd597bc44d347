// Ctrl-C, Ctrl-\, SIGTERM and a terminal that is gone (SIGHUP) as a request to stop, Ctrl-Z as one to pause: what moves comes to rest in an
// orderly way instead of being left to itself.
#pragma once

#include <csignal>
#include <thread>

#include "devices/stop_request.h"

namespace palpate {

// While it lives these signals no longer end or stop the process. A SIGHUP that is ignored (nohup) stays so. To be made before any other
// thread, which inherits that.
class StopSignals {
public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;
    StopSignals(StopSignals&&) = delete;
    StopSignals& operator=(StopSignals&&) = delete;

    [[nodiscard]] StopToken token() const { return asked_.token(); }
    // Everything rests: if a pause was asked for, the process stops here, as the shell expects of Ctrl-Z, and goes on with SIGCONT.
    void pause();
    // Nothing moves any more, and nobody has to ask: from here on these signals do what they do to any process.
    void release();

private:
    sigset_t signals_{};
    sigset_t before_{};
    StopSource asked_;
    std::jthread waiter_;
};

}  // namespace palpate
