#include "sim/machines/tcp_client_end.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

#include "devices/errors.h"

namespace palpate {

TcpClientEnd::TcpClientEnd(int port) : port_(port) { listen(); }

TcpClientEnd::~TcpClientEnd() {
    if (listener_ >= 0) ::close(listener_);
    if (client_ >= 0) ::close(client_);
}

std::string TcpClientEnd::client_path() const { return fmt::format("tcp://127.0.0.1:{}", port_); }

void TcpClientEnd::listen() {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int yes = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size) != 0 || ::listen(listener_, 0) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
        const int error = errno;
        ::close(listener_);
        listener_ = -1;
        throw ConnectionLost(fmt::format("cannot listen at {}: {}", client_path(), std::system_category().message(error)));
    }
    port_ = ntohs(address.sin_port);
}

void TcpClientEnd::drop_client() {
    ::close(client_);
    client_ = -1;
    listen();
}

bool TcpClientEnd::take_openings() {
    if (listener_ >= 0) {
        client_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (client_ >= 0) {
            const int yes = 1;
            ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
            ::close(listener_);
            listener_ = -1;
            opened_ = true;
        }
    }
    return std::exchange(opened_, false);
}

std::string TcpClientEnd::read() {
    std::string bytes;
    std::array<char, 1024> part{};
    while (client_ >= 0) {
        const ssize_t count = ::read(client_, part.data(), part.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno == EAGAIN) break;
        if (count <= 0) {
            drop_client();
            break;
        }
        bytes.append(part.data(), static_cast<std::size_t>(count));
    }
    return bytes;
}

std::size_t TcpClientEnd::write(std::string_view bytes) {
    std::size_t done = 0;
    while (done < bytes.size() && client_ >= 0) {
        const ssize_t count = ::send(client_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) break;  // what is gone is seen by reading
        done += static_cast<std::size_t>(count);
    }
    return done;
}

}  // namespace palpate
