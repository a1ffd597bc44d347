#include "tools/terminal/console.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>

namespace palpate {
namespace {

// What a reader may be behind: some hundreds of lines.
constexpr std::size_t kMost = 65536;  // bytes
// A pipe that says that it takes something takes that much without waiting (POSIX: at least 512).
constexpr std::size_t kChunk = 512;  // bytes
// How long the end of the program waits for the far end.
constexpr std::chrono::milliseconds kLastPatience{500};
constexpr std::string_view kTakeAway = "\r\x1b[K";

// Waits as long as it takes. False if nobody will ever read it.
bool write_all(int file, std::string_view text) {
    while (!text.empty()) {
        pollfd waiting{file, POLLOUT, 0};
        if (::poll(&waiting, 1, -1) < 0 && errno != EINTR) return false;
        if ((waiting.revents & (POLLERR | POLLNVAL)) != 0) return false;
        const ssize_t count = ::write(file, text.data(), std::min(text.size(), kChunk));
        if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
        if (count < 0 && errno != EINTR && errno != EAGAIN) return false;
    }
    return true;
}

}  // namespace

struct Console::Shared {
    const int file;
    const LostLines say_lost;
    std::mutex mutex;
    std::condition_variable changed;
    std::string waiting;           // text that was not begun yet
    std::string status;            // as it is to be
    bool is_status_old = false;    // what is drawn, if anything is, is another one
    bool is_status_drawn = false;  // it stands in the last line
    bool is_line_open = false;     // the last text has no end of line: no place for a status
    bool is_writing = false;
    bool is_dead = false;  // the reader is gone
    bool has_ended = false;
    std::uint64_t lost_lines = 0;

    Shared(int file_descriptor, LostLines lost) : file(file_descriptor), say_lost(lost) {}

    [[nodiscard]] bool is_idle() const { return waiting.empty() && !is_status_old && !is_writing; }

    // What to write now, and what it leaves on the screen.
    std::string take() {
        std::string text;
        const bool draws = !status.empty() && (is_status_old || is_status_drawn);
        if (is_status_drawn && (!waiting.empty() || status.empty())) {
            text += kTakeAway;
            is_status_drawn = false;
        }
        if (!waiting.empty()) is_line_open = waiting.back() != '\n';
        text += std::exchange(waiting, {});
        if (!is_line_open && lost_lines > 0) text += say_lost(std::exchange(lost_lines, 0));
        if (draws && !is_line_open) {
            text += '\r' + status + "\x1b[K";
            is_status_drawn = true;
        }
        is_status_old = false;
        return text;
    }

    void run() {
        std::unique_lock lock(mutex);
        while (true) {
            changed.wait(lock, [&] { return !waiting.empty() || is_status_old || has_ended; });
            if (waiting.empty() && !is_status_old) return;
            const std::string text = take();
            is_writing = true;
            lock.unlock();
            const bool is_read = write_all(file, text);
            lock.lock();
            is_writing = false;
            is_dead |= !is_read;
            changed.notify_all();
        }
    }
};

std::string Console::say_lost(std::uint64_t count) { return fmt::format("palpate: {} line(s) lost, as nobody took them\n", count); }

Console::Console(int file_descriptor, LostLines lost_lines) : shared_(std::make_shared<Shared>(file_descriptor, lost_lines)) {
    // Signals are for others to hear.
    sigset_t all{};
    sigset_t before{};
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    std::thread([shared = shared_] { shared->run(); }).detach();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Console::~Console() {
    set_status({});
    flush(kLastPatience);
    const std::scoped_lock lock(shared_->mutex);
    shared_->has_ended = true;
    shared_->changed.notify_all();
}

void Console::write(std::string_view text) {
    if (text.empty()) return;
    const std::scoped_lock lock(shared_->mutex);
    if (shared_->is_dead) return;
    if (shared_->waiting.size() + text.size() > kMost) {
        shared_->lost_lines += static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(1, std::ranges::count(text, '\n')));
        return;
    }
    shared_->waiting += text;
    shared_->changed.notify_all();
}

void Console::set_status(std::string line) {
    const std::scoped_lock lock(shared_->mutex);
    if (shared_->is_dead || line == shared_->status) return;
    shared_->status = std::move(line);
    shared_->is_status_old = true;
    shared_->changed.notify_all();
}

bool Console::flush(std::chrono::milliseconds patience) {
    std::unique_lock lock(shared_->mutex);
    return shared_->changed.wait_for(lock, patience, [&] { return shared_->is_idle() || shared_->is_dead; }) && !shared_->is_dead;
}

bool Console::is_dead() const {
    const std::scoped_lock lock(shared_->mutex);
    return shared_->is_dead;
}

// --- stream ----------------------------------------------------------------------------------------------------------

ConsoleStream::Buffer::int_type ConsoleStream::Buffer::overflow(int_type c) {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char one = traits_type::to_char_type(c);
    return xsputn(&one, 1) == 1 ? c : traits_type::eof();
}

std::streamsize ConsoleStream::Buffer::xsputn(const char* text, std::streamsize count) {
    line_.append(text, static_cast<std::size_t>(count));
    if (const std::size_t end = line_.rfind('\n'); end != std::string::npos) {
        console_.write(std::string_view(line_).substr(0, end + 1));
        line_.erase(0, end + 1);
    }
    return count;
}

int ConsoleStream::Buffer::sync() {
    console_.write(std::exchange(line_, {}));
    return 0;
}

}  // namespace palpate
