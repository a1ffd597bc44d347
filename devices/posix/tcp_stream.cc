#include "devices/posix/tcp_stream.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <memory>

#include "devices/errors.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;

constexpr int kLastPort = 65535;
// A peer that acknowledges nothing for so long is gone, whether something is sent or not.
constexpr auto kDeadPeer = 5000ms;
constexpr int kIdle_s = 3;      // of a silent line, until it is asked whether the peer is there ...
constexpr int kInterval_s = 1;  // ... again
constexpr int kAsked = 2;       // ... so many times
// The peer is given so long to end its side, so that what it has yet to say does not turn our end into a reset.
constexpr auto kPeersFarewell = 200ms;

std::string text_of(const TcpAddress& address) {
    const bool has_brackets = address.host.find(':') != std::string::npos;
    return fmt::format(fmt::runtime(has_brackets ? "{}[{}]:{}" : "{}{}:{}"), kTcpScheme, address.host, address.port);
}

struct FreeAddresses {
    void operator()(addrinfo* addresses) const { ::freeaddrinfo(addresses); }
};
using Addresses = std::unique_ptr<addrinfo, FreeAddresses>;

// Throws DeviceError.
Addresses resolve(const TcpAddress& address, const std::string& name) {
    addrinfo hints{};
    hints.ai_family = AF_UNSPEC;
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_NUMERICSERV;
    addrinfo* found = nullptr;
    const int error = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
    if (error != 0) {
        throw DeviceError(fmt::format("{}: there is no host of that name: {}; check its spelling, or give its address", name,
                                      error == EAI_SYSTEM ? reason(errno) : ::gai_strerror(error)));
    }
    return Addresses(found);
}

std::string connect_advice(int error) {
    switch (error) {
        case ECONNREFUSED:
            return "nobody takes a connection there: is the port right (grblHAL and FluidNC: 23), is another program connected? A "
                   "controller that lost a client without an end of its connection may hold its place until it is switched off and on";
        case ENETUNREACH:
        case EHOSTUNREACH:
            return "no way leads there: is the machine on, and on this network?";
        case ETIMEDOUT:
            return "nothing answers there: is the machine on, is the address right?";
        default:
            return reason(error);
    }
}

// "192.168.1.20", so that all names of a machine are one.
std::string numeric_host(const addrinfo& address) {
    std::array<char, NI_MAXHOST> host{};
    ::getnameinfo(address.ai_addr, address.ai_addrlen, host.data(), host.size(), nullptr, 0, NI_NUMERICHOST);
    return host.data();
}

// 0, or what went wrong (errno).
int connect_within(int socket, const addrinfo& address, std::chrono::milliseconds patience) {
    if (::connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
    if (errno != EINPROGRESS) return errno;
    pollfd waiting{socket, POLLOUT, 0};
    const auto until = std::chrono::steady_clock::now() + patience;
    int ready = 0;
    do {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
        ready = ::poll(&waiting, 1, static_cast<int>(std::max(left, 0ms).count()));
    } while (ready < 0 && errno == EINTR);
    if (ready < 0) return errno;
    if (ready == 0) return ETIMEDOUT;
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
    return error;
}

void set(int socket, int level, int option, int value) {
    // What a system does not know of these makes a dead peer be noticed later, no more.
    (void)::setsockopt(socket, level, option, &value, sizeof value);
}

// Every byte goes at once, and a peer that vanishes is noticed.
void configure(int socket) {
    set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
    set(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
    set(socket, IPPROTO_TCP, TCP_KEEPIDLE, kIdle_s);
    set(socket, IPPROTO_TCP, TCP_KEEPINTVL, kInterval_s);
    set(socket, IPPROTO_TCP, TCP_KEEPCNT, kAsked);
    set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(kDeadPeer.count()));
}

}  // namespace

bool is_tcp_address(std::string_view text) { return text.starts_with(kTcpScheme); }

std::optional<TcpAddress> parse_tcp_address(std::string_view text) {
    return is_tcp_address(text) ? parse_host_port(text.substr(kTcpScheme.size())) : std::nullopt;
}

std::optional<TcpAddress> parse_host_port(std::string_view text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) return std::nullopt;
    TcpAddress address{std::string(text.substr(0, colon)), 0};
    std::string& host = address.host;
    const bool has_brackets = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (has_brackets) host = host.substr(1, host.size() - 2);
    if (host.empty() || host.find_first_of("[]/ ") != std::string::npos || (!has_brackets && host.find(':') != std::string::npos)) {
        return std::nullopt;
    }
    const std::string_view digits = text.substr(colon + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
    if (error != std::errc{} || end != digits.data() + digits.size() || address.port < 0 || address.port > kLastPort) return std::nullopt;
    return address;
}

TcpStream::TcpStream(const TcpAddress& address, std::chrono::milliseconds patience) : DescriptorStream(text_of(address)) {
    const Addresses addresses = resolve(address, name());
    int error = 0;
    for (const addrinfo* each = addresses.get(); each != nullptr; each = each->ai_next) {
        lock_ = MachineLock::of_peer(numeric_host(*each), address.port);
        file_ = ::socket(each->ai_family, each->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, each->ai_protocol);
        error = file_ < 0 ? errno : connect_within(file_, *each, patience);
        if (error == 0) break;
        if (file_ >= 0) ::close(file_);
        file_ = -1;
    }
    if (error != 0) throw DeviceError(fmt::format("{}: cannot be reached: {}", name(), connect_advice(error)));
    configure(file_);
}

TcpStream::~TcpStream() {
    ::shutdown(file_, SHUT_WR);
    const auto until = std::chrono::steady_clock::now() + kPeersFarewell;
    std::array<char, 1024> unheard{};
    while (std::chrono::steady_clock::now() < until) {
        pollfd waiting{file_, POLLIN, 0};
        if (::poll(&waiting, 1, static_cast<int>(kPeersFarewell.count())) <= 0) break;
        if (::read(file_, unheard.data(), unheard.size()) <= 0) break;
    }
}

ssize_t TcpStream::put(std::string_view bytes) { return ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

std::string TcpStream::lost(const std::string& what) const {
    return fmt::format(
        "{}: the connection is lost ({}): see to the machine and its network, and that no other program is connected; then resume", name(),
        what);
}

}  // namespace palpate
