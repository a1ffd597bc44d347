#include "tools/stop_signals.h"

#include <ctime>

namespace palpate {
namespace {

// How long the end of the program may have to wait for the waiting thread.
constexpr timespec kPoll{0, 50'000'000};

}  // namespace

StopSignals::StopSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    struct sigaction on_hangup {};
    sigaction(SIGHUP, nullptr, &on_hangup);
    if (on_hangup.sa_handler != SIG_IGN) sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
    waiter_ = std::jthread([this](const std::stop_token& ended) {
        while (!ended.stop_requested()) {
            if (sigtimedwait(&signals_, nullptr, &kPoll) > 0) stop_.request_stop();
        }
    });
}

StopSignals::~StopSignals() {
    waiter_.request_stop();
    waiter_.join();
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace palpate
