#include "devices/session/journaling_device.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>
#include <sstream>

#include "devices/errors.h"
#include "devices/session/internal/journal_words.h"

namespace palpate {
namespace {

std::string describe(const Point& target, Pace pace) {
    std::ostringstream text;
    text.precision(17);
    text << word_of(pace) << " to (" << target.x() << ", " << target.y() << ", " << target.z() << ')';
    return text.str();
}

bool same_bits(const Point& a, const Point& b) {
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
    return std::ranges::equal(a, b, {}, bits, bits);
}

}  // namespace

MoveResult JournalingDevice::guarded_move(const Point& target, Pace pace) {
    if (next_ < record_.moves.size()) {
        const JournalMove& known = replay(target, pace);
        rest_ = known.rest;
        return known.result;
    }
    if (device_ == nullptr) {
        if (writer_ == nullptr) {
            throw ReplayMismatch("the journal ends after line " + std::to_string(record_.lines) + ", but the planner asks on (" +
                                 describe(target, pace) + "): the session was not finished; resume it");
        }
        went_live_ = true;
        device_ = &go_live_(target);
    }
    if (has_gap_) throw JournalError("an answer could not be recorded, and nothing moves after that: resume the session");
    JournalMove move{target, pace, device_->guarded_move(target, pace), device_->position()};
    has_gap_ = true;
    writer_->append(move);
    has_gap_ = false;
    return std::move(move.result);
}

const JournalMove& JournalingDevice::replay(const Point& target, Pace pace) {
    if (stop_.stop_requested()) throw Stopped("stopped while the journal was replayed; nothing has moved");
    const JournalMove& known = record_.moves[next_];
    if (!same_bits(known.target, target) || known.pace != pace) {
        throw ReplayMismatch("line " + std::to_string(known.line + 1) + " of the journal answers " + describe(known.target, known.pace) +
                             ", but the planner asks for " + describe(target, pace) +
                             ": the journal was written by another version of Palpate, or for another configuration");
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
