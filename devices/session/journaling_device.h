// Answers from a journal as long as it has answers, then from a device, whose answers go into the journal first.
#pragma once

#include <cstddef>
#include <functional>

#include "devices/session/journal.h"
#include "devices/stop_request.h"

namespace palpate {

// The planner asks something else than it did when the journal was written: another version of Palpate, or a changed configuration.
class ReplayMismatch : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

class JournalingDevice final : public ProbeDevice {
public:
    // What answers when the record is used up: called once, before the first such move, which goes to `target`. It brings the
    // machine to where the record ends.
    using GoLive = std::function<ProbeDevice&(const Point& target)>;

    // `writer` is where new answers go; nothing: there is no machine, and the record has to suffice. It must outlive the device. `stop`
    // ends a replay, or asks for a `pause` of it; what is live hears it by itself.
    JournalingDevice(Journal record, JournalWriter* writer, GoLive go_live, StopToken stop = {}, std::function<void()> pause = {})
        : record_(std::move(record)),
          writer_(writer),
          go_live_(std::move(go_live)),
          stop_(std::move(stop)),
          pause_(std::move(pause)),
          rest_(record_.header.start) {}

    [[nodiscard]] Point position() const override { return device_ != nullptr ? device_->position() : rest_; }
    // Throws ReplayMismatch, Stopped, JournalError (the answer is lost then, not the journal), and what the device throws.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override { return answer(target, pace, std::nullopt); }
    // The same, as part of a visit to the datum.
    [[nodiscard]] MoveResult datum_move(const Point& target, Pace pace, const DatumMark& mark) { return answer(target, pace, mark); }
    void stop() override;

    [[nodiscard]] const Journal& record() const { return record_; }
    // Whether the record was used up and a device asked for, even if that failed.
    [[nodiscard]] bool is_live() const { return went_live_; }
    // Whether the next answer is not in the record any more.
    [[nodiscard]] bool is_used_up() const { return next_ == record_.moves.size(); }
    // The answers that were given from the record.
    [[nodiscard]] std::size_t replayed() const { return next_; }
    // Asks for the device now, if the record is used up: the next move goes to `target`. Nothing happens where there is none.
    void go_live(const Point& target);
    // So many last answers do not count: a resumed session asks again. REQUIRES: writer, not live, `count` answers were replayed.
    void withdraw(std::size_t count);

private:
    MoveResult answer(const Point& target, Pace pace, const std::optional<DatumMark>& mark);
    const JournalMove& replay(const Point& target, Pace pace, const std::optional<DatumMark>& mark);

    Journal record_;
    JournalWriter* writer_;
    GoLive go_live_;
    StopToken stop_;
    std::function<void()> pause_;
    ProbeDevice* device_ = nullptr;
    std::size_t next_ = 0;
    bool went_live_ = false;
    bool has_gap_ = false;  // the device moved, and its answer is not in the journal
    Point rest_;
};

}  // namespace palpate
