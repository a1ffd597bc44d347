// A virtual machine whose controller speaks Modbus: libmodbus' own server, over TCP or a pseudo-terminal, in a thread of its own.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "devices/clock.h"
#include "devices/modbus/modbus_link.h"
#include "sim/machines/modbus/virtual_modbus_controller.h"

namespace palpate {

struct VirtualModbusTcp {
    int port = 0;  // 0: any that is free
};

// RTU on a pseudo-terminal.
struct VirtualModbusSerial {
    std::filesystem::path link;  // a symbolic link that is made to it; empty: none
};

// What goes wrong with one answer.
struct AnswerFault {
    enum class Kind : std::uint8_t {
        late,        // the request is carried out at once, its answer comes after `delay`
        lost,        // carried out, but never answered
        other_unit,  // answered under the number of another unit
        exception,   // not carried out; answered by the exception `code`
        hang_up,     // carried out, but the connection ends before the answer; it can be made again at once
        unplug,      // the same, and the cable is out
    };
    Kind kind = Kind::late;
    int nth = 1;  // of the requests from now on, counted from 1
    Seconds delay{0};
    int code = 4;        // 4: server failure
    Seconds lasting{0};  // every request goes wrong so, for so long from that one on
};

class VirtualModbus {
public:
    // `obstacle` must outlive it. Throws std::system_error if the port cannot be had, ConnectionLost if a pseudo-terminal cannot, and as
    // VirtualModbusController does.
    VirtualModbus(const Obstacle& obstacle, const VirtualModbusOptions& options, std::variant<VirtualModbusTcp, VirtualModbusSerial> where,
                  int unit = 1);
    ~VirtualModbus();
    VirtualModbus(const VirtualModbus&) = delete;
    VirtualModbus& operator=(const VirtualModbus&) = delete;
    VirtualModbus(VirtualModbus&&) = delete;
    VirtualModbus& operator=(VirtualModbus&&) = delete;

    // How a driver reaches it.
    [[nodiscard]] ModbusLinkOptions link() const;

    void inject(const AnswerFault& fault);
    // The cable is out: every connection ends, and there is no new one until replug().
    void unplug();
    void replug();
    // Puts bytes into the line as if they were left from an earlier run. REQUIRES: a pseudo-terminal.
    void send_stale(std::span<const std::uint8_t> bytes);
    // Runs `call(controller)` between two requests.
    template <class Call>
    auto with_controller(const Call& call) {
        const std::scoped_lock lock(mutex_);
        return call(controller_);
    }
    [[nodiscard]] std::uint64_t requests() const { return requests_; }

private:
    struct Line;

    void serve(const std::stop_token& stop);
    void plug(bool plugged);
    [[nodiscard]] bool follow_the_plug();
    void answer(int peer, const std::stop_token& stop);
    void reply(int peer, std::span<std::uint8_t> request, const std::stop_token& stop);
    void hang_up(int peer, bool unplug);
    [[nodiscard]] std::optional<int> carry_out(std::span<const std::uint8_t> request, int header);
    [[nodiscard]] std::optional<AnswerFault> next_fault();
    void advance();
    void wait(Seconds time, const std::stop_token& stop);

    std::variant<VirtualModbusTcp, VirtualModbusSerial> where_;  // with the port that was found
    int unit_;
    SteadyClock clock_;
    std::unique_ptr<Line> line_;  // the thread's own once it runs
    mutable std::mutex mutex_;    // guards what follows
    std::condition_variable plug_moved_;
    std::string device_;  // of the pseudo-terminal
    bool wants_plug_ = true;
    bool is_plugged_ = true;
    VirtualModbusController controller_;
    std::chrono::nanoseconds advanced_to_{0};
    struct DueFault {
        AnswerFault fault;
        std::optional<std::chrono::nanoseconds> until{};  // once it has begun
    };
    std::vector<DueFault> faults_;
    std::atomic<std::uint64_t> requests_{0};
    std::jthread thread_;  // ends before the rest
};

}  // namespace palpate
