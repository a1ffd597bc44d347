// What whoever runs a session asks of what moves, from any thread: to stop for good, or to rest for a while.
//
// Unlike with a std::stop_token what was asked for can end.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

namespace palpate {

class StopToken {
public:
    StopToken() = default;  // never asks for anything

    [[nodiscard]] bool stop_requested() const { return asked_ && asked_->stop; }
    [[nodiscard]] bool pause_requested() const { return asked_ && asked_->pause; }
    // Whether what moves has to come to rest: for good, or until the pause has ended.
    [[nodiscard]] bool halt_requested() const { return stop_requested() || pause_requested(); }

private:
    friend class StopSource;
    struct Asked {
        std::atomic<bool> stop = false;
        std::atomic<bool> pause = false;
    };
    explicit StopToken(std::shared_ptr<Asked> asked) : asked_(std::move(asked)) {}

    std::shared_ptr<Asked> asked_;
};

class StopSource {
public:
    [[nodiscard]] StopToken token() const { return StopToken(asked_); }
    void request_stop() { asked_->stop = true; }
    void request_pause() { asked_->pause = true; }
    void end_pause() { asked_->pause = false; }

private:
    std::shared_ptr<StopToken::Asked> asked_ = std::make_shared<StopToken::Asked>();
};

}  // namespace palpate
