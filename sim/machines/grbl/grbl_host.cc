#include "sim/machines/grbl/grbl_host.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <optional>
#include <system_error>
#include <utility>

#include "devices/clock.h"
#include "devices/errors.h"
#include "sim/machines/pseudo_terminal.h"
#include "sim/machines/tcp_client_end.h"

namespace palpate {
namespace {

using std::chrono::nanoseconds;

constexpr Seconds kLongestSleep{3600.0};

timespec timespec_of(nanoseconds time) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
    return {static_cast<time_t>(seconds.count()), static_cast<long>((time - seconds).count())};
}

}  // namespace

// Ends a poll from another thread.
class GrblHost::Wake {
public:
    Wake() : descriptor_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
        if (descriptor_ < 0) {
            throw ConnectionLost(fmt::format("virtual GRBL: cannot make an event: {}", std::system_category().message(errno)));
        }
    }
    ~Wake() { close(descriptor_); }
    Wake(const Wake&) = delete;
    Wake& operator=(const Wake&) = delete;

    [[nodiscard]] int descriptor() const { return descriptor_; }
    void set() const { eventfd_write(descriptor_, 1); }
    void clear() const {
        eventfd_t count = 0;
        eventfd_read(descriptor_, &count);
    }

private:
    int descriptor_;
};

GrblHost::GrblHost(VirtualGrbl& grbl, GrblHostOptions options)
    : grbl_(grbl),
      options_(std::move(options)),
      wake_(std::make_unique<Wake>()),
      end_(open()),
      thread_([this](const std::stop_token& stop) { serve(stop); }) {}

GrblHost::~GrblHost() {
    thread_.request_stop();
    wake_->set();
}

std::shared_ptr<ClientEnd> GrblHost::open() const {
    if (options_.tcp_port) return std::make_shared<TcpClientEnd>(*options_.tcp_port);
    return std::make_shared<PseudoTerminal>(options_.link);
}

std::string GrblHost::client_path() const {
    const std::scoped_lock lock(mutex_);
    return end_ ? end_->client_path() : std::string();
}

void GrblHost::with(const std::function<void(VirtualGrbl&)>& use) {
    {
        const std::scoped_lock lock(mutex_);
        use(grbl_);
    }
    wake_->set();
}

void GrblHost::unplug() {
    std::unique_lock lock(mutex_);
    grbl_.unplug();
    const std::weak_ptr<ClientEnd> open = std::exchange(end_, nullptr);
    wake_->set();
    closed_.wait(lock, [&] { return open.expired(); });
}

void GrblHost::plug_in() {
    const std::scoped_lock lock(mutex_);
    if (!end_) end_ = open();
    grbl_.plug_in();
    wake_->set();
}

void GrblHost::serve(const std::stop_token& stop) {
    const SteadyClock clock;
    nanoseconds last = clock.now();
    std::shared_ptr<ClientEnd> end;
    while (true) {
        // Before the stop is looked at: who asks for one wakes after it.
        wake_->clear();
        if (stop.stop_requested()) return;
        {
            const std::scoped_lock lock(mutex_);
            const nanoseconds now = clock.now();
            let_time_pass(now - std::exchange(last, now));
            if (grbl_.link() != VirtualGrbl::Link::up) end_.reset();
            if (end != end_) {
                end = end_;
                to_send_.clear();
                closed_.notify_all();
            }
            to_send_ += grbl_.take_output();
        }
        const bool busy = end && pass_bytes(*end);
        if (!busy && !jump_to_event()) sleep(end.get());
    }
}

void GrblHost::let_time_pass(nanoseconds passed) {
    if (options_.time == GrblHostOptions::Time::real) grbl_.advance(passed);
}

// What was said before is not for the one who comes now.
void GrblHost::greet_client() {
    to_send_.clear();
    const std::scoped_lock lock(mutex_);
    (void)grbl_.take_output();
    if (options_.greets_clients) to_send_ = grbl_.banner();
    if (options_.reset_on_open) grbl_.press_reset();
}

// True if there may be more to do at once.
bool GrblHost::pass_bytes(ClientEnd& end) {
    const std::string bytes = end.read();
    if (end.take_openings()) greet_client();
    if (!end.has_client()) to_send_.clear();
    to_send_.erase(0, end.write(to_send_));
    if (bytes.empty()) return false;
    const std::scoped_lock lock(mutex_);
    grbl_.receive(bytes);
    return true;
}

// In fast time, once all is said. True if there was one.
bool GrblHost::jump_to_event() {
    if (options_.time != GrblHostOptions::Time::fast || !to_send_.empty()) return false;
    const std::scoped_lock lock(mutex_);
    const auto next = grbl_.time_to_event();
    if (next) grbl_.advance(*next);
    return next.has_value();
}

void GrblHost::sleep(const ClientEnd* end) {
    std::optional<nanoseconds> timeout;
    if (options_.time == GrblHostOptions::Time::real) {
        const std::scoped_lock lock(mutex_);
        // A move may take longer than nanoseconds can tell.
        if (const auto next = grbl_.time_to_event()) timeout = std::chrono::ceil<nanoseconds>(std::min(*next, kLongestSleep));
    }
    // Without a client the system reports a hang-up all the time.
    const bool listens = end != nullptr && end->has_client();
    const auto events = static_cast<short>(to_send_.empty() ? POLLIN : POLLIN | POLLOUT);
    // A negative descriptor is passed over.
    std::array<pollfd, 3> fds{pollfd{wake_->descriptor(), POLLIN, 0}, pollfd{end != nullptr ? end->openings_descriptor() : -1, POLLIN, 0},
                              pollfd{listens ? end->descriptor() : -1, events, 0}};
    const timespec wait = timespec_of(timeout.value_or(nanoseconds(0)));
    ppoll(fds.data(), fds.size(), timeout ? &wait : nullptr, nullptr);
}

}  // namespace palpate
