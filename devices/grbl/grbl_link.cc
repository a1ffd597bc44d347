#include "devices/grbl/grbl_link.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace palpate::grbl {
namespace {

// A controller that reports by itself may never be quiet; nobody waits for that longer.
constexpr auto kFlood = std::chrono::seconds(1);
constexpr std::size_t kRemembered = 12;  // lines: a probing move with its reports

std::chrono::milliseconds rounded_up(std::chrono::nanoseconds time) {
    return std::chrono::ceil<std::chrono::milliseconds>(std::max(time, std::chrono::nanoseconds(0)));
}

}  // namespace

void Link::remember(char direction, std::string_view line) {
    // Polls would push out what matters.
    std::string entry = fmt::format("\n    {} {}", direction, line);
    if (!history_.empty() && line == "?" && history_.back() == entry) return;
    history_.push_back(std::move(entry));
    if (history_.size() > kRemembered) history_.pop_front();
}

void Link::send(const std::string& line) {
    remember('>', line);
    stream_.write(line + '\n');
}

void Link::send_realtime(char byte) {
    remember('>', byte == kReset ? "Ctrl-X" : byte == kFeedOverrideTo100 ? "0x90 (feed override to 100 %)" : std::string(1, byte));
    if (byte == kAskStatus) ++unanswered_;
    stream_.write({&byte, 1});
}

std::optional<Message> Link::receive(std::chrono::nanoseconds until) {
    const auto give_up_at = std::max(until, clock_.now()) + kFlood;
    while (true) {
        if (const auto line = buffer_.next()) {
            remember('<', *line);
            Message message = parse(*line, decimals_);
            if (std::holds_alternative<Status>(message)) unanswered_ = std::max(unanswered_ - 1, 0);
            return message;
        }
        // Also when it is late: what waits was said in time, while this process was stopped perhaps.
        const auto now = clock_.now();
        const std::string bytes = stream_.read(rounded_up(until - now));
        buffer_.append(bytes);
        if (bytes.empty() && now >= until) return std::nullopt;
        if (!bytes.empty() && now > give_up_at) break;
    }
    return std::nullopt;
}

void Link::drain(std::chrono::milliseconds quiet) {
    const auto until = now() + kFlood;
    while (now() < until && receive(now() + quiet)) {
    }
    unanswered_ = 0;
}

std::string Link::history() const {
    if (history_.empty()) return "\n  nothing was sent or received yet";
    return fmt::format("\n  the last lines on {}, > sent, < received:{}", name(), fmt::join(history_, ""));
}

}  // namespace palpate::grbl
