// Over real sockets of this computer's own network.
#include "devices/posix/tcp_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "devices/errors.h"
#include "sim/machines/tcp_client_end.h"
#include "tests/devices/message_of.h"

namespace palpate::tcp_stream_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr auto kPatience = 10s;

TcpAddress address_of(const TcpClientEnd& end) { return {"127.0.0.1", end.port()}; }

// Until `done`, or for long.
template <class Done>
bool wait_until(const Done& done) {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (!done()) {
        if (std::chrono::steady_clock::now() > until) return false;
        std::this_thread::sleep_for(1ms);
    }
    return true;
}

// Says nothing and does nothing.
class Listener {
public:
    explicit Listener(int backlog) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        address_.sin_family = AF_INET;
        address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address_;
        EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address_), size), 0);
        EXPECT_EQ(::listen(socket_, backlog), 0);
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address_), &size);
    }
    ~Listener() { ::close(socket_); }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    [[nodiscard]] TcpAddress address() const { return {"127.0.0.1", ntohs(address_.sin_port)}; }
    [[nodiscard]] int accept() const { return ::accept(socket_, nullptr, nullptr); }
    // Somebody who never says anything.
    [[nodiscard]] int connect() const {
        const int client = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
        (void)::connect(client, reinterpret_cast<const sockaddr*>(&address_), sizeof address_);
        return client;
    }

private:
    int socket_;
    sockaddr_in address_{};
};

TEST(TcpAddressText, IsReadStrictly) {
    EXPECT_EQ(parse_tcp_address("tcp://mill:23"), (TcpAddress{"mill", 23}));
    EXPECT_EQ(parse_tcp_address("tcp://192.168.1.20:65535"), (TcpAddress{"192.168.1.20", 65535}));
    EXPECT_EQ(parse_tcp_address("tcp://[fe80::1]:23"), (TcpAddress{"fe80::1", 23}));
    for (const char* const text :
         {"mill:23", "tcp://mill", "tcp://:23", "tcp://mill:", "tcp://mill:65536", "tcp://mill:-1", "tcp://mill:23x", "tcp://fe80::1:23",
          "tcp://[]:23", "tcp://a/b:23", "tcp://a b:23", "udp://mill:23", "tcp://"}) {
        EXPECT_EQ(parse_tcp_address(text), std::nullopt) << text;
    }
    EXPECT_TRUE(is_tcp_address("tcp://mill"));
    EXPECT_FALSE(is_tcp_address("/dev/ttyUSB0"));
}

TEST(TcpStreamTest, BytesGoBothWays) {
    TcpClientEnd end(0);
    TcpStream stream(address_of(end));
    EXPECT_EQ(stream.name(), end.client_path());
    ASSERT_TRUE(wait_until([&] { return end.take_openings(); }));
    stream.write("?");
    std::string heard;
    ASSERT_TRUE(wait_until([&] { return !(heard += end.read()).empty(); }));
    EXPECT_EQ(heard, "?");
    EXPECT_EQ(end.write("<Idle>\r\n"), 8U);
    EXPECT_EQ(stream.read(kPatience), "<Idle>\r\n");
    EXPECT_EQ(stream.read(1ms), "");
}

TEST(TcpStreamTest, ASecondClientIsRefusedUntilTheFirstHasGone) {
    TcpClientEnd end(0);
    const TcpAddress address = address_of(end);
    {
        TcpStream stream(address);
        ASSERT_TRUE(wait_until([&] { return end.take_openings(); }));
        expect_says(message_of<DeviceError>([&] { TcpStream other(address); }), "another process drives the machine at 127.0.0.1");
    }
    ASSERT_TRUE(wait_until([&] {
        (void)end.read();
        return !end.has_client();
    }));
    const TcpStream next(address);
    EXPECT_TRUE(wait_until([&] { return end.take_openings(); }));
}

TEST(TcpStreamTest, SaysWhyItCannotConnect) {
    int free = 0;
    {
        const TcpClientEnd end(0);
        free = end.port();
    }
    const std::string refused = message_of<DeviceError>([&] { TcpStream stream({"127.0.0.1", free}); });
    EXPECT_THAT(refused, HasSubstr("tcp://127.0.0.1:" + std::to_string(free) + ": cannot be reached: nobody takes a connection there"));
    EXPECT_THAT(refused, HasSubstr("is another program connected?"));
    EXPECT_THAT(message_of<DeviceError>([&] {
                    TcpStream stream({"no-such-host.invalid", 23});
                }),
                HasSubstr("there is no host of that name"));
}

TEST(TcpStreamTest, NobodyIsWaitedForForever) {
    // One whose queue is full answers nothing.
    const Listener listener(0);
    std::array<int, 4> waiting{};
    for (int& one : waiting) one = listener.connect();
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_THAT(message_of<DeviceError>([&] { TcpStream stream(listener.address(), 200ms); }), HasSubstr("nothing answers there"));
    EXPECT_LT(std::chrono::steady_clock::now() - begun, kPatience);
    for (const int one : waiting) ::close(one);
}

TEST(TcpStreamTest, APeerThatGoesIsNoticed) {
    auto end = std::make_unique<TcpClientEnd>(0);
    TcpStream stream(address_of(*end));
    ASSERT_TRUE(wait_until([&] { return end->take_openings(); }));
    end.reset();
    const std::string message = message_of<ConnectionLost>([&] {
        for (int k = 0; k < 100; ++k) (void)stream.read(100ms);
    });
    EXPECT_THAT(message, HasSubstr("the connection is lost (the other side ended it)"));
    EXPECT_THROW(
        {
            for (int k = 0; k < 100; ++k) {
                stream.write("?");
                std::this_thread::sleep_for(10ms);
            }
        },
        ConnectionLost);
}

// A controller with one place for a client has to see the end of it: what was not read yet must not turn it into a reset.
TEST(TcpStreamTest, EndsInAnOrderlyWayWithBytesUnread) {
    const Listener listener(1);
    int peer = -1;
    {
        TcpStream stream(listener.address());
        peer = listener.accept();
        ASSERT_EQ(::write(peer, "ok\r\n", 4), 4);
        stream.write("!");
    }
    char byte = 0;
    EXPECT_EQ(::read(peer, &byte, 1), 1);
    EXPECT_EQ(::read(peer, &byte, 1), 0) << "the end, and no reset by peer";
    ::close(peer);
}

}  // namespace
}  // namespace palpate::tcp_stream_test
