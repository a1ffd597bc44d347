// Registers of one Modbus unit, over TCP or RTU (libmodbus): connecting, and the hygiene that keeps answers with their requests.
//
// libmodbus gives a late answer to the next request, with success, and so shifts every value from then on (devices/FACTS.md, "Modbus").
// So: bytes that wait are dropped after connecting; after any request without a good answer the link is left alone until the slowest
// answer would have come, and what came is dropped. libmodbus' own recovery is off: it does not help on RTU.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "devices/clock.h"
#include "devices/stop_request.h"
#include "planner/machine_time.h"

namespace palpate {

struct ModbusTcp {
    std::string host;
    int port = 502;
};

struct ModbusRtu {
    std::string path;  // "/dev/ttyUSB0"
    int baud = 19200;
    char parity = 'E';  // N, E, O
    int stop_bits = 1;  // 1, 2
};

struct ModbusLinkOptions {
    std::variant<ModbusTcp, ModbusRtu> where;
    int unit = 1;                  // 0..247, on TCP 255 too
    Seconds answer_timeout{0.5};   // without an answer for so long, a request has failed
    Seconds slowest_answer{0.65};  // after a request, no answer comes later than this; some drives need 0.6
    int reconnects = 10;           // losses of the connection that one move survives
    Seconds reconnect_time{10.0};  // a network or a controller that is away is waited for so long
    Seconds reconnect_pause{0.2};  // between attempts
    Seconds busy_time{1.0};        // "busy" and "the gateway does not reach it" are asked again for so long
};

class ModbusLink {
public:
    // Connects. `clock` must outlive the link. Throws ConnectionLost, DeviceError if another process has the machine or an option is
    // out of range.
    ModbusLink(ModbusLinkOptions options, Clock& clock);
    ~ModbusLink();
    ModbusLink(const ModbusLink&) = delete;
    ModbusLink& operator=(const ModbusLink&) = delete;
    ModbusLink(ModbusLink&&) = delete;
    ModbusLink& operator=(ModbusLink&&) = delete;

    // Holding registers: FC03, FC16, FC23 (writes, then reads, in one request). All throw
    //   DeviceTimeout   silence; the link is clean again
    //   BadAnswer       something that is no answer to this request; the link is clean again
    //   DeviceRefused   a Modbus exception, with its number
    //   ConnectionLost  the peer is gone; every call throws it until reconnect()
    // After the first two, the request may have been carried out or not.
    [[nodiscard]] std::vector<std::uint16_t> read(int address, int registers);
    void write(int address, std::span<const std::uint16_t> words);
    [[nodiscard]] std::vector<std::uint16_t> write_and_read(int write_address, std::span<const std::uint16_t> words, int address,
                                                            int registers);

    // Ends the connection, and tries again for as long as the options say, or until it is to stop. Throws ConnectionLost.
    void reconnect(const StopToken& stop = {});

    [[nodiscard]] bool is_connected() const { return connection_ != nullptr; }
    [[nodiscard]] std::string name() const;           // "unit 1 at 192.168.0.7:502"
    [[nodiscard]] std::string last_exchange() const;  // the last request and its answer, for messages
    [[nodiscard]] const ModbusLinkOptions& options() const { return options_; }

private:
    struct Connection;

    void connect();
    void settle(std::chrono::nanoseconds asked_at);
    void wait_for_gap();
    // Runs a call of libmodbus that returns -1 on failure.
    template <class Call>
    void exchange(const std::string& request, const Call& call);
    [[noreturn]] void fail(int error, std::chrono::nanoseconds asked_at);
    [[noreturn]] void lose(int error);

    ModbusLinkOptions options_;
    Clock& clock_;
    std::unique_ptr<Connection> connection_;  // nothing once it is lost
    std::chrono::nanoseconds free_at_{0};     // RTU: when the line has been quiet for long enough
    std::string request_ = "nothing";
    std::string answer_ = "nothing";
};

}  // namespace palpate
