// A virtual Modbus machine with a sphere in it, and the driver that is tested on it.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "devices/clock.h"
#include "devices/modbus/modbus_device.h"
#include "devices/stop_request.h"
#include "sim/machines/modbus/virtual_modbus.h"
#include "sim/objects/hidden_object.h"

namespace palpate::test {

enum class Wire { tcp, rtu };

inline std::string name_of(Wire wire) { return wire == Wire::tcp ? "Tcp" : "Rtu"; }

constexpr double kRadius = 5.0;              // mm, of the sphere around our origin
inline const Point kOrigin(1.0, -2.0, 3.0);  // of our coordinates in the machine's
inline const Point kStart(20.0, 0.0, 0.0);   // where the tool is at first, in ours
constexpr Seconds kAnswerTimeout{0.1};
constexpr Seconds kSlowestAnswer{0.2};
constexpr Seconds kBusyTime{0.2};

// Moves take a fiftieth of their time, so that tests are short; the heartbeat is watched in ours.
constexpr double kSpeedup = 50.0;

inline VirtualModbusOptions machine_options(double speedup = kSpeedup) {
    VirtualModbusOptions options;
    options.tool.start = kStart + kOrigin;
    options.tool.origin = kOrigin;
    options.tool.limits = {Point::Constant(-40.0), Point::Constant(40.0)};
    options.speedup = speedup;
    return options;
}

class Machine {
public:
    explicit Machine(Wire wire, const VirtualModbusOptions& options = machine_options())
        : object_(ShapeSpec{SphereSpec{kRadius}}), virtual_(object_, options, where(wire)) {}

    [[nodiscard]] ModbusLinkOptions link() const {
        ModbusLinkOptions link = virtual_.link();
        link.answer_timeout = kAnswerTimeout;
        link.slowest_answer = kSlowestAnswer;
        link.reconnects = 3;
        link.reconnect_time = Seconds(0.06);
        link.reconnect_pause = Seconds(0.02);
        link.busy_time = kBusyTime;
        return link;
    }
    [[nodiscard]] ModbusDeviceOptions options() const {
        ModbusDeviceOptions options;
        options.link = link();
        options.origin = kOrigin;
        options.motion.retract_mm = 1.0;
        options.profile.read_write = false;  // so that tests know which request is which; modbus_device_timing_test has the other way
        return options;
    }
    [[nodiscard]] std::unique_ptr<ModbusDevice> device(const StopToken& stop = {}) {
        return std::make_unique<ModbusDevice>(options(), clock_, stop);
    }

    [[nodiscard]] Clock& clock() { return clock_; }
    [[nodiscard]] VirtualModbus& operator*() { return virtual_; }
    [[nodiscard]] VirtualModbus* operator->() { return &virtual_; }
    [[nodiscard]] const HiddenObject& object() const { return object_; }

    [[nodiscard]] VirtualToolAudit audit() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.tool().audit(); });
    }
    [[nodiscard]] bool is_moving() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.tool().is_moving(); });
    }
    // In our coordinates.
    [[nodiscard]] Point tool() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.tool().position(); }) - kOrigin;
    }
    // In our coordinates: where it really is.
    [[nodiscard]] Point true_tool() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.tool().true_position(); }) - kOrigin;
    }
    [[nodiscard]] bool is_probe_closed() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.tool().is_probe_closed(); });
    }
    [[nodiscard]] std::uint64_t commands() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.commands(); });
    }
    [[nodiscard]] std::uint64_t heartbeat_stops() {
        return virtual_.with_controller([](const VirtualModbusController& c) { return c.heartbeat_stops(); });
    }
    void inject(MachineFault fault) {
        virtual_.with_controller([fault](VirtualModbusController& c) { c.inject(fault); });
    }
    void mend() {
        virtual_.with_controller([](VirtualModbusController& c) { c.mend(); });
    }
    void inject(const AnswerFault& fault) { virtual_.inject(fault); }

private:
    // One link for each process: tests run beside each other.
    static std::variant<VirtualModbusTcp, VirtualModbusSerial> where(Wire wire) {
        if (wire == Wire::tcp) return VirtualModbusTcp{};
        static int count = 0;
        return VirtualModbusSerial{std::filesystem::temp_directory_path() /
                                   ("palpate-modbus-" + std::to_string(::getpid()) + "-" + std::to_string(++count))};
    }

    SteadyClock clock_;
    HiddenObject object_;
    VirtualModbus virtual_;
};

inline void expect_safe(Machine& machine) {
    const VirtualToolAudit audit = machine.audit();
    EXPECT_EQ(audit.unsafe_moves, 0U);
    EXPECT_EQ(audit.unguarded_moves, 0U);
    EXPECT_EQ(audit.outside_limits, 0U);
}

// Waits until the tool has gone some way: a moment in mid-move.
inline void wait_until_under_way(Machine& machine, const Point& start, double distance) {
    while ((machine.tool() - start).norm() < distance) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace palpate::test
