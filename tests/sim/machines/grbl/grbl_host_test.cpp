// Over real pseudo-terminals.
#include "sim/machines/grbl/grbl_host.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <fstream>
#include <thread>

#include "devices/clock.h"
#include "devices/errors.h"
#include "devices/posix/tcp_stream.h"
#include "sim/machines/pseudo_terminal.h"
#include "tests/sim/machines/grbl/virtual_grbl_support.h"

namespace palpate::grbl_host_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

// Patience for a loaded machine; nothing here takes as long when all is well.
constexpr auto kPatience = 10s;

// A program that opens the port.
class Client {
public:
    explicit Client(const std::string& path) : descriptor_(open(path.c_str(), O_RDWR | O_NOCTTY)) {}
    ~Client() { close(descriptor_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
    void write(const std::string& text) const {
        ASSERT_EQ(::write(descriptor_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    }
    // Until `end` has come, or the port is gone.
    std::string read_until(const std::string& end, std::chrono::milliseconds patience = kPatience) {
        std::string text;
        const auto deadline = std::chrono::steady_clock::now() + patience;
        while (text.find(end) == std::string::npos && std::chrono::steady_clock::now() < deadline) {
            pollfd state{descriptor_, POLLIN, 0};
            if (poll(&state, 1, 10) <= 0) continue;
            std::array<char, 256> part{};
            const ssize_t count = ::read(descriptor_, part.data(), part.size());
            if (count <= 0) {
                gone_ = true;
                break;
            }
            text.append(part.data(), static_cast<std::size_t>(count));
        }
        return text;
    }
    [[nodiscard]] bool is_gone() const { return gone_; }

private:
    int descriptor_;
    bool gone_ = false;
};

class GrblHostTest : public VirtualGrblTest {
protected:
    GrblHostTest() {
        host_options.time = GrblHostOptions::Time::fast;
        host_options.link = std::filesystem::path(testing::TempDir()) / ("palpate-grbl-" + std::to_string(getpid()));
        start();
    }

    GrblHostOptions host_options;
};

TEST_F(GrblHostTest, StatusComesOverARealPseudoTerminalThroughTheLink) {
    {
        const GrblHost host(*grbl, host_options);
        Client client(host_options.link);
        ASSERT_TRUE(client.is_open());
        client.write("?");
        EXPECT_THAT(lines_of(client.read_until(">\r\n")), ElementsAre(StartsWith("<Idle|MPos:20.000,0.000,0.000|")));
    }
    EXPECT_FALSE(std::filesystem::is_symlink(host_options.link)) << "the link is gone with the host";
}

TEST_F(GrblHostTest, AProbeOverTheTerminal) {
    GrblHost host(*grbl, host_options);
    Client client(host.client_path());
    client.write("G38.2 X0 F60\n");
    EXPECT_THAT(lines_of(client.read_until("ok\r\n")), ElementsAre("[PRB:10.000,0.000,0.000:1]", "ok"));
    host.with([&](VirtualGrbl& machine) { EXPECT_EQ(machine.tool().audit().moves, 1U); });
}

TEST_F(GrblHostTest, RealTimeIsAsSlowAsAMachine) {
    host_options.time = GrblHostOptions::Time::real;
    const GrblHost host(*grbl, host_options);
    Client client(host.client_path());
    const SteadyClock clock;
    const auto begin = clock.now();
    client.write("G38.3 X20 Y2 F300\n");
    EXPECT_THAT(client.read_until("ok\r\n"), HasSubstr("[PRB:20.000,2.000,0.000:0]"));
    EXPECT_GE(clock.now() - begin, 400ms);
}

TEST_F(GrblHostTest, ClientsComeAndGo) {
    const GrblHost host(*grbl, host_options);
    for (int i = 0; i < 5; ++i) {
        Client client(host_options.link);
        client.write("G21\n");
        EXPECT_EQ(client.read_until("ok\r\n"), "ok\r\n") << "nothing stale either";
    }
}

TEST_F(GrblHostTest, OpeningResetsTheMachineIfAskedFor) {
    host_options.reset_on_open = true;
    const GrblHost host(*grbl, host_options);
    for (int i = 0; i < 2; ++i) {
        Client client(host_options.link);
        EXPECT_THAT(lines_of(client.read_until("unlock]\r\n")), ElementsAre("Grbl 1.1h ['$' for help]", kLockMessage));
    }
}

TEST_F(GrblHostTest, ClientsOnTheNetworkAreGreetedWithoutAReset) {
    host_options.tcp_port = 0;
    for (const bool greets : {false, true}) {
        host_options.greets_clients = greets;
        GrblHost host(*grbl, host_options);
        const auto address = parse_tcp_address(host.client_path());
        ASSERT_TRUE(address);
        for (int client = 0; client < 2; ++client) {
            std::string said;
            {
                TcpStream stream(*address);
                stream.write("?");
                while (said.find('>') == std::string::npos) said += stream.read(kPatience);
            }
            EXPECT_EQ(said.find("Grbl 1.1h") != std::string::npos, greets) << said;
            // The place is free once the machine has seen the end.
            for (bool is_free = false; !is_free; std::this_thread::sleep_for(1ms)) {
                try {
                    const TcpStream next(*address);
                    is_free = true;
                } catch (const DeviceError&) {
                }
            }
        }
        host.with([](VirtualGrbl& machine) { EXPECT_EQ(machine.counts().resets, 0U); });
    }
}

TEST_F(GrblHostTest, AnUnpluggedClientSeesTheEndAndCanComeBack) {
    GrblHost host(*grbl, host_options);
    Client client(host_options.link);
    client.write("G21\n");
    client.read_until("ok\r\n");
    host.unplug();
    EXPECT_THAT(client.read_until("never"), IsEmpty());
    EXPECT_TRUE(client.is_gone());
    EXPECT_FALSE(std::filesystem::is_symlink(host_options.link));
    EXPECT_THAT(host.client_path(), IsEmpty());
    host.plug_in();
    Client again(host_options.link);
    again.write("G21\n");
    EXPECT_EQ(again.read_until("ok\r\n"), "ok\r\n");
}

TEST_F(GrblHostTest, AFaultOfTheScriptHangsUp) {
    options.faults = {{VirtualFault::Kind::hang_up, VirtualFault::When::line, 2}};
    start();
    GrblHost host(*grbl, host_options);
    Client client(host_options.link);
    client.write("G21\n");
    EXPECT_EQ(client.read_until("ok\r\n"), "ok\r\n");
    client.write("G38.2 X0 F600\n");
    client.read_until("never");
    EXPECT_TRUE(client.is_gone());
    const auto is_probing = [&] {
        bool probing = false;
        host.with([&](VirtualGrbl& machine) { probing = machine.is_busy(); });
        return probing;
    };
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (is_probing() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(1ms);
    host.plug_in();
    Client again(host_options.link);
    again.write("$#\n");
    EXPECT_THAT(again.read_until("ok\r\n"), HasSubstr("[PRB:10.000,0.000,0.000:1]\r\nok")) << "the probe went on without a host";
}

TEST_F(GrblHostTest, AClientThatDoesNotReadStopsNothing) {
    GrblHost host(*grbl, host_options);
    Client client(host.client_path());
    std::string many;
    for (int i = 0; i < 1000; ++i) many += "?";
    client.write(many);
    const std::string text = client.read_until("never", 500ms);
    EXPECT_EQ(std::count(text.begin(), text.end(), '>'), 1000);
}

TEST_F(GrblHostTest, AnIdleHostDoesNotUseTheProcessor) {
    const GrblHost host(*grbl, host_options);
    Client client(host.client_path());
    client.write("?");
    client.read_until(">");
    const std::clock_t before = std::clock();
    client.read_until("never", 500ms);
    EXPECT_LT(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC, 0.1);
}

TEST_F(GrblHostTest, ALinkReplacesALinkButNoFile) {
    std::filesystem::create_symlink("/nowhere", host_options.link);
    {
        const PseudoTerminal terminal(host_options.link);
        EXPECT_EQ(std::filesystem::read_symlink(host_options.link), terminal.client_path());
    }
    std::ofstream(host_options.link) << "precious";
    EXPECT_THROW(PseudoTerminal{host_options.link}, ConnectionLost);
    EXPECT_TRUE(std::filesystem::remove(host_options.link));
    EXPECT_THROW(PseudoTerminal{"/nowhere/at/all"}, ConnectionLost);
}

}  // namespace
}  // namespace palpate::grbl_host_test
