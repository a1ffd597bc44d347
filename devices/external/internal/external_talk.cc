#include "devices/external/internal/external_talk.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "devices/errors.h"

namespace palpate::external {
namespace {

constexpr std::size_t kRemembered = 8;  // lines
constexpr std::size_t kShown = 300;     // bytes of a line, in messages

}  // namespace

void Talk::remember(char direction, std::string_view line) {
    if (line.ends_with('\n')) line.remove_suffix(1);
    // Signs of life would push out what matters.
    const bool is_alive = line.find("\"alive\"") != std::string_view::npos;
    const std::string entry = fmt::format("\n    {} {}", direction, line.substr(0, kShown));
    if (is_alive && !history_.empty() && history_.back().find("\"alive\"") != std::string::npos) history_.pop_back();
    history_.push_back(entry);
    if (history_.size() > kRemembered) history_.pop_front();
}

std::string Talk::history() const {
    if (history_.empty()) return "";
    return fmt::format("; what was said last (> to it, < from it):{}", fmt::join(history_, ""));
}

std::uint64_t Talk::send(const std::function<std::string(std::uint64_t)>& text) {
    const std::string line = text(++last_);
    remember('>', line);
    stream_.write(line);
    return last_;
}

void Talk::say_alive() { stream_.write(kAlive); }

std::optional<Line> Talk::receive(std::chrono::nanoseconds until) {
    while (true) {
        const std::size_t end = bytes_.find('\n');
        if (end != std::string::npos) {
            std::string text = bytes_.substr(0, end);
            bytes_.erase(0, end + 1);
            if (text.ends_with('\r')) text.pop_back();
            if (text.empty()) continue;
            remember('<', text);
            const auto parsed = parse(text);
            if (const auto* malformed = std::get_if<Malformed>(&parsed)) refuse(fmt::format("says a line that {}", malformed->why));
            return std::get<Line>(parsed);
        }
        if (bytes_.size() > kLongestLine) {
            remember('<', bytes_);
            refuse(fmt::format("says a line of more than {} bytes", kLongestLine));
        }
        const auto left = std::max(until - now(), std::chrono::nanoseconds(0));
        const std::string more = stream_.read(std::chrono::ceil<std::chrono::milliseconds>(left));
        if (more.empty() && now() >= until) return std::nullopt;
        bytes_ += more;
    }
}

Line Talk::wait_for(std::uint64_t id, std::string_view what, std::chrono::nanoseconds patience) {
    const auto until = now() + std::max(patience, answer_time_);
    while (const auto line = receive(until)) {
        if (!line->id) continue;  // a sign of life
        if (*line->id != id) refuse(fmt::format("answers question {}, not {}", *line->id, id));
        if (line->error) {
            throw DeviceRefused(0, fmt::format("the program of {} refuses \"{}\": {}{}", name(), what, *line->error, history()));
        }
        return *line;
    }
    fail_silent(fmt::format("the answer to \"{}\"", what));
}

void Talk::refuse(const std::string& what) const {
    throw BadAnswer(fmt::format("the program of {} {}: nothing more is sent; see devices/external/PROTOCOL.md{}", name(), what, history()));
}

void Talk::fail_silent(const std::string& awaited) const {
    throw DeviceTimeout(
        fmt::format("the program of {} is silent while {} is awaited: does it run, does it flush its output after every line?{}", name(),
                    awaited, history()));
}

}  // namespace palpate::external
