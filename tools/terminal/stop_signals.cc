#include "tools/terminal/stop_signals.h"

#include <ctime>

namespace palpate {
namespace {

// How long the end of the program may have to wait for the waiting thread.
constexpr timespec kWakeUp{0, 50'000'000};

}  // namespace

StopSignals::StopSignals() {
    sigemptyset(&signals_);
    for (const int signal : {SIGINT, SIGTERM, SIGQUIT, SIGTSTP, SIGCONT}) sigaddset(&signals_, signal);
    struct sigaction on_hangup {};
    sigaction(SIGHUP, nullptr, &on_hangup);
    if (on_hangup.sa_handler != SIG_IGN) sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
    waiter_ = std::jthread([this](const std::stop_token& ended) {
        while (!ended.stop_requested()) {
            const int signal = sigtimedwait(&signals_, nullptr, &kWakeUp);
            if (signal <= 0) continue;
            if (signal == SIGTSTP) {
                asked_.request_pause();
            } else if (signal == SIGCONT) {
                asked_.end_pause();
            } else {
                asked_.request_stop();
            }
        }
    });
}

StopSignals::~StopSignals() { release(); }

void StopSignals::pause() {
    if (!asked_.token().pause_requested() || asked_.token().stop_requested()) return;
    asked_.end_pause();
    // As the signal does to any process: without a shell above that could bring it back, nothing.
    sigset_t suspend{};
    sigemptyset(&suspend);
    sigaddset(&suspend, SIGTSTP);
    pthread_sigmask(SIG_UNBLOCK, &suspend, nullptr);
    raise(SIGTSTP);
    pthread_sigmask(SIG_BLOCK, &suspend, nullptr);
}

void StopSignals::release() {
    if (!waiter_.joinable()) return;
    pause();
    waiter_.request_stop();
    waiter_.join();
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace palpate
