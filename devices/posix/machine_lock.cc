#include "devices/posix/machine_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <utility>

#include "devices/errors.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestName = sizeof(sockaddr_un::sun_path) - 1;

// Of any length: of a long one its end, and a checksum of the whole, for commands may end alike.
std::string name_of_socket(const std::string& machine) {
    std::string name = fmt::format("palpate-machine-{}", machine);
    if (name.size() <= kLongestName) return name;
    const std::string sum = fmt::format("palpate-machine-{:08x}-", ::crc32_z(0, reinterpret_cast<const Bytef*>(name.data()), name.size()));
    return sum + name.substr(name.size() - (kLongestName - sum.size()));
}

[[noreturn]] void refuse(const std::string& what) {
    throw DeviceError(fmt::format("another process drives the machine at {}; end it first", what));
}

}  // namespace

MachineLock MachineLock::of_device(const std::string& path) {
    // Not blocking: without carrier an open would wait for it.
    MachineLock lock(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (lock.descriptor_ < 0) {
        throw ConnectionLost(fmt::format("cannot open {}: {}; is the adapter plugged in, and may you use it?", path, reason(errno)));
    }
    if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0) {
        if (errno == EWOULDBLOCK) refuse(path);
        throw ConnectionLost(fmt::format("cannot lock {}: {}", path, reason(errno)));
    }
    return lock;
}

MachineLock MachineLock::of_peer(const std::string& numeric_host, int port) { return of_name(fmt::format("{}:{}", numeric_host, port)); }

MachineLock MachineLock::of_name(const std::string& machine) {
    const std::string name = name_of_socket(machine);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    // The first byte stays zero: an abstract name, which no file and no crash can leave behind.
    std::copy(name.begin(), name.end(), &address.sun_path[1]);
    MachineLock lock(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (lock.descriptor_ < 0) throw ConnectionLost(fmt::format("cannot make a socket: {}", reason(errno)));
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    if (::bind(lock.descriptor_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
        if (errno == EADDRINUSE) refuse(machine);
        throw ConnectionLost(fmt::format("cannot lock {}: {}", machine, reason(errno)));
    }
    return lock;
}

MachineLock::~MachineLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

MachineLock::MachineLock(MachineLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

MachineLock& MachineLock::operator=(MachineLock&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

}  // namespace palpate
