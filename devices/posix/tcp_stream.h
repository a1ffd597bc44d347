// A TCP connection as a ByteStream: to a controller on the network, or to a serial port that another computer serves (ser2net).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "devices/posix/descriptor_stream.h"
#include "devices/posix/machine_lock.h"

namespace palpate {

inline constexpr std::string_view kTcpScheme = "tcp://";

struct TcpAddress {
    std::string host;  // a name, an IPv4 address, or an IPv6 address without brackets
    int port = 0;

    friend bool operator==(const TcpAddress&, const TcpAddress&) = default;
};

// Of "HOST:PORT", an IPv6 address in brackets; nothing if it is none. Port 0, which nobody can connect to, is one that is free to who
// listens.
[[nodiscard]] std::optional<TcpAddress> parse_host_port(std::string_view text);
// The same of "tcp://HOST:PORT".
[[nodiscard]] std::optional<TcpAddress> parse_tcp_address(std::string_view text);
// Whether it means to be one.
[[nodiscard]] bool is_tcp_address(std::string_view text);

class TcpStream final : public DescriptorStream {
public:
    // Throws DeviceError, which names the address and what to do: no such name, nobody listens (or somebody else is connected), no way
    // there, no answer within `patience`, or another process of this computer drives the machine there.
    explicit TcpStream(const TcpAddress& address, std::chrono::milliseconds patience = std::chrono::seconds(10));
    // In an orderly way, so that the other side sees the end of it: some controllers have one place for a client, and hold it for one that
    // just vanished until they are switched off (devices/FACTS.md, "GRBL over TCP").
    ~TcpStream() override;
    TcpStream(const TcpStream&) = delete;
    TcpStream& operator=(const TcpStream&) = delete;
    TcpStream(TcpStream&&) = delete;
    TcpStream& operator=(TcpStream&&) = delete;

private:
    [[nodiscard]] ssize_t put(std::string_view bytes) override;
    [[nodiscard]] std::string lost(const std::string& what) const override;
    [[nodiscard]] const char* end_of_file() const override { return "the other side ended it"; }

    MachineLock lock_;
};

}  // namespace palpate
