#include "tools/terminal/terminal.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

namespace palpate {
namespace {

// So often a stop is looked for while nobody answers.
constexpr int kPoll_ms = 50;

bool is_ready(int file, short events, int patience_ms) {
    pollfd waiting{file, events, 0};
    return ::poll(&waiting, 1, patience_ms) > 0;
}

}  // namespace

std::optional<Terminal> Terminal::of_process() {
    const int file = ::open("/dev/tty", O_RDWR | O_CLOEXEC | O_NOCTTY);
    if (file < 0) return std::nullopt;
    return Terminal(file);
}

Terminal::~Terminal() {
    if (file_ >= 0) ::close(file_);
}

Terminal::Terminal(Terminal&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

void Terminal::wait_while_held(StopSignals& signals) const {
    while (!signals.token().stop_requested() && !is_ready(file_, POLLOUT, kPoll_ms)) signals.pause();
}

void Terminal::say(std::string_view text, StopSignals& signals) const {
    while (!text.empty() && !signals.token().stop_requested()) {
        signals.pause();
        if (!is_ready(file_, POLLOUT, kPoll_ms)) continue;
        // Line by line: a terminal that is held now takes no more than one before it is asked again.
        const std::size_t line = std::min(text.find('\n'), text.size() - 1) + 1;
        const ssize_t count = ::write(file_, text.data(), line);
        if (count <= 0) return;
        text.remove_prefix(static_cast<std::size_t>(count));
    }
}

void Terminal::pose(std::string_view question, StopSignals& signals) const {
    say(question.substr(0, question.size() - 1), signals);
    (void)::tcflush(file_, TCIFLUSH);
    say(question.substr(question.size() - 1), signals);
}

std::string Terminal::ask(std::string_view question, StopSignals& signals) const {
    pose(question, signals);
    std::string line;
    while (!signals.token().stop_requested()) {
        if (signals.token().pause_requested()) {
            signals.pause();
            return ask(question, signals);
        }
        if (!is_ready(file_, POLLIN, kPoll_ms)) continue;
        std::array<char, 1> c{};
        if (::read(file_, c.data(), 1) != 1 || c[0] == '\n') break;
        line += c[0];
    }
    return line;
}

bool Terminal::is_line_entered(std::chrono::milliseconds patience) const {
    if (!is_ready(file_, POLLIN, static_cast<int>(patience.count()))) return false;
    std::array<char, 256> line{};
    if (::read(file_, line.data(), line.size()) > 0) return true;
    std::this_thread::sleep_for(patience);  // the terminal is gone
    return false;
}

}  // namespace palpate
