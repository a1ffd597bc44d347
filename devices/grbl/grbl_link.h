// Lines to and from a GRBL-family controller: framing, one command at a time, and a memory for diagnosis.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "devices/byte_stream.h"
#include "devices/clock.h"
#include "devices/grbl/grbl_message.h"

namespace palpate::grbl {

// Real-time bytes: handled at once, without an answer of their own but that of '?'.
inline constexpr char kAskStatus = '?';
inline constexpr char kFeedHold = '!';
inline constexpr char kReset = '\x18';
inline constexpr char kFeedOverrideTo100 = '\x90';

class Link {
public:
    // Both must outlive it.
    Link(ByteStream& stream, Clock& clock) : stream_(stream), clock_(clock) {}

    void send(const std::string& line);
    void send_realtime(char byte);
    // The next line, waiting for it until then; nothing if none came, or if lines have come without end since then.
    [[nodiscard]] std::optional<Message> receive(std::chrono::nanoseconds until);
    // Status reports that were asked for and have not come, as far as that can be known.
    [[nodiscard]] int unanswered() const { return unanswered_; }
    void forget_unanswered() { unanswered_ = 0; }
    // Throws away all that has come, and all that comes until the line is quiet for that long, or for a second.
    void drain(std::chrono::milliseconds quiet);

    // How many decimals coordinates have from now on; a line with others is damaged.
    void expect_decimals(std::size_t decimals) { decimals_ = decimals; }

    [[nodiscard]] std::chrono::nanoseconds now() const { return clock_.now(); }
    [[nodiscard]] std::string name() const { return stream_.name(); }
    // The last lines both ways, oldest first, for a message: " > G38.3…", " < ok".
    [[nodiscard]] std::string history() const;

private:
    void remember(char direction, std::string_view line);

    ByteStream& stream_;
    Clock& clock_;
    LineBuffer buffer_;
    int unanswered_ = 0;
    std::deque<std::string> history_;
    std::optional<std::size_t> decimals_;
};

}  // namespace palpate::grbl
