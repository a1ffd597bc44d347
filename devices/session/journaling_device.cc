#include "devices/session/journaling_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>

#include "devices/errors.h"
#include "devices/session/internal/journal_words.h"

namespace palpate {
namespace {

std::string describe(const Point& target, Pace pace) {
    return fmt::format("{} to ({:.17g}, {:.17g}, {:.17g})", word_of(pace), target.x(), target.y(), target.z());
}

bool same_bits(const Point& a, const Point& b) {
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
    return std::ranges::equal(a, b, {}, bits, bits);
}

}  // namespace

void JournalingDevice::go_live(const Point& target) {
    if (device_ != nullptr || writer_ == nullptr || !is_used_up()) return;
    went_live_ = true;
    device_ = &go_live_(target);
}

MoveResult JournalingDevice::answer(const Point& target, Pace pace, const std::optional<DatumMark>& mark) {
    if (next_ < record_.moves.size()) {
        const JournalMove& known = replay(target, pace, mark);
        rest_ = known.rest;
        return known.result;
    }
    if (device_ == nullptr && writer_ == nullptr) {
        throw ReplayMismatch(
            fmt::format("the journal ends after line {}, but the planner asks on ({}): the session was not finished; resume it",
                        record_.lines, describe(target, pace)));
    }
    go_live(target);
    assert(device_ != nullptr);
    if (has_gap_) throw JournalError("an answer could not be recorded, and nothing moves after that: resume the session");
    JournalMove move{target, pace, device_->guarded_move(target, pace), device_->position()};
    move.datum = mark;
    has_gap_ = true;
    writer_->append(move);
    has_gap_ = false;
    return std::move(move.result);
}

const JournalMove& JournalingDevice::replay(const Point& target, Pace pace, const std::optional<DatumMark>& mark) {
    if (pause_ && stop_.pause_requested()) pause_();
    if (stop_.stop_requested()) throw Stopped("stopped while the journal was replayed; nothing has moved");
    const JournalMove& known = record_.moves[next_];
    if (!same_bits(known.target, target) || known.pace != pace || known.datum != mark) {
        throw ReplayMismatch(
            fmt::format("line {} of the journal answers {}, but the planner asks for {}: the journal was written by another version of "
                        "Palpate, or for another configuration",
                        known.line + 1, describe(known.target, known.pace), describe(target, pace)));
    }
    ++next_;
    return known;
}

void JournalingDevice::stop() {
    if (device_ != nullptr) device_->stop();
}

void JournalingDevice::withdraw(std::size_t count) {
    assert(writer_ != nullptr && device_ == nullptr && count > 0 && count <= next_ && next_ == record_.moves.size());
    writer_->append_withdrawn(record_.moves[next_ - count].line);
}

}  // namespace palpate
