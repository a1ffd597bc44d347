#include "devices/posix/descriptor_stream.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "devices/errors.h"

namespace palpate {

// What takes no byte for so long is dead: at 9600 baud the largest kernel buffer is through in 5 s.
constexpr int kWriteTimeout_ms = 5000;

DescriptorStream::~DescriptorStream() {
    if (file_ >= 0) ::close(file_);
}

std::string DescriptorStream::read(std::chrono::milliseconds timeout) {
    pollfd waiting{file_, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(timeout.count()));
    if (ready < 0 && errno != EINTR) throw ConnectionLost(lost(reason(errno)));
    if (ready <= 0) return {};
    std::array<char, 1024> bytes{};
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    if (count > 0) return {bytes.data(), static_cast<std::size_t>(count)};
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return {};
    throw ConnectionLost(lost(count == 0 ? end_of_file() : reason(errno)));
}

void DescriptorStream::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = put(bytes);
        if (count > 0) {
            bytes.remove_prefix(static_cast<std::size_t>(count));
            continue;
        }
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno != EAGAIN) throw ConnectionLost(lost(reason(errno)));
        pollfd waiting{file_, POLLOUT, 0};
        const int ready = ::poll(&waiting, 1, kWriteTimeout_ms);
        if (ready == 0) throw ConnectionLost(lost("it takes no more bytes"));
        if (ready < 0 && errno != EINTR) throw ConnectionLost(lost(reason(errno)));
    }
}

}  // namespace palpate
